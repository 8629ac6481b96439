"""Both ends of a tev connection for tests: a server, the real client, and handmade packets."""

import socket
import struct
import time
from contextlib import contextmanager

import numpy as np
from tevclient import Ipc

from heatlens.media.live.stream.server import TevServer
from support.patience import PATIENCE_S

CHANNELS = ["R", "G", "B", "Z"]


@contextmanager
def serving(**arguments):
    """Yield a server at a port of its own, and check its end."""
    with TevServer(port=0, **arguments) as server:
        yield server
        assert server._thread.is_alive()
    assert not server._thread.is_alive()


def client_of(server):
    """Return the real client."""
    return Ipc(*server.address)


def wait_until(predicate):
    end = time.monotonic() + PATIENCE_S
    while not predicate():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.002)


def settle(server):
    """Wait until the server has processed everything sent on closed connections.

    Connections are taken in turn: once a later one is finished, so are they, or being read.
    """
    with socket.create_connection(server.address) as connection:
        connection.shutdown(socket.SHUT_WR)
        assert connection.recv(1) == b""
    wait_until(lambda: not server._clients)


def send(server, data):
    """Send the bytes on a connection of their own.

    The server may hang up before they are through.
    """
    with socket.create_connection(server.address) as connection:
        try:
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            while connection.recv(1024):
                pass
        except OSError:
            return


def packet(operation, *fields):
    """Return a packet: text ends in zero, integers are int32, bytes stay as they are."""
    body = bytes([operation])
    for field in fields:
        if isinstance(field, bool):
            body += bytes([field])
        elif isinstance(field, int):
            body += struct.pack("<i", field)
        else:
            body += field.encode() + b"\0" if isinstance(field, str) else bytes(field)
    return struct.pack("<I", 4 + len(body)) + body


def picture(width=9, height=6, far_m=50.0):
    """Return (H, W, 4): three colours and a depth in metres, every value different."""
    values = np.arange(width * height * 4, dtype=np.float32).reshape(height, width, 4)
    values[..., 3] = np.linspace(1.5, far_m, width * height, dtype=np.float32).reshape(height, -1)
    return values


def send_image(server, name, values, channels=CHANNELS):
    """Create and fill an image with the real client, and wait until it is there."""
    with client_of(server) as client:
        client.create_image(name, values.shape[1], values.shape[0], list(channels))
        client.update_image(name, values, list(channels))
    settle(server)


def assert_shows(plate, values):
    """Check that the plate holds exactly these colours and this depth."""
    np.testing.assert_array_equal(plate.color[..., :3], values[..., :3])
    np.testing.assert_array_equal(plate.depth_m, values[..., 3])
