"""The thread that looks for new frames of the open sequence."""

import threading
from types import SimpleNamespace

from heatlens.studio.session.opened import open_source


class Cache:
    """Counts how often the disk was scanned; the first time it cannot be."""

    sequence = SimpleNamespace(frames=())

    def __init__(self):
        self.count, self.again = 0, threading.Event()

    def refresh(self):
        self.count += 1
        if self.count == 1:
            raise OSError("the disk is gone")
        self.again.set()


def test_the_disk_is_scanned_again_and_again_until_it_is_closed(monkeypatch):
    monkeypatch.setattr(open_source, "_EVERY_S", 0.001)
    watch = open_source.DiskWatch()
    (thread,) = (it for it in threading.enumerate() if it.name == "disk-watch")
    assert thread.daemon  # a disk that hangs does not keep the program
    try:
        watch.cache = cache = Cache()
        assert cache.again.wait(60.0)
    finally:
        watch.close()
    thread.join(60.0)
    assert not thread.is_alive()


def test_a_folder_of_very_many_frames_is_scanned_less_often():
    watch = open_source.DiskWatch()
    try:
        assert watch._pause_s() == 2.0
        watch.cache = SimpleNamespace(sequence=SimpleNamespace(frames=range(10_000)))
        assert watch._pause_s() == 5.0
    finally:
        watch.close()
