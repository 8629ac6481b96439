"""The thread that looks for new frames of the open sequence."""

import threading
from types import SimpleNamespace

from heatlens.studio.session.opened import open_source
from support.patience import PATIENCE_S


class Cache:
    """Counts how often the disk was scanned; the first scan fails."""

    sequence = SimpleNamespace(frames=())

    def __init__(self):
        self.count, self.again = 0, threading.Event()

    def refresh(self):
        self.count += 1
        if self.count == 1:
            raise OSError("the disk is gone")
        self.again.set()


def test_disk_watch_scans_repeatedly_until_closed_even_after_an_error(monkeypatch):
    monkeypatch.setattr(open_source, "_MIN_PAUSE_S", 0.001)
    watch = open_source.DiskWatch()
    (thread,) = (it for it in threading.enumerate() if it.name == "disk-watch")
    assert thread.daemon  # a disk that hangs does not keep the program
    try:
        watch.cache = cache = Cache()
        assert cache.again.wait(PATIENCE_S)
    finally:
        watch.close()
    thread.join(PATIENCE_S)
    assert not thread.is_alive()


def test_disk_watch_pauses_longer_for_ten_thousand_frames():
    watch = open_source.DiskWatch()
    try:
        assert watch._pause_s() == 2.0
        watch.cache = SimpleNamespace(sequence=SimpleNamespace(frames=range(10_000)))
        assert watch._pause_s() == 5.0
    finally:
        watch.close()
