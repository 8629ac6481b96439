"""The server against whoever reaches its port, without a session: what is refused, and limits."""

import asyncio
import http.client
import json
import random
import socket

import aiohttp
import pytest

from heatlens.share import client
from heatlens.share import server as server_file
from heatlens.share.address import Role
from heatlens.share.server import HANDS_MOST, LOOKERS_MOST
from heatlens.share.shared import SharedSession
from support.share_peers import opened, peer, until


@pytest.fixture
def shared():
    return SharedSession(state={"frame": 1})


@pytest.fixture
def server(shared):
    made = opened(shared)
    yield made
    made.close()


def answer(server, path, method="GET", **headers):
    """Return status, text and headers of a request."""
    line = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    line.request(method, path, headers=headers)
    got = line.getresponse()
    text = got.read().decode()
    line.close()
    return got.status, text, got.headers


def test_the_page_is_served_with_headers_that_guard_it(server):
    for role in Role:
        status, text, headers = answer(server, f"/{getattr(server.links, role)}/")
        assert status == 200 and "<!doctype html>" in text
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert headers["Referrer-Policy"] == "no-referrer"
        assert headers["Cache-Control"] == "no-store"


@pytest.mark.parametrize(
    "name", ["../links.py", "%2e%2e/links.py", "/etc/passwd", "..%2fa.js", "a", "socket/"]
)
def test_no_request_names_a_file(server, name):
    status, text, _ = answer(server, f"/{server.links.hand}/{name}")
    assert status == 404 and "no such file" in text


@pytest.mark.parametrize(
    "path", ["/", "/index.html", "//", "/wrong/", "/wrong/socket", "/%00/", "/%c3%a9/"]
)
def test_without_a_token_nothing_is_served(server, path):
    status, text, _ = answer(server, path)
    assert status == 404 and "link is wrong" in text


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "evil.example:{port}", "127.0.0.1:1"]
)
def test_another_host_is_refused(server, host):
    host = host.format(port=server.port)
    status, text, _ = answer(server, f"/{server.links.hand}/", Host=host)
    assert status == 421 and "<!doctype" not in text


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1"]
)
def test_a_page_of_another_origin_is_refused(server, origin):
    origin = origin.format(port=server.port)
    for name in ("", "socket"):
        status, _, _ = answer(server, f"/{server.links.hand}/{name}", Origin=origin)
        assert status == 403
    own = f"http://127.0.0.1:{server.port}"
    assert answer(server, f"/{server.links.hand}/", Origin=own)[0] == 200


def test_only_get_is_answered(server):
    assert answer(server, f"/{server.links.hand}/", "POST")[0] == 405
    assert answer(server, f"/{server.links.hand}/socket")[0] == 426


def test_a_connection_that_asks_for_nothing_is_closed(shared, monkeypatch):
    monkeypatch.setattr(server_file, "_REQUEST_S", 0.1)
    made = opened(shared)
    with socket.create_connection(("127.0.0.1", made.port)) as line:
        line.settimeout(20)
        line.sendall(b"GET / HTTP/1.1\r\nHo")
        try:
            assert line.recv(100) == b""
        except ConnectionResetError:
            pass
    made.close()


def test_200_connections_do_not_keep_the_others_out_for_long(shared, monkeypatch):
    monkeypatch.setattr(server_file, "_REQUEST_S", 0.5)
    made = opened(shared)
    lines = [socket.create_connection(("127.0.0.1", made.port)) for _ in range(200)]

    async def comes_in():
        for _ in range(200):
            try:
                async with peer(made) as it:
                    await until(lambda: it.hello, "hello")
                    return
            except aiohttp.ClientError:
                await asyncio.sleep(0.05)
        raise AssertionError("nobody was let in")

    asyncio.run(comes_in())
    for line in lines:
        line.close()
    made.close()


def test_clients_are_limited_by_their_role(server):
    async def play():
        peers = [peer(server, Role.LOOK) for _ in range(LOOKERS_MOST)]
        here = [await it.__aenter__() for it in peers]
        await until(lambda: all(it.hello for it in here), "hello")
        assert server.who() == (0, LOOKERS_MOST)
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await peer(server, Role.LOOK).__aenter__()
        assert refused.value.status == 503
        async with peer(server) as hand:
            await until(lambda: hand.hello, "hello")
        await peers[0].__aexit__(None, None, None)
        await until(lambda: server.who() == (0, LOOKERS_MOST - 1), "the one that went")
        for it in peers[1:]:
            await it.__aexit__(None, None, None)

    assert HANDS_MOST >= 2
    asyncio.run(play())


@pytest.mark.parametrize(
    "first", ["", "[]", '{"hello": 2}', '{"hello": "1"}', '{"do": "Undo"}', "x" * 5000]
)
def test_whoever_says_no_hello_is_sent_away(server, first):
    async def play():
        async with aiohttp.ClientSession() as web:
            async with web.ws_connect(f"{server.link(Role.HAND)}socket") as line:
                await line.send_str(first)
                said = await line.receive(timeout=20)
                assert said.type is aiohttp.WSMsgType.CLOSE and said.data in (1008, 1009)

    asyncio.run(play())


def test_a_looker_turns_nothing_and_is_told_so(server, shared):
    async def play():
        async with peer(server, Role.LOOK) as it:
            await it.send(do="Focus", distance_m=2)
            await until(lambda: it.problems, "a sentence")
            assert "only for watching" in it.problems[0] and it.hello["role"] == "look"

    asyncio.run(play())
    assert not shared.is_asked


def test_who_talks_too_much_is_sent_away(server, monkeypatch):
    monkeypatch.setattr(client, "_A_SECOND", 0.0)

    async def play():
        async with peer(server) as it:
            for _ in range(int(client._BURST) + 10):
                if not it.socket.closed:
                    await it.send(do="Undo")
            await until(lambda: it.end is not None, "the end")
            assert it.end == 1008

    asyncio.run(play())


def test_only_what_has_changed_is_sent(server, shared):
    async def play():
        async with peer(server) as it:
            await until(lambda: it.state.get("frame") == 1, "the state")
            it.state.clear()
            shared.publish({"frame": 1, "title": "b"}, None)
            await until(lambda: it.state, "the change")
            assert it.state == {"title": "b"}
            shared.publish({"frame": 1}, None)
            await until(lambda: it.state["title"] is None, "what has gone")

    asyncio.run(play())


def mutated(rng: random.Random, text: str) -> bytes:
    """Return a message with some bytes changed, cut or doubled."""
    data = bytearray(text.encode())
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(data) + 1)
        how = rng.randrange(4)
        if how == 0 and data:
            data[at % len(data)] = rng.randrange(256)
        elif how == 1:
            del data[at : at + rng.randint(1, 5)]
        elif how == 2:
            data[at:at] = data[: rng.randint(0, 20)]
        else:
            data[at:at] = rng.choice([b"{", b"[", b'"', b"1e999", b"NaN", b"null", b"\\u0000"])
    return bytes(data)


MESSAGES = [
    {"do": "Focus", "distance_m": 2.5},
    {"do": "Pull", "mark": "A", "frames": 12},
    {"change": "lens", "f_stop": 2.8},
    {"change": "view", "exposure_stops": 0.25, "unit": "ft"},
    {"got": 3},
    {"width_px": 1200},
]


def test_mutated_messages_are_answered_in_sentences(server, shared):
    rng = random.Random(7)

    async def play():
        async with peer(server) as it:
            await until(lambda: it.hello, "hello")
            for number in range(150):
                text = mutated(rng, json.dumps(rng.choice(MESSAGES))).decode("utf-8", "replace")
                await it.socket.send_str(text)
                if number % 25 == 0:
                    await asyncio.sleep(0.01)
            await it.socket.send_bytes(b"\0\1")
            await until(lambda: it.problems and "text" in it.problems[-1], "the last answer")
            assert it.end is None

    asyncio.run(play())
