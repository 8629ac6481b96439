"""Reading ahead: the right picture, within the budget, whatever the playhead and the disk do."""

import os
import threading
import time
import weakref
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exr_files import distances, rgb, write_file
from heatlens.errors import InputError
from heatlens.image.exr_read import read_plate
from heatlens.image.frame_cache import Damaged, FrameCache
from heatlens.image.plate import Plate
from heatlens.image.sequence import Sequence, find_sequence
from heatlens.image.sequence_names import NameForm
from plates import plate_of

PATIENCE_S = 60  # before a test gives up; none takes a hundredth of it
ONE = 20  # bytes of a plate of one pixel
FORM = NameForm("a.", 4, ".exr")


class News:
    """An `on_ready` to wait for."""

    def __init__(self):
        self._happened = threading.Condition()

    def __call__(self):
        with self._happened:
            self._happened.notify_all()

    def wait_until(self, predicate):
        """Look again at each piece of news, and now and then in case it came in between."""
        end = time.monotonic() + PATIENCE_S
        while not predicate():
            assert time.monotonic() < end, "nothing came"
            with self._happened:
                self._happened.wait(0.05)


class Reader:
    """Makes the plate of a frame from its name, or fails; remembers what it was asked for."""

    def __init__(self, damaged=(), pixels=lambda frame: 1):
        self.damaged, self.pixels = damaged, pixels
        self.begun: list[int] = []
        self.gate = threading.Event()
        self.gate.set()
        self.live = self.most_live = 0
        self._lock = threading.Lock()

    def __call__(self, path):
        frame = int(path.name.split(".")[1])
        with self._lock:
            self.begun.append(frame)
            self.live += 1
            self.most_live = max(self.live, self.most_live)
        assert self.gate.wait(PATIENCE_S)
        if frame in self.damaged:
            self._gone()
            raise InputError(f"{path} is damaged")
        depth_m = np.full((1, self.pixels(frame)), 1.0 + frame, np.float32)
        plate = plate_of(np.full((*depth_m.shape, 3), frame, np.float32), depth_m)
        weakref.finalize(plate, self._gone)
        return plate

    def _gone(self):
        with self._lock:
            self.live -= 1


def sequence_of(frames, present=None):
    present = tuple(frames) if present is None else tuple(sorted(present))
    return Sequence(Path("nowhere"), FORM, tuple(frames), present)


def frame_of(plate):
    return int(plate.color[0, 0, 0])


def names(states, name):
    return [frame for frame, state in states.items() if state == name]


def at_rest(cache, news):
    """Wait for the last read: each begins, where there is room, as the one before ends."""
    news.wait_until(lambda: "reading" not in cache.states().values())


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


def test_a_fault_of_the_listener_reaches_the_caller():
    with FrameCache(sequence_of(range(4)), Reader(), 9 * ONE, on_ready=lambda: 1 / 0) as cache:
        cache.want(1)
        with pytest.raises(ZeroDivisionError):
            News().wait_until(lambda: cache.get(99))


def threads_of_caches():
    return [t for t in threading.enumerate() if t.name.startswith("frame-cache")]


def test_closing_ends_every_thread_and_wakes_those_who_wait():
    reader, news, waited = Reader(), News(), []
    reader.gate.clear()
    cache = FrameCache(sequence_of(range(50)), reader, 99 * ONE, workers=3, on_ready=news)
    waiter = threading.Thread(target=lambda: waited.append(cache.wait(7, 1, 40)))
    waiter.start()
    news.wait_until(lambda: reader.begun)
    assert threads_of_caches()
    closer = threading.Thread(target=cache.close)
    closer.start()
    waiter.join(PATIENCE_S)
    assert waited == [None]
    reader.gate.set()
    closer.join(PATIENCE_S)
    assert not closer.is_alive() and not threads_of_caches()
    assert reader.begun == [7]
    cache.want(1)
    cache.refresh()
    cache.close()
    assert cache.get(1) is None and not threads_of_caches()


PLAYS = st.lists(
    st.tuples(st.integers(0, 13), st.sampled_from([1, -1]), st.integers(0, 14), st.booleans()),
    min_size=1,
    max_size=25,
)


@settings(deadline=None)
@given(
    present=st.sets(st.integers(0, 13), min_size=1),
    damaged=st.sets(st.integers(0, 13), max_size=4),
    budget=st.integers(2, 10),
    workers=st.integers(1, 4),
    plays=PLAYS,
)
def test_any_scrubbing_shows_the_right_frame_within_the_budget(
    present, damaged, budget, workers, plays
):
    reader = Reader(damaged)
    sequence = sequence_of(range(14), present)
    with FrameCache(sequence, reader, budget * ONE, workers) as cache:
        for frame, direction, window, is_waiting in plays:
            if is_waiting:
                shown = cache.wait(frame, direction, window)
                assert (shown is None) == (frame not in present)
                del shown
            else:
                cache.want(frame, direction, window)
            assert cache.bytes_in_use <= budget * ONE
            assert_consistent(cache, present, damaged)


@settings(deadline=None)
@given(budget=st.integers(2, 10), workers=st.integers(1, 4), plays=PLAYS)
def test_no_more_plates_exist_than_the_budget_holds(budget, workers, plays):
    """Counted where they are made and where Python frees them; nobody else holds one here."""
    reader, news = Reader(), News()
    with FrameCache(sequence_of(range(14)), reader, budget * ONE, workers, news) as cache:
        for frame, direction, window, is_waiting in plays:
            cache.want(frame, direction, window)
            if is_waiting:
                at_rest(cache, news)
    assert reader.most_live <= budget


def assert_consistent(cache, present, damaged):
    """Nothing is ever ready that is not the frame asked for; what has no file stays missing."""
    states = cache.states()
    assert list(states) == list(range(14))
    assert set(names(states, "missing")) == set(range(14)) - present
    assert set(names(states, "damaged")) <= damaged & present
    assert set(names(states, "ready")) <= present - damaged
    for frame in range(14):
        shown = cache.get(frame)
        if isinstance(shown, Plate):
            assert frame_of(shown) == frame and shown.depth_m[0, 0] == 1 + frame
        elif shown is not None:
            assert f"a.{frame:04d}.exr is damaged" in shown.sentence


@settings(deadline=None)
@given(budget=st.integers(1, 12), sizes=st.lists(st.integers(1, 15), min_size=14), plays=PLAYS)
def test_frames_of_any_size_come_to_rest_within_the_budget(budget, sizes, plays):
    reader, news = Reader(pixels=lambda frame: sizes[frame]), News()
    with FrameCache(sequence_of(range(14)), reader, budget * ONE, 2, news) as cache:
        for frame, direction, window, _ in plays:
            assert frame_of(cache.wait(frame, direction, window)) == frame
        at_rest(cache, news)
        ready = names(cache.states(), "ready")
        assert cache.bytes_in_use == sum(sizes[frame] for frame in ready) * ONE
        assert cache.bytes_in_use <= budget * ONE or ready == [frame]


def write_frame(path, value, size=(6, 8)):
    channels = {name: np.full(size, value, np.float16) for name in "RGB"}
    write_file(path, channels | {"Z": distances(*size)})


@pytest.fixture
def shot(tmp_path):
    """1001 to 1006: 1003 cut short, 1004 missing, 1005 larger than the others, 1006 no EXR."""
    for frame in (1001, 1002, 1003, 1005):
        path = tmp_path / f"shot.{frame}.exr"
        write_frame(path, frame - 1000, (12, 16) if frame == 1005 else (6, 8))
    cut = tmp_path / "shot.1003.exr"
    cut.write_bytes(cut.read_bytes()[:-40])
    (tmp_path / "shot.1006.exr").write_bytes(b"not yet")
    for path in tmp_path.iterdir():  # long ago, however coarse the clock of the file system is
        os.utime(path, ns=(10**18, 10**18))
    return tmp_path


def refreshed(cache, news, predicate):
    """Look at the disk until `predicate`; each look is asked for again, as a window does."""

    def look():
        cache.refresh()
        return predicate()

    news.wait_until(look)


def test_real_frames_good_and_bad(shot):
    news = News()
    with FrameCache(find_sequence(shot), read_plate, 10**6, 2, news) as cache:
        cache.want(1001, 1, 9)
        at_rest(cache, news)
        assert list(cache.states().values()) == [
            *("ready", "ready", "damaged", "missing", "ready", "damaged")
        ]
        for frame in (1001, 1002, 1005):
            plate = cache.get(frame)
            assert (plate.color[:, :, :3] == frame - 1000).all()
            assert plate.path == cache.sequence.path_at(frame)
        assert cache.get(1005).color.shape == (12, 16, 4)
        assert "1003.exr is damaged or cut short" in cache.get(1003).sentence
        assert "not an OpenEXR file" in cache.get(1006).sentence
        assert cache.bytes_in_use == (2 * 6 * 8 + 12 * 16) * 20


def test_frames_that_are_written_again_come_or_go_are_noticed(shot):
    news = News()
    with FrameCache(find_sequence(shot), read_plate, 10**6, 2, news) as cache:
        for frame in (1001, 1002, 1003, 1006):
            cache.wait(frame, 1, 9)
        before = cache.get(1002)
        write_frame(shot / "shot.1001.exr", 11)
        write_frame(shot / "shot.1003.exr", 3)
        write_frame(shot / "shot.1004.exr", 4)
        write_frame(shot / "shot.1006.exr", 6)
        write_frame(shot / "shot.1008.exr", 8)
        (shot / "shot.1005.exr").unlink()
        values = {1001: 11, 1002: 2, 1003: 3, 1004: 4, 1006: 6, 1008: 8}
        refreshed(cache, news, lambda: names(cache.states(), "ready") == list(values))
        for frame, value in values.items():
            assert (cache.get(frame).color[:, :, :3] == value).all()
        assert cache.get(1002) is before
        assert names(cache.states(), "missing") == [1005, 1007]
        assert cache.sequence.last == 1008


def test_a_damaged_frame_is_tried_again_only_when_its_file_changes(shot):
    reads, news = [], News()

    def read(path):
        reads.append(path.name)
        return read_plate(path)

    with FrameCache(find_sequence(shot), read, 10**6, 2, news) as cache:
        cache.wait(1003, 1, 0)
        os.utime(shot / "shot.1001.exr", ns=(1, 1))  # not held: no news
        (shot / "shot.1007.exr").touch()
        refreshed(cache, news, lambda: cache.sequence.last == 1007)
        assert cache.states()[1003] == "damaged" and reads == ["shot.1003.exr"]
        os.utime(shot / "shot.1003.exr", ns=(1, 1))
        refreshed(cache, news, lambda: len(reads) == 2)
        news.wait_until(lambda: cache.states()[1003] == "damaged")
    assert reads == ["shot.1003.exr"] * 2


def test_a_file_that_goes_while_it_is_read_is_missing(shot):
    reader, news = Reader(), News()
    with FrameCache(find_sequence(shot), reader, 10**6, 2, news) as cache:
        reader.gate.clear()
        cache.want(1002, 1, 0)
        news.wait_until(lambda: reader.begun)
        (shot / "shot.1002.exr").unlink()
        refreshed(cache, news, lambda: not cache.sequence.has(1002))
        assert cache.states()[1002] == "reading"
        reader.gate.set()
        news.wait_until(lambda: cache.states()[1002] == "missing")
        assert cache.get(1002) is None and cache.bytes_in_use == 0


def test_a_folder_that_cannot_be_looked_into_takes_nothing_away(shot, tmp_path_factory):
    news = News()
    with FrameCache(find_sequence(shot), read_plate, 10**6, 2, news) as cache:
        before = cache.wait(1001, 1, 0)
        elsewhere = shot.rename(tmp_path_factory.mktemp("away") / "shot")
        refreshed(cache, news, lambda: cache.problem is not None)
        assert "cannot be looked into" in cache.problem and cache.get(1001) is before
        elsewhere.rename(shot)
        refreshed(cache, news, lambda: cache.problem is None)
        assert cache.get(1001) is before


def test_a_still_is_a_sequence_like_any_other(tmp_path):
    write_file(tmp_path / "still.exr", rgb() | {"Z": distances()})
    with FrameCache(find_sequence(tmp_path), read_plate, 10**6) as cache:
        assert cache.wait(cache.sequence.first, -1, 30).path == tmp_path / "still.exr"
        assert list(cache.states().values()) == ["ready"]
