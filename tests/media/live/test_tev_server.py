"""Test connections to the tev server: who is answered, who is closed, where it listens."""

import os
import socket
import sys
import time

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.live.stream.address import parse_address
from heatlens.media.live.stream.server import MAX_CLIENTS, NOTIFICATIONS_A_SECOND, TevServer
from support.tev_peers import (
    CHANNELS,
    assert_shows,
    client_of,
    picture,
    send_image,
    serving,
    settle,
    wait_until,
)


@pytest.mark.parametrize("start", [b"GET / HTTP/1.1\r\n", b"\xff" * 8, b"\3\0\0\0", bytes(9)])
def test_tev_server_closes_connection_without_packets(server, start):
    with socket.create_connection(server.address) as connection:
        connection.sendall(start)
        connection.settimeout(10)
        try:
            assert connection.recv(1) == b""
        except ConnectionError:
            pass  # as good an end: bytes were left unread
    send_image(server, "a", picture())
    assert server.dropped == 1 and server.snapshot() is not None


def test_tev_server_drops_silent_clients_beyond_limit(server):
    silent = [socket.create_connection(server.address) for _ in range(2 * MAX_CLIENTS)]
    wait_until(lambda: len(server._clients) == MAX_CLIENTS)
    with client_of(server) as client:
        client.create_image("a", 9, 6, CHANNELS)
        client.update_image("a", picture(), CHANNELS)
        wait_until(lambda: server.snapshot() is not None)
    assert len(server._clients) <= MAX_CLIENTS
    for connection in silent:
        connection.close()


@pytest.mark.skipif(sys.platform == "win32", reason="counts no file handles")
def test_tev_server_keeps_client_waiting_while_no_file_handle_is_free(server):
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with socket.socket() as late_socket:
        free = os.dup(late_socket.fileno())  # the lowest one
        os.close(free)
        resource.setrlimit(resource.RLIMIT_NOFILE, (free, hard))
        try:
            late_socket.connect(server.address)
            wait_until(lambda: server.fault is not None)
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        assert "could not be accepted" in server.fault
        wait_until(lambda: server._clients)
    send_image(server, "a", picture())
    assert_shows(server.snapshot(), picture())


def test_tev_server_limits_rate_of_news():
    news_times = []
    start = time.monotonic()
    with serving(on_news=lambda: news_times.append(time.monotonic())) as server:
        with client_of(server) as client:
            client.create_image("a", 9, 6, CHANNELS)
            for _ in range(400):
                client.update_image("a", picture(), CHANNELS)
        settle(server)
        wait_until(lambda: not (server._has_changed_images or server._has_new_fault))
        assert_shows(server.snapshot(), picture())
        last = len(news_times)
    assert 1 <= last <= 2 + (news_times[-1] - start) * NOTIFICATIONS_A_SECOND
    assert np.diff(news_times).min() > 0.9 / NOTIFICATIONS_A_SECOND


@pytest.mark.skipif(sys.platform != "linux", reason="all of 127.0.0.0/8 is this machine on Linux")
def test_tev_server_listens_only_on_its_address(server):
    assert server.address[0] == "127.0.0.1"
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", server.address[1]), 5)


def test_tev_server_close_frees_port_and_ends_connections():
    server = TevServer(port=0)
    with pytest.raises(InputError, match="Cannot listen"):
        TevServer(port=server.address[1])
    with socket.create_connection(server.address) as connection:
        wait_until(lambda: server._clients)
        server.close()
        server.close()
        assert connection.recv(1) == b""
    TevServer(port=server.address[1]).close()


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("14158", ("127.0.0.1", 14158)),
        ("0", ("127.0.0.1", 0)),
        ("0.0.0.0:99", ("0.0.0.0", 99)),
        ("render-3:65535", ("render-3", 65535)),
        ("[::1]:14158", ("::1", 14158)),
    ],
)
def test_parse_address_reads_host_and_port(text, address):
    assert parse_address(text) == address


@pytest.mark.parametrize(
    "text", ["", ":", ":14158", "host", "host:", "::1", "1:65536", "a:-1", "a:²"]
)
def test_parse_address_rejects_text_that_is_no_address(text):
    with pytest.raises(InputError, match="not an address to listen on"):
        parse_address(text)
