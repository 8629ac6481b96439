"""Test reading ahead: which frames are read, which are dropped, and how it ends."""

import threading
from pathlib import Path

import pytest

from heatlens.media.frame_cache.cache import Damaged, FrameCache
from support.frame_caches import (
    PLATE_BYTES,
    Reader,
    ReadyEvent,
    frame_of,
    frames_in_state,
    sequence_of,
    wait_until_idle,
)
from support.patience import PATIENCE_S


def test_frame_cache_reads_playhead_first_and_then_frames_ahead():
    reader, news = Reader(), ReadyEvent()
    with FrameCache(
        sequence=sequence_of(range(10)),
        read=reader,
        budget_bytes=100 * PLATE_BYTES,
        workers=1,
        on_ready=news,
    ) as cache:
        assert set(cache.states().values()) == {"absent"}
        cache.set_playhead(8, direction=1, window=3)
        news.wait_until(lambda: len(frames_in_state(cache.states(), "ready")) == 4)
        cache.set_playhead(4, direction=-1, window=2)
        news.wait_until(lambda: len(frames_in_state(cache.states(), "ready")) == 7)
    assert reader.begun == [8, 9, 0, 1, 4, 3, 2]


def test_frame_cache_want_does_not_wait_for_a_read():
    reader, news = Reader(), ReadyEvent()
    with FrameCache(
        sequence=sequence_of(range(10)),
        read=reader,
        budget_bytes=3 * PLATE_BYTES,
        workers=2,
        on_ready=news,
    ) as cache:
        cache.read_and_wait(0, direction=1, window=0)
        reader.gate.clear()
        cache.set_playhead(3, direction=1, window=3)
        news.wait_until(lambda: len(reader.begun) == 3)
        assert cache.get(3) is None
        states = cache.states()
        assert frames_in_state(states, "reading") == [3, 4] and frames_in_state(
            states, "queued"
        ) == [5, 6]
        cache.set_playhead(7, direction=1, window=0)  # waits for a thread
        assert frames_in_state(cache.states(), "queued") == [7]
        reader.gate.set()
        news.wait_until(lambda: cache.get(7) is not None)
    assert set(reader.begun[1:3]) == {3, 4} and reader.begun[3] == 7


def test_frame_cache_drops_frames_behind_for_frames_ahead():
    reader, news = Reader(), ReadyEvent()
    with FrameCache(
        sequence=sequence_of(range(20)),
        read=reader,
        budget_bytes=4 * PLATE_BYTES,
        workers=1,
        on_ready=news,
    ) as cache:
        for frame in range(20):
            cache.set_playhead(frame, direction=1, window=2)
            wait_until_idle(cache, news)
            assert {(frame + step) % 20 for step in range(3)} <= set(
                frames_in_state(cache.states(), "ready")
            )
        assert set(frames_in_state(cache.states(), "ready")) == {18, 19, 0, 1}
    assert reader.begun == [*range(20), 0, 1]


def test_frame_cache_without_keeps_seen_drops_every_frame_played():
    reader, news = Reader(), ReadyEvent()
    frames = sequence_of(range(20))
    with FrameCache(
        frames, reader, budget_bytes=100 * PLATE_BYTES, workers=1, on_ready=news, keeps_passed=False
    ) as cache:
        for frame in range(18):
            cache.set_playhead(frame, direction=1, window=2)
            wait_until_idle(cache, news)
            assert set(frames_in_state(cache.states(), "ready")) == {frame, frame + 1, frame + 2}
            assert cache.bytes_in_use == 3 * PLATE_BYTES
    assert reader.begun == [*range(20)]


def test_frame_cache_holds_playhead_frame_larger_than_budget():
    reader, news = Reader(pixels=lambda frame: 50 if frame == 3 else 1), ReadyEvent()
    sequence = sequence_of(range(7), {0, 1, 2, 3, 4, 5})
    with FrameCache(sequence, read=reader, budget_bytes=4 * PLATE_BYTES, on_ready=news) as cache:
        cache.read_and_wait(2, direction=1, window=0)
        assert frame_of(cache.read_and_wait(3, direction=1, window=4)) == 3
        wait_until_idle(cache, news)
        assert frames_in_state(cache.states(), "ready") == [3]
        cache.set_playhead(
            6, direction=-1, window=0
        )  # a frame without a file makes no room of its own
        assert cache.bytes_in_use == 0
        cache.set_playhead(4, direction=1, window=1)
        news.wait_until(lambda: frames_in_state(cache.states(), "ready") == [4, 5])
        assert cache.bytes_in_use <= 4 * PLATE_BYTES


def test_frame_cache_does_not_read_or_wait_for_missing_frames():
    reader, news = Reader(), ReadyEvent()
    with FrameCache(sequence_of(range(5), {0, 3}), reader, 9 * PLATE_BYTES, on_ready=news) as cache:
        assert cache.read_and_wait(1, direction=1, window=4) is None
        assert cache.read_and_wait(99) is None
        news.wait_until(lambda: frames_in_state(cache.states(), "ready") == [0, 3])
        assert frames_in_state(cache.states(), "missing") == [1, 2, 4]
    assert sorted(reader.begun) == [0, 3]


def test_frame_cache_reads_damaged_frame_once_and_gives_reason():
    reader = Reader(damaged={2})
    with FrameCache(sequence_of(range(4)), reader, 9 * PLATE_BYTES) as cache:
        for _ in range(3):
            assert cache.read_and_wait(2, direction=1, window=0) == Damaged(
                Path("nowhere/a.0002.exr"), cache.get(2).sentence
            )
            assert "is damaged" in cache.get(2).sentence
            cache.read_and_wait(1, direction=1, window=3)
        assert cache.states()[2] == "damaged"
    assert reader.begun.count(2) == 1


def test_frame_cache_raises_error_of_reader_in_caller():
    def read(path):
        raise ZeroDivisionError(path.name)

    news = ReadyEvent()
    with FrameCache(sequence_of(range(4)), read, 9 * PLATE_BYTES, on_ready=news) as cache:
        with pytest.raises(ZeroDivisionError, match="0001"):
            cache.read_and_wait(1)
        for ask in (
            cache.get,
            cache.set_playhead,
            cache.read_and_wait,
            lambda frame: cache.refresh(),
        ):
            with pytest.raises(ZeroDivisionError):
                ask(2)


def test_frame_cache_repeated_error_does_not_grow_its_traceback():
    def fault(path):
        raise ZeroDivisionError

    cache, lengths = FrameCache(sequence_of([1]), fault, 99 * PLATE_BYTES), set()
    for _ in range(5):
        with pytest.raises(ZeroDivisionError) as raised:
            cache.read_and_wait(1)
        lengths.add(len(raised.traceback))
    assert max(lengths) - min(lengths) <= 1  # the first comes out of the wait itself
    cache.close()


def test_frame_cache_raises_error_of_listener_in_caller():
    with FrameCache(
        sequence=sequence_of(range(4)),
        read=Reader(),
        budget_bytes=9 * PLATE_BYTES,
        on_ready=lambda: 1 / 0,
    ) as cache:
        cache.set_playhead(1)
        with pytest.raises(ZeroDivisionError):
            ReadyEvent().wait_until(lambda: cache.get(99))


def cache_threads():
    return [t for t in threading.enumerate() if t.name.startswith("frame-cache")]


def test_frame_cache_close_does_not_wait_for_reads_and_wakes_waiters():
    reader, news, results = Reader(), ReadyEvent(), []
    reader.gate.clear()
    cache = FrameCache(sequence_of(range(50)), reader, 99 * PLATE_BYTES, workers=3, on_ready=news)
    waiter = threading.Thread(
        target=lambda: results.append(cache.read_and_wait(7, direction=1, window=40))
    )
    waiter.start()
    news.wait_until(lambda: reader.begun)
    reading = cache_threads()
    cache.close()  # returns although the read never ends before the gate opens
    waiter.join(PATIENCE_S)
    assert results == [None] and reading
    reader.gate.set()
    for thread in reading:
        thread.join(PATIENCE_S)
    assert reader.begun == [7] and cache.bytes_in_use == 0
    cache.set_playhead(1)
    cache.refresh()
    cache.close()
    assert cache.get(7) is None and not cache_threads()


def test_frame_cache_close_frees_its_frames():
    cache = FrameCache(sequence=sequence_of(range(5)), read=Reader(), budget_bytes=99 * PLATE_BYTES)
    assert cache.read_and_wait(2) is not None and cache.bytes_in_use
    cache.close()
    assert cache.get(2) is None
