"""Test that the frame cache returns the right frame within its budget for any scrubbing."""

from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.plate.plate import Plate
from support.frame_caches import (
    PLATE_BYTES,
    Reader,
    ReadyEvent,
    frame_of,
    frames_in_state,
    sequence_of,
    wait_until_idle,
)

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
def test_frame_cache_returns_right_frame_within_budget_for_any_scrubbing(
    present, damaged, budget, workers, plays
):
    reader = Reader(damaged)
    sequence = sequence_of(range(14), present)
    with FrameCache(sequence, reader, budget * PLATE_BYTES, workers) as cache:
        for frame, direction, window, is_waiting in plays:
            if is_waiting:
                shown = cache.read_and_wait(frame, direction, window)
                assert (shown is None) == (frame not in present)
                del shown
            else:
                cache.set_playhead(frame, direction, window)
            assert cache.bytes_in_use <= budget * PLATE_BYTES
            assert_consistent(cache, present, damaged)


@settings(deadline=None)
@given(budget=st.integers(2, 10), workers=st.integers(1, 4), plays=PLAYS)
def test_frame_cache_keeps_no_more_plates_alive_than_budget_allows(budget, workers, plays):
    """Plates are counted when they are made and when Python frees them; nothing else holds one."""
    reader, news = Reader(), ReadyEvent()
    with FrameCache(sequence_of(range(14)), reader, budget * PLATE_BYTES, workers, news) as cache:
        for frame, direction, window, is_waiting in plays:
            cache.set_playhead(frame, direction, window)
            if is_waiting:
                wait_until_idle(cache, news)
    assert reader.most_live <= budget


def assert_consistent(cache, present, damaged):
    """Check that ready frames are the requested ones, and missing frames stay missing."""
    states = cache.states()
    assert list(states) == list(range(14))
    assert set(frames_in_state(states, "missing")) == set(range(14)) - present
    assert set(frames_in_state(states, "damaged")) <= damaged & present
    assert set(frames_in_state(states, "ready")) <= present - damaged
    for frame in range(14):
        shown = cache.get(frame)
        if isinstance(shown, Plate):
            assert frame_of(shown) == frame and shown.depth_m[0, 0] == 1 + frame
        elif shown is not None:
            assert f"a.{frame:04d}.exr is damaged" in shown.sentence


@settings(deadline=None)
@given(budget=st.integers(1, 12), sizes=st.lists(st.integers(1, 15), min_size=14), plays=PLAYS)
def test_frame_cache_with_frames_of_any_size_settles_within_budget(budget, sizes, plays):
    reader, news = Reader(pixels=lambda frame: sizes[frame]), ReadyEvent()
    with FrameCache(
        sequence_of(range(14)), reader, budget_bytes=budget * PLATE_BYTES, workers=2, on_ready=news
    ) as cache:
        for frame, direction, window, _ in plays:
            assert frame_of(cache.read_and_wait(frame, direction, window)) == frame
        wait_until_idle(cache, news)
        ready = frames_in_state(cache.states(), "ready")
        assert cache.bytes_in_use == sum(sizes[frame] for frame in ready) * PLATE_BYTES
        assert cache.bytes_in_use <= budget * PLATE_BYTES or ready == [frame]
