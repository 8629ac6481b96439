"""Reading ahead: what is read when, what is given up for it, and how it ends."""

import threading
from pathlib import Path

import pytest

from heatlens.media.frame_cache.cache import Damaged, FrameCache
from support.frame_caches import (
    ONE,
    PATIENCE_S,
    News,
    Reader,
    at_rest,
    frame_of,
    names,
    sequence_of,
)


def test_the_playhead_is_read_first_then_what_lies_ahead():
    reader, news = Reader(), News()
    with FrameCache(sequence_of(range(10)), reader, 100 * ONE, workers=1, on_ready=news) as cache:
        assert set(cache.states().values()) == {"absent"}
        cache.want(8, 1, 3)
        news.wait_until(lambda: len(names(cache.states(), "ready")) == 4)
        cache.want(4, -1, 2)
        news.wait_until(lambda: len(names(cache.states(), "ready")) == 7)
    assert reader.begun == [8, 9, 0, 1, 4, 3, 2]


def test_asking_never_waits_for_a_read():
    reader, news = Reader(), News()
    with FrameCache(sequence_of(range(10)), reader, 3 * ONE, workers=2, on_ready=news) as cache:
        cache.wait(0, 1, 0)
        reader.gate.clear()
        cache.want(3, 1, 3)
        news.wait_until(lambda: len(reader.begun) == 3)
        assert cache.get(3) is None
        states = cache.states()
        assert names(states, "reading") == [3, 4] and names(states, "queued") == [5, 6]
        cache.want(7, 1, 0)  # waits for a thread
        assert names(cache.states(), "queued") == [7]
        reader.gate.set()
        news.wait_until(lambda: cache.get(7) is not None)
    assert set(reader.begun[1:3]) == {3, 4} and reader.begun[3] == 7


def test_frames_behind_are_given_up_for_those_ahead():
    reader, news = Reader(), News()
    with FrameCache(sequence_of(range(20)), reader, 4 * ONE, workers=1, on_ready=news) as cache:
        for frame in range(20):
            cache.want(frame, 1, 2)
            at_rest(cache, news)
            assert {(frame + step) % 20 for step in range(3)} <= set(names(cache.states(), "ready"))
        assert set(names(cache.states(), "ready")) == {18, 19, 0, 1}
    assert reader.begun == [*range(20), 0, 1]


def test_who_never_comes_back_keeps_no_frame_that_was_seen():
    reader, news = Reader(), News()
    frames = sequence_of(range(20))
    with FrameCache(frames, reader, 100 * ONE, 1, news, keeps_seen=False) as cache:
        for frame in range(18):
            cache.want(frame, 1, 2)
            at_rest(cache, news)
            assert set(names(cache.states(), "ready")) == {frame, frame + 1, frame + 2}
            assert cache.bytes_in_use == 3 * ONE
    assert reader.begun == [*range(20)]


def test_a_frame_larger_than_the_budget_is_shown_all_the_same():
    reader, news = Reader(pixels=lambda frame: 50 if frame == 3 else 1), News()
    sequence = sequence_of(range(7), {0, 1, 2, 3, 4, 5})
    with FrameCache(sequence, reader, 4 * ONE, on_ready=news) as cache:
        cache.wait(2, 1, 0)
        assert frame_of(cache.wait(3, 1, 4)) == 3
        at_rest(cache, news)
        assert names(cache.states(), "ready") == [3]
        cache.want(6, -1, 0)  # a frame without a file makes no room of its own
        assert cache.bytes_in_use == 0
        cache.want(4, 1, 1)
        news.wait_until(lambda: names(cache.states(), "ready") == [4, 5])
        assert cache.bytes_in_use <= 4 * ONE


def test_missing_frames_are_neither_read_nor_waited_for():
    reader, news = Reader(), News()
    with FrameCache(sequence_of(range(5), {0, 3}), reader, 9 * ONE, on_ready=news) as cache:
        assert cache.wait(1, 1, 4) is None
        assert cache.wait(99) is None
        news.wait_until(lambda: names(cache.states(), "ready") == [0, 3])
        assert names(cache.states(), "missing") == [1, 2, 4]
    assert sorted(reader.begun) == [0, 3]


def test_a_damaged_frame_is_read_once_and_says_why():
    reader = Reader(damaged={2})
    with FrameCache(sequence_of(range(4)), reader, 9 * ONE) as cache:
        for _ in range(3):
            assert cache.wait(2, 1, 0) == Damaged(Path("nowhere/a.0002.exr"), cache.get(2).sentence)
            assert "is damaged" in cache.get(2).sentence
            cache.wait(1, 1, 3)
        assert cache.states()[2] == "damaged"
    assert reader.begun.count(2) == 1


def test_a_fault_of_the_program_reaches_the_caller():
    def read(path):
        raise ZeroDivisionError(path.name)

    news = News()
    with FrameCache(sequence_of(range(4)), read, 9 * ONE, on_ready=news) as cache:
        with pytest.raises(ZeroDivisionError, match="0001"):
            cache.wait(1)
        for ask in (cache.get, cache.want, cache.wait, lambda frame: cache.refresh()):
            with pytest.raises(ZeroDivisionError):
                ask(2)


def test_a_fault_that_is_asked_for_again_and_again_does_not_grow():
    def fault(path):
        raise ZeroDivisionError

    cache, lengths = FrameCache(sequence_of([1]), fault, 99 * ONE), set()
    for _ in range(5):
        with pytest.raises(ZeroDivisionError) as raised:
            cache.wait(1)
        lengths.add(len(raised.traceback))
    assert max(lengths) - min(lengths) <= 1  # the first comes out of the wait itself
    cache.close()


def test_a_fault_of_the_listener_reaches_the_caller():
    with FrameCache(sequence_of(range(4)), Reader(), 9 * ONE, on_ready=lambda: 1 / 0) as cache:
        cache.want(1)
        with pytest.raises(ZeroDivisionError):
            News().wait_until(lambda: cache.get(99))


def threads_of_caches():
    return [t for t in threading.enumerate() if t.name.startswith("frame-cache")]


def test_closing_waits_for_no_read_and_wakes_those_who_wait():
    reader, news, waited = Reader(), News(), []
    reader.gate.clear()
    cache = FrameCache(sequence_of(range(50)), reader, 99 * ONE, workers=3, on_ready=news)
    waiter = threading.Thread(target=lambda: waited.append(cache.wait(7, 1, 40)))
    waiter.start()
    news.wait_until(lambda: reader.begun)
    reading = threads_of_caches()
    cache.close()  # returns although the read never ends before the gate opens
    waiter.join(PATIENCE_S)
    assert waited == [None] and reading
    reader.gate.set()
    for thread in reading:
        thread.join(PATIENCE_S)
    assert reader.begun == [7] and cache.bytes_in_use == 0
    cache.want(1)
    cache.refresh()
    cache.close()
    assert cache.get(7) is None and not threads_of_caches()


def test_closing_frees_the_frames_that_are_held():
    cache = FrameCache(sequence_of(range(5)), Reader(), 99 * ONE)
    assert cache.wait(2) is not None and cache.bytes_in_use
    cache.close()
    assert cache.get(2) is None
