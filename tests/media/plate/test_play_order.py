"""Test which frames a player reads next, and which it drops first."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.frame_cache.plate_shelf import PlayOrder

FRAMES = tuple(range(1001, 1011))


def test_play_order_forward_wants_frames_ahead_and_ranks_behind_last():
    order = PlayOrder.at(FRAMES, 1005, 1, 2)
    assert list(order.frames_to_read()) == [1005, 1006, 1007]
    assert sorted(FRAMES, key=order.rank) == [
        *(1005, 1006, 1007),
        *(1004, 1003, 1002, 1001, 1010, 1009, 1008),
    ]


def test_play_order_backward_wraps_around_the_end():
    order = PlayOrder.at(FRAMES, 1002, -1, 3)
    assert list(order.frames_to_read()) == [1002, 1001, 1010, 1009]
    assert max(FRAMES, key=order.rank) == 1008


def test_play_order_between_frames_uses_the_earlier_one():
    odd = FRAMES[::2]
    playheads = [PlayOrder.at(odd, frame, 1, 0).playhead for frame in (1, 1001, 1004, 2000)]
    assert playheads == [1001, 1001, 1003, 1009]


@given(
    frames=st.sets(st.integers(-30, 30), min_size=1),
    frame=st.integers(-40, 40),
    direction=st.sampled_from([1, -1]),
    window=st.integers(-1, 70),
)
def test_play_order_ranks_all_frames_and_begins_with_wanted_ones(frames, frame, direction, window):
    order = PlayOrder.at(tuple(sorted(frames)), frame, direction, window)
    wanted = list(order.frames_to_read())
    by_rank = sorted(frames, key=order.rank)
    assert len({order.rank(frame) for frame in frames}) == len(frames)
    assert by_rank[: len(wanted)] == wanted
    assert len(wanted) == min(window + 1, len(frames))
