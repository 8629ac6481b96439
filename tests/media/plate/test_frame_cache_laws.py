"""Whatever the playhead does, the cache shows the right picture, within its budget."""

from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.plate.plate import Plate
from support.frame_caches import ONE, News, Reader, at_rest, frame_of, names, sequence_of

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
    """Check that ready frames are the requested ones, and missing frames stay missing."""
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
