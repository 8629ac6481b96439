"""Test the writer that writes frames in order while others are rendered, with few in memory."""

import threading
import time
import weakref

import pytest

from heatlens.core.base.errors import InputError
from heatlens.deliver.export import frame_files
from heatlens.deliver.export.run import FrameWriter
from heatlens.media.documents.shot_file import write_shot
from support.exports import MANY_FRAMES, export_shot, shot_of, write_plates


def test_frame_writer_keeps_order_and_limits_waiting_frames(rng):
    lock, waiting, most_waiting = threading.Lock(), 0, 0

    def one(number: int):
        def write() -> int:
            nonlocal waiting
            time.sleep(0.002)
            with lock:
                waiting -= 1
            return number

        return write

    written_numbers = []
    with FrameWriter[int]() as writer:
        for number in range(20):
            with lock:
                waiting += 1
                most_waiting = max(most_waiting, waiting)
            written_numbers += writer.put(one(number))
        written_numbers += writer.drain()
    assert written_numbers == list(range(20)) and waiting == 0
    assert 1 < most_waiting <= 4


def test_frame_writer_drops_unstarted_writes_after_error():
    has_started, may_finish, finished_writes = threading.Event(), threading.Event(), []

    def slow() -> int:
        has_started.set()
        may_finish.wait()
        finished_writes.append(0)
        return 0

    with pytest.raises(RuntimeError, match="stop"), FrameWriter[int]() as writer:
        list(writer.put(slow))
        list(writer.put(lambda: finished_writes.append(1) or 1))
        has_started.wait()
        threading.Timer(0.05, may_finish.set).start()
        raise RuntimeError("stop")
    assert finished_writes == [0]


def test_frame_writer_raises_error_of_earlier_write():
    def fail() -> int:
        raise InputError("full")

    with FrameWriter[int]() as writer:
        with pytest.raises(InputError, match="full"):
            list(writer.put(fail))
            list(writer.drain())


def test_export_keeps_at_most_four_frames_in_memory(capsys, tmp_path, monkeypatch):
    """Count the rendered pictures in memory during the export of a long shot."""
    alive: list[weakref.ref] = []
    most_alive = 0
    write = frame_files.write_picture

    def count_and_write(path, pixels, *args, **options):
        nonlocal most_alive
        alive.append(weakref.ref(pixels))
        most_alive = max(most_alive, sum(reference() is not None for reference in alive))
        write(path, pixels, *args, **options)

    monkeypatch.setattr(frame_files, "write_picture", count_and_write)
    write_shot(
        tmp_path / "s.heatlens.json",
        shot_of(write_plates(tmp_path / "plates", MANY_FRAMES), MANY_FRAMES),
    )
    export_shot(capsys, tmp_path / "s.heatlens.json", tmp_path / "n.####.exr")
    assert len(alive) == len(MANY_FRAMES) and most_alive <= 4
