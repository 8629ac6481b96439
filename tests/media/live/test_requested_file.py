"""Files that a client asks to be opened: a picture of this machine is, and nothing else."""

import os
import sys

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.live.stream.requested_file import requested_file
from heatlens.media.live.stream.server import TevServer
from support.exr_files import distances, rgb, write_file
from support.tev_peers import client_of, picture, serving, settle, show


@pytest.fixture
def server():
    with serving() as server:
        yield server


def test_an_exr_that_a_client_asks_for_is_the_picture_until_another_comes(server, tmp_path):
    path = write_file(tmp_path / "beauty.exr", rgb() | {"Z": distances()})
    show(server, "a", picture())
    with client_of(server) as client:
        client.open_image(str(path))
    settle(server)
    opened = server.snapshot()
    assert opened.path == path and server.problem is None and server.refused == 0
    np.testing.assert_array_equal(opened.depth_m, distances())
    version = server.version
    write_file(path, rgb() | {"Z": 2 * distances()})
    with client_of(server) as client:
        client.reload_image(str(path))
    settle(server)
    np.testing.assert_array_equal(server.snapshot().depth_m, 2 * distances())
    with client_of(server) as client:
        client.close_image(str(path))
    settle(server)
    assert server.snapshot().path.name == "a" and server.version >= version


def test_a_file_without_depth_is_said(server, tmp_path):
    path = write_file(tmp_path / "flat.exr", rgb())
    with client_of(server) as client:
        client.open_image(str(path))
    settle(server)
    assert server.snapshot() is None and "flat.exr has no depth channel" in server.problem


def test_what_is_no_picture_is_refused_in_a_sentence(server):
    with client_of(server) as client:
        client.open_image("/etc/hostname")
    settle(server)
    assert server.refused == 1 and "only EXR" in server.problem and server.snapshot() is None


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("/tmp/a\x1b[2J.txt", "only EXR"),
        ("a.exr", "full path"),
        ("/no such folder/a.exr", "no such file"),
        ("/a\0.exr", "no such file"),
        ("/" + "x" * 5000 + ".exr", "no such file"),
        ("/tmp", "only EXR"),
        ("", "only EXR"),
    ],
)
def test_names_that_are_refused(name, why):
    with pytest.raises(InputError, match=why) as told:
        requested_file(name, True)
    assert str(told.value).isprintable() and len(str(told.value)) < 400


def test_another_machine_is_refused(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb())
    with pytest.raises(InputError, match="only for clients on this machine"):
        requested_file(str(path), False)


@pytest.mark.skipif(sys.platform == "win32", reason="has no pipes in its folders")
def test_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "a.exr")
    with pytest.raises(InputError, match="no such file"):
        requested_file(str(tmp_path / "a.exr"), True)


def test_a_file_that_an_image_replaces_while_it_is_looked_up_is_still_read(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb() | {"Z": distances()})

    class Replaced(TevServer):
        """A server in which a packet takes the file back right after the first look at it."""

        looks = iter([path])

        @property
        def _file(self):
            assert self._lock.locked()
            return next(self.looks, None)

        @_file.setter
        def _file(self, _file):
            pass

    server = Replaced("127.0.0.1", 0)
    try:
        assert server.snapshot().path == path
    finally:
        server.close()
