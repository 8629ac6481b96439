"""The server against whoever reaches its port, without a session: what is refused, and limits."""

import asyncio
import base64
import contextlib
import http.client
import json
import random
import socket
import struct
import threading

import aiohttp
import numpy as np
import pytest

from heatlens.studio.share import client
from heatlens.studio.share import server as server_file
from heatlens.studio.share.address import Role
from heatlens.studio.share.picture import Picture
from heatlens.studio.share.server import HANDS_MOST, LOOKERS_MOST
from heatlens.studio.share.shared import SharedSession
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
    monkeypatch.setattr(server_file, "REQUEST_S", 0.1)
    made = opened(shared)
    with socket.create_connection(("127.0.0.1", made.port)) as line:
        line.settimeout(20)
        line.sendall(b"GET / HTTP/1.1\r\nHo")
        try:
            assert line.recv(100) == b""
        except ConnectionResetError:
            pass
    made.close()


@pytest.mark.parametrize("asked", [b"", b"GET /wrong/ HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n"])
@pytest.mark.parametrize("role", Role)
def test_strangers_who_hold_200_connections_keep_nobody_out(server, monkeypatch, asked, role):
    """A link is let in at once, at the first try, while they hold them and ask for nothing more."""
    monkeypatch.setattr(server_file, "REQUEST_S", 600.0)  # no stranger is sent away meanwhile
    text = asked % server.port if asked else b""
    lines = []
    for _ in range(200):
        lines.append(socket.create_connection(("127.0.0.1", server.port)))
        lines[-1].sendall(text)

    async def comes_in():
        assert answer(server, f"/{getattr(server.links, role)}/")[0] == 200
        async with peer(server, role) as it:
            await until(lambda: it.hello, "hello")

    asyncio.run(comes_in())
    for line in lines:
        line.close()


def test_a_refusal_ends_its_connection(server):
    for path in ("/wrong/", f"/{server.links.hand}/nothing"):
        with socket.create_connection(("127.0.0.1", server.port)) as line:
            line.settimeout(20)
            line.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n".encode())
            with line.makefile("rb") as file:
                assert b"Connection: close" in file.read()  # which ends, because the server closes


def test_a_page_that_asks_nothing_more_is_let_go(server):
    with socket.create_connection(("127.0.0.1", server.port)) as line:
        line.settimeout(60)
        link = f"/{server.links.look}/main.js"
        line.sendall(f"GET {link} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n".encode())
        with line.makefile("rb") as file:
            assert b"200 OK" in file.read()


@pytest.mark.parametrize(
    "sent", [b"GET / HTTP/1.1\r\n\r\n", b"\x16\x03\x01" * 50, b"PUT * x\r\n\r\n"]
)
def test_nobody_is_told_what_the_server_is_made_of(server, sent):
    with socket.create_connection(("127.0.0.1", server.port)) as line:
        line.settimeout(20)
        line.sendall(sent)
        said = line.recv(65536)
    assert b"aiohttp" not in said and b"Python" not in said
    for path in ("/", f"/{server.links.hand}/", f"/{server.links.hand}/socket"):
        assert answer(server, path)[2]["Server"] == "heatlens"


def test_a_script_that_takes_all_places_makes_room_for_another_address(server, monkeypatch):
    """The latest of the address with the most places goes; two of one address share nothing."""
    addresses = iter(["10.0.0.1"] * LOOKERS_MOST + ["10.0.0.2", "10.0.0.1"])
    monkeypatch.setattr(server_file, "_address_of", lambda request: next(addresses))

    async def play():
        peers = [peer(server, Role.LOOK) for _ in range(LOOKERS_MOST)]
        here = [await it.__aenter__() for it in peers]
        async with peer(server, Role.LOOK) as other:
            await until(lambda: other.hello and here[-1].end == 1008, "the place")
            assert server.who() == (0, LOOKERS_MOST)
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await peer(server, Role.LOOK).__aenter__()
        for it in peers:
            await it.__aexit__(None, None, None)

    asyncio.run(play())


def test_a_client_that_goes_is_no_fault(server, no_fault_is_hidden):
    """It sends pings, takes nothing and resets the connection: no report is written."""
    key = base64.b64encode(bytes(16)).decode()
    head = f"GET /{server.links.look}/socket HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
    head += "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    said = []
    server._log = said.append
    for _ in range(3):
        with socket.create_connection(("127.0.0.1", server.port)) as line:
            line.sendall(f"{head}Sec-WebSocket-Key: {key}\r\n\r\n".encode())
            assert b"101" in line.recv(4096)
            hello = b'{"hello":1}'
            line.sendall(bytes([0x81, 0x80 | len(hello)]) + bytes(4) + hello)
            line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            with contextlib.suppress(OSError):
                line.sendall((bytes([0x89, 0x80 | 100]) + bytes(4) + bytes(100)) * 20_000)
    assert answer(server, f"/{server.links.look}/")[0] == 200
    asyncio.run(until(lambda: server.who() == (0, 0), "their end"))
    assert not [it for it in said if "fault" in it]


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


def test_pictures_are_encoded_on_one_thread(server, shared, monkeypatch):
    """Each thread that encodes keeps memory of its own for as long as the program runs."""
    names, coded = set(), Picture.coded

    def noted(picture, coding):
        names.add(threading.current_thread().name)
        return coded(picture, coding)

    monkeypatch.setattr(Picture, "coded", noted)

    async def play():
        async with contextlib.AsyncExitStack() as here:
            peers = [
                await here.enter_async_context(peer(server, Role.LOOK, width_px=200 * (1 + at)))
                for at in range(6)
            ]
            await until(lambda: all(it.hello for it in peers), "hello")
            for number in range(1, 9):
                pixels = np.full((40, 1200, 4), number, np.uint8)
                shared.publish(shared.state, Picture(number, 1, pixels, True))
                await until(
                    lambda at=number: all(len(it.heads) >= at for it in peers), "the picture"
                )

    asyncio.run(play())
    assert len(names) == 1
