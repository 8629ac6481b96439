"""The server without a session: refused requests, and limits for clients that reach its port."""

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
from heatlens.studio.share.server import MOST_HANDS, MOST_LOOKERS
from heatlens.studio.share.shared import SharedSession
from support.patience import PATIENCE_S
from support.share_peers import connected_peer, start_server, wait_for_condition


@pytest.fixture
def shared():
    return SharedSession(state={"frame": 1})


@pytest.fixture
def server(shared):
    new_server = start_server(shared)
    yield new_server
    new_server.close()


def answer(server, path, method="GET", **headers):
    """Return status, text and headers of a request."""
    line = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE_S)
    line.request(method, path, headers=headers)
    response = line.getresponse()
    text = response.read().decode()
    line.close()
    return response.status, text, response.headers


def test_server_sends_the_page_with_security_headers(server):
    for role in Role:
        status, text, headers = answer(server, f"/{getattr(server.links, role)}/")
        assert status == 200 and "<!doctype html>" in text
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert headers["Referrer-Policy"] == "no-referrer"
        assert headers["Cache-Control"] == "no-store"


@pytest.mark.parametrize(
    "name", ["../links.py", "%2e%2e/links.py", "/etc/passwd", "..%2fa.js", "a", "socket/"]
)
def test_server_refuses_paths_of_files_that_are_not_of_the_page(server, name):
    status, text, _ = answer(server, f"/{server.links.hand}/{name}")
    assert status == 404 and "no such file" in text


@pytest.mark.parametrize(
    "path", ["/", "/index.html", "//", "/wrong/", "/wrong/socket", "/%00/", "/%c3%a9/"]
)
def test_server_refuses_requests_without_a_token(server, path):
    status, text, _ = answer(server, path)
    assert status == 404 and "link is wrong" in text


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "evil.example:{port}", "127.0.0.1:1"]
)
def test_server_refuses_another_host_header(server, host):
    host = host.format(port=server.port)
    status, text, _ = answer(server, f"/{server.links.hand}/", Host=host)
    assert status == 421 and "<!doctype" not in text


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1"]
)
def test_server_refuses_requests_of_another_origin(server, origin):
    origin = origin.format(port=server.port)
    for name in ("", "socket"):
        status, _, _ = answer(server, f"/{server.links.hand}/{name}", Origin=origin)
        assert status == 403
    own_origin = f"http://127.0.0.1:{server.port}"
    assert answer(server, f"/{server.links.hand}/", Origin=own_origin)[0] == 200


def test_server_answers_get_only(server):
    assert answer(server, f"/{server.links.hand}/", "POST")[0] == 405
    assert answer(server, f"/{server.links.hand}/socket")[0] == 426


def test_server_closes_a_connection_with_an_incomplete_request(shared, monkeypatch):
    monkeypatch.setattr(server_file, "FIRST_REQUEST_S", 0.1)
    new_server = start_server(shared)
    with socket.create_connection(("127.0.0.1", new_server.port)) as line:
        line.settimeout(20)
        line.sendall(b"GET / HTTP/1.1\r\nHo")
        try:
            assert line.recv(100) == b""
        except ConnectionResetError:
            pass
    new_server.close()


@pytest.mark.parametrize("asked", [b"", b"GET /wrong/ HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n"])
@pytest.mark.parametrize("role", Role)
def test_client_with_link_connects_while_strangers_hold_200_connections(
    server, monkeypatch, asked, role
):
    """A client with a link connects at the first try while strangers hold 200 connections."""
    monkeypatch.setattr(server_file, "FIRST_REQUEST_S", 600.0)  # no stranger is sent away meanwhile
    text = asked % server.port if asked else b""
    lines = []
    for _ in range(200):
        lines.append(socket.create_connection(("127.0.0.1", server.port)))
        lines[-1].sendall(text)

    async def connect():
        assert answer(server, f"/{getattr(server.links, role)}/")[0] == 200
        async with connected_peer(server, role) as it:
            await wait_for_condition(lambda: it.hello, "hello")

    asyncio.run(connect())
    for line in lines:
        line.close()


def test_server_closes_the_connection_after_a_refusal(server):
    for path in ("/wrong/", f"/{server.links.hand}/nothing"):
        with socket.create_connection(("127.0.0.1", server.port)) as line:
            line.settimeout(20)
            line.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n".encode())
            with line.makefile("rb") as file:
                assert b"Connection: close" in file.read()  # which ends, because the server closes


def test_server_closes_an_idle_connection_of_a_page(server):
    with socket.create_connection(("127.0.0.1", server.port)) as line:
        line.settimeout(60)
        link = f"/{server.links.look}/main.js"
        line.sendall(f"GET {link} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n".encode())
        with line.makefile("rb") as file:
            assert b"200 OK" in file.read()


@pytest.mark.parametrize(
    "sent", [b"GET / HTTP/1.1\r\n\r\n", b"\x16\x03\x01" * 50, b"PUT * x\r\n\r\n"]
)
def test_server_header_names_neither_aiohttp_nor_python(server, sent):
    with socket.create_connection(("127.0.0.1", server.port)) as line:
        line.settimeout(20)
        line.sendall(sent)
        response = line.recv(65536)
    assert b"aiohttp" not in response and b"Python" not in response
    for path in ("/", f"/{server.links.hand}/", f"/{server.links.hand}/socket"):
        assert answer(server, path)[2]["Server"] == "heatlens"


def test_full_server_frees_a_place_for_another_address(server, monkeypatch):
    """The latest client of the address with the most places has to go, for another address only."""
    addresses = iter(["10.0.0.1"] * MOST_LOOKERS + ["10.0.0.2", "10.0.0.1"])
    monkeypatch.setattr(server_file, "_client_address", lambda request: next(addresses))

    async def play():
        peers = [connected_peer(server, Role.LOOK) for _ in range(MOST_LOOKERS)]
        here = [await it.__aenter__() for it in peers]
        async with connected_peer(server, Role.LOOK) as other:
            await wait_for_condition(lambda: other.hello and here[-1].end == 1008, "the place")
            assert server.count_clients() == (0, MOST_LOOKERS)
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await connected_peer(server, Role.LOOK).__aenter__()
        for it in peers:
            await it.__aexit__(None, None, None)

    asyncio.run(play())


def test_reset_connection_of_a_client_is_not_logged_as_a_fault(server, no_fault_is_hidden):
    """The client sends pings, reads nothing and resets the connection; no fault is logged."""
    key = base64.b64encode(bytes(16)).decode()
    head = f"GET /{server.links.look}/socket HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
    head += "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    log = []
    server._log = log.append
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
    asyncio.run(wait_for_condition(lambda: server.count_clients() == (0, 0), "their end"))
    assert not [it for it in log if "fault" in it]


def test_server_limits_clients_of_each_role(server):
    async def play():
        peers = [connected_peer(server, Role.LOOK) for _ in range(MOST_LOOKERS)]
        here = [await it.__aenter__() for it in peers]
        await wait_for_condition(lambda: all(it.hello for it in here), "hello")
        assert server.count_clients() == (0, MOST_LOOKERS)
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await connected_peer(server, Role.LOOK).__aenter__()
        assert refused.value.status == 503
        async with connected_peer(server) as hand:
            await wait_for_condition(lambda: hand.hello, "hello")
        await peers[0].__aexit__(None, None, None)
        await wait_for_condition(
            lambda: server.count_clients() == (0, MOST_LOOKERS - 1), "the one that went"
        )
        for it in peers[1:]:
            await it.__aexit__(None, None, None)

    assert MOST_HANDS >= 2
    asyncio.run(play())


@pytest.mark.parametrize(
    "first", ["", "[]", '{"hello": 2}', '{"hello": "1"}', '{"do": "Undo"}', "x" * 5000]
)
def test_server_closes_a_socket_without_a_valid_hello(server, first):
    async def play():
        async with aiohttp.ClientSession() as web:
            async with web.ws_connect(f"{server.link(Role.HAND)}socket") as line:
                await line.send_str(first)
                answer = await line.receive(timeout=PATIENCE_S)
                assert answer.type is aiohttp.WSMsgType.CLOSE and answer.data in (1008, 1009)

    asyncio.run(play())


def test_server_refuses_lens_messages_of_a_look_link(server, shared):
    async def play():
        async with connected_peer(server, Role.LOOK) as it:
            await it.send(do="Focus", distance_m=2)
            await wait_for_condition(lambda: it.problems, "a sentence")
            assert "only for watching" in it.problems[0] and it.hello["role"] == "look"

    asyncio.run(play())
    assert not shared.has_messages


def test_server_closes_a_client_that_sends_too_many_messages(server, monkeypatch):
    monkeypatch.setattr(client, "_MESSAGES_PER_SECOND", 0.0)

    async def play():
        async with connected_peer(server) as it:
            for _ in range(int(client._MESSAGE_BURST) + 10):
                if not it.socket.closed:
                    await it.send(do="Undo")
            await wait_for_condition(lambda: it.end is not None, "the end")
            assert it.end == 1008

    asyncio.run(play())


def test_server_sends_only_changed_entries_of_the_state(server, shared):
    async def play():
        async with connected_peer(server) as it:
            await wait_for_condition(lambda: it.state.get("frame") == 1, "the state")
            it.state.clear()
            shared.publish({"frame": 1, "title": "b"}, None)
            await wait_for_condition(lambda: it.state, "the change")
            assert it.state == {"title": "b"}
            shared.publish({"frame": 1}, None)
            await wait_for_condition(lambda: it.state["title"] is None, "what has gone")

    asyncio.run(play())


def plain_picture(number: int, width: int = 1200) -> Picture:
    return Picture(number, 1, np.full((40, width, 4), number, np.uint8), is_whole=True)


def test_client_resized_before_it_acknowledges_gets_the_picture_again(server, shared):
    """A page is often resized while its first whole picture is on its way."""

    async def play():
        async with connected_peer(server, width_px=160) as it:
            it.acknowledges = False
            shared.publish(shared.state, plain_picture(1))
            await wait_for_condition(lambda: it.heads, "the small picture")
            await it.send(width_px=800)
            await it.send(got=1)
            await wait_for_condition(lambda: len(it.heads) == 2, "the large picture")
            assert it.pixels.shape[1] == 800

    asyncio.run(play())


def test_picture_published_while_state_is_sent_comes_after_its_own_state(
    server, shared, monkeypatch
):
    send_state = client.Client._send_state

    async def publish_and_send(self, state):
        if shared.picture is None:
            shared.publish({"lens": "new"}, plain_picture(1))
        await send_state(self, state)

    monkeypatch.setattr(client.Client, "_send_state", publish_and_send)

    async def play():
        async with connected_peer(server) as it:
            await wait_for_condition(lambda: it.heads, "the picture")
            assert it.state["lens"] == "new"

    asyncio.run(play())


def mutate(rng: random.Random, text: str) -> bytes:
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


def test_server_answers_mutated_messages_and_keeps_the_connection(server, shared):
    rng = random.Random(7)

    async def play():
        async with connected_peer(server) as it:
            await wait_for_condition(lambda: it.hello, "hello")
            for number in range(150):
                text = mutate(rng, json.dumps(rng.choice(MESSAGES))).decode("utf-8", "replace")
                await it.socket.send_str(text)
                if number % 25 == 0:
                    await asyncio.sleep(0.01)
            await it.socket.send_bytes(b"\0\1")
            await wait_for_condition(
                lambda: it.problems and "text" in it.problems[-1], "the last answer"
            )
            assert it.end is None

    asyncio.run(play())


def test_server_encodes_pictures_on_one_thread(server, shared, monkeypatch):
    """Each thread that encodes keeps memory of its own for as long as the program runs."""
    thread_names, coded = set(), Picture.encode

    def record_thread(picture, coding):
        thread_names.add(threading.current_thread().name)
        return coded(picture, coding)

    monkeypatch.setattr(Picture, "encode", record_thread)

    async def play():
        async with contextlib.AsyncExitStack() as here:
            peers = [
                await here.enter_async_context(
                    connected_peer(server, Role.LOOK, width_px=200 * (1 + at))
                )
                for at in range(6)
            ]
            await wait_for_condition(lambda: all(it.hello for it in peers), "hello")
            for number in range(1, 9):
                shared.publish(shared.state, plain_picture(number))
                await wait_for_condition(
                    lambda at=number: all(len(it.heads) >= at for it in peers), "the picture"
                )

    asyncio.run(play())
    assert len(thread_names) == 1
