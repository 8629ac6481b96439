"""Plates within a budget: what is given up for what, and the frame larger than all of it."""

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.frame_cache.plate_shelf import Damaged, Held, PlateShelf, PlayOrder, plate_bytes
from support.plates import coc_plate_of, plate_of

FRAMES = tuple(range(10))
PIXEL_BYTES = 20  # four of colour and one of depth, 4 bytes each


def plate(pixels=1):
    return plate_of(np.ones((1, pixels, 3), np.float32), np.ones((1, pixels), np.float32))


def put(shelf, frame, order, pixels=1):
    """Reserve and put as one read does; return False if there was no room."""
    if not shelf.reserve(frame, order):
        return False
    shelf.put(frame, Held(plate(pixels), None), order)
    return True


def test_colour_and_depth_count_whichever_depth_it_is():
    assert plate_bytes(plate(7)) == 7 * PIXEL_BYTES
    coc_px = np.ones((1, 7), np.float32)
    assert plate_bytes(coc_plate_of(np.ones((1, 7, 3), np.float32), coc_px)) == 7 * PIXEL_BYTES


def test_the_frame_farthest_behind_goes_first():
    shelf, order = PlateShelf(3 * PIXEL_BYTES), PlayOrder.at(FRAMES, 3, 1, 5)
    for frame in (3, 4, 2):
        assert put(shelf, frame, order)
    assert put(shelf, 5, order) and set(shelf.held) == {3, 4, 5}
    assert not put(shelf, 6, order) and set(shelf.held) == {3, 4, 5}
    moved = PlayOrder.at(FRAMES, 5, 1, 5)
    assert put(shelf, 6, moved) and set(shelf.held) == {4, 5, 6}


def test_the_first_frame_is_read_alone_for_its_size_is_not_known():
    shelf, order = PlateShelf(4 * PIXEL_BYTES), PlayOrder.at(FRAMES, 0, 1, 5)
    assert shelf.reserve(0, order) and not shelf.reserve(1, order)
    shelf.put(0, Held(plate(), None), order)
    assert shelf.reserve(1, order) and shelf.reserve(2, order)


def test_a_frame_larger_than_the_budget_is_held_alone_while_it_is_shown():
    shelf, order = PlateShelf(3 * PIXEL_BYTES), PlayOrder.at(FRAMES, 0, 1, 5)
    assert put(shelf, 0, order) and put(shelf, 1, order, pixels=9)
    assert set(shelf.held) == {0}  # only when it was read did it turn out too large
    assert not put(shelf, 1, order)
    shown = PlayOrder.at(FRAMES, 1, 1, 5)
    assert put(shelf, 1, shown, pixels=9) and set(shelf.held) == {1}
    assert not put(shelf, 2, shown)
    passed = PlayOrder.at(FRAMES, 2, 1, 9)
    shelf.trim(passed)
    assert not shelf.held and not shelf.reserve(1, passed)


def test_a_forgotten_frame_is_taken_to_be_as_large_as_the_others():
    shelf, order = PlateShelf(3 * PIXEL_BYTES), PlayOrder.at(FRAMES, 0, 1, 5)
    assert put(shelf, 1, PlayOrder.at(FRAMES, 1, 1, 0), pixels=9)
    assert put(shelf, 0, order) and not put(shelf, 1, order)
    shelf.forget(1)
    assert put(shelf, 1, order)


def test_damage_weighs_nothing_and_is_remembered():
    shelf, order = PlateShelf(PIXEL_BYTES), PlayOrder.at(FRAMES, 0, 1, 5)
    assert shelf.reserve(0, order)
    shelf.put(0, Held(Damaged(Path("a"), "why"), None), order)
    assert put(shelf, 1, PlayOrder.at(FRAMES, 1, 1, 0))
    assert put(shelf, 5, PlayOrder.at(FRAMES, 5, 1, 0))
    assert set(shelf.held) == {0, 5}


@given(
    budget=st.integers(1, 12),
    sizes=st.lists(st.integers(1, 15), min_size=10, max_size=10),
    plays=st.lists(
        st.tuples(st.sampled_from(FRAMES), st.sampled_from([1, -1]), st.integers(0, 12))
    ),
)
def test_any_way_of_playing_stays_within_the_budget_and_gives_up_the_worst(budget, sizes, plays):
    """Sizes and budget in pixels. Reads are one at a time here, and come to an end."""
    shelf = PlateShelf(budget * PIXEL_BYTES)
    for frame, direction, window in plays:
        order = PlayOrder.at(FRAMES, frame, direction, window)
        shelf.trim(order)
        reads = 0
        while (after := _next_unread(shelf, order)) is not None:
            if not put(shelf, after, order, sizes[after]):
                break
            assert (reads := reads + 1) < 50  # nothing is read and given up for ever
            assert shelf.bytes_in_use <= shelf.budget_bytes or set(shelf.held) == {order.playhead}
        assert order.playhead in shelf.held
        kept = [order.rank(frame) for frame in shelf.held]
        assert shelf.bytes_in_use == sum(sizes[frame] for frame in shelf.held) * PIXEL_BYTES
        assert min(kept) == (0, 0)


def _next_unread(shelf, order):
    return next((frame for frame in order.wanted() if frame not in shelf.held), None)
