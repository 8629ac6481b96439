"""Test files that a tev client asks to open: only images on this machine are opened."""

import os
import sys

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.live.stream.requested_file import check_requested_file
from heatlens.media.live.stream.server import TevServer
from support.exr_files import distances, rgb, write_file
from support.tev_peers import client_of, picture, send_image, settle


def test_tev_open_image_shows_file_until_another_image_comes(server, tmp_path):
    path = write_file(tmp_path / "beauty.exr", rgb() | {"Z": distances()})
    send_image(server, "a", picture())
    with client_of(server) as client:
        client.open_image(str(path))
    settle(server)
    snapshot = server.snapshot()
    assert snapshot.path == path and server.problem is None and server.refused == 0
    np.testing.assert_array_equal(snapshot.depth_m, distances())
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


def test_tev_open_image_reports_file_without_depth(server, tmp_path):
    path = write_file(tmp_path / "flat.exr", rgb())
    with client_of(server) as client:
        client.open_image(str(path))
    settle(server)
    assert server.snapshot() is None and "flat.exr has no depth channel" in server.problem


def test_tev_open_image_refuses_file_that_is_no_exr(server):
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
def test_check_requested_file_rejects_bad_names(name, why):
    with pytest.raises(InputError, match=why) as error:
        check_requested_file(name, is_local=True)
    assert str(error.value).isprintable() and len(str(error.value)) < 400


def test_check_requested_file_rejects_clients_of_other_machines(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb())
    with pytest.raises(InputError, match="only for programs on this machine"):
        check_requested_file(str(path), is_local=False)


@pytest.mark.skipif(sys.platform == "win32", reason="has no pipes in its folders")
def test_check_requested_file_rejects_pipe(tmp_path):
    os.mkfifo(tmp_path / "a.exr")
    with pytest.raises(InputError, match="no such file"):
        check_requested_file(str(tmp_path / "a.exr"), is_local=True)


def test_tev_snapshot_reads_file_that_a_packet_replaces_meanwhile(tmp_path):
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
