"""Frames are written while others are rendered: in order, and few in memory."""

import threading
import time
import weakref

import pytest

from heatlens.core.base.errors import InputError
from heatlens.deliver.export import frame_files
from heatlens.deliver.export.run import FrameWriter
from heatlens.media.documents.shot_file import write_shot
from support.exports import MANY, exported, shot_of, write_plates


def test_the_writer_keeps_the_order_and_no_more_than_it_may(rng):
    lock, waiting, most = threading.Lock(), 0, 0

    def one(number: int):
        def write() -> int:
            nonlocal waiting
            time.sleep(0.002)
            with lock:
                waiting -= 1
            return number

        return write

    found = []
    with FrameWriter[int]() as writer:
        for number in range(20):
            with lock:
                waiting += 1
                most = max(most, waiting)
            found += writer.put(one(number))
        found += writer.drain()
    assert found == list(range(20)) and waiting == 0
    assert 1 < most <= 4


def test_a_writer_left_by_an_error_drops_what_has_not_begun():
    begun, go_on, done = threading.Event(), threading.Event(), []

    def slow() -> int:
        begun.set()
        go_on.wait()
        done.append(0)
        return 0

    with pytest.raises(RuntimeError, match="stop"), FrameWriter[int]() as writer:
        list(writer.put(slow))
        list(writer.put(lambda: done.append(1) or 1))
        begun.wait()
        threading.Timer(0.05, go_on.set).start()
        raise RuntimeError("stop")
    assert done == [0]


def test_what_writing_raises_comes_out_of_the_next_step():
    def fail() -> int:
        raise InputError("full")

    with FrameWriter[int]() as writer:
        with pytest.raises(InputError, match="full"):
            list(writer.put(fail))
            list(writer.drain())


def test_frames_are_let_go_of_while_the_export_runs(capsys, tmp_path, monkeypatch):
    """However long the shot, a handful of rendered frames are in memory."""
    alive: list[weakref.ref] = []
    most = 0
    write = frame_files.write_picture

    def counted(path, pixels, *args, **options):
        nonlocal most
        alive.append(weakref.ref(pixels))
        most = max(most, sum(reference() is not None for reference in alive))
        write(path, pixels, *args, **options)

    monkeypatch.setattr(frame_files, "write_picture", counted)
    write_shot(tmp_path / "s.heatlens.json", shot_of(write_plates(tmp_path / "plates", MANY), MANY))
    exported(capsys, tmp_path / "s.heatlens.json", tmp_path / "n.####.exr")
    assert len(alive) == len(MANY) and most <= 4
