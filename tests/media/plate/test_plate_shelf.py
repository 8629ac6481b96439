"""Test plates within a memory budget: which are dropped, and a frame larger than the budget."""

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.frame_cache.plate_shelf import (
    CachedPlate,
    Damaged,
    PlateShelf,
    PlayOrder,
    plate_bytes,
)
from support.plates import coc_plate_of, plate_of

FRAMES = tuple(range(10))
PIXEL_BYTES = 20  # four of colour and one of depth, 4 bytes each


def plate(pixels=1):
    return plate_of(np.ones((1, pixels, 3), np.float32), np.ones((1, pixels), np.float32))


def reserve_and_put(shelf, frame, order, pixels=1):
    """Reserve a place and put a plate in it, as a read does. Return False if there was no space."""
    if not shelf.reserve(frame, order):
        return False
    shelf.put(frame, CachedPlate(plate(pixels), None), order)
    return True


def test_plate_bytes_count_color_and_depth_or_coc():
    assert plate_bytes(plate(7)) == 7 * PIXEL_BYTES
    coc_px = np.ones((1, 7), np.float32)
    assert plate_bytes(coc_plate_of(np.ones((1, 7, 3), np.float32), coc_px)) == 7 * PIXEL_BYTES


def test_plate_shelf_drops_frame_farthest_behind_first():
    shelf, order = PlateShelf(3 * PIXEL_BYTES), PlayOrder.at(FRAMES, 3, 1, 5)
    for frame in (3, 4, 2):
        assert reserve_and_put(shelf, frame, order)
    assert reserve_and_put(shelf, 5, order) and set(shelf.cached) == {3, 4, 5}
    assert not reserve_and_put(shelf, 6, order) and set(shelf.cached) == {3, 4, 5}
    next_order = PlayOrder.at(FRAMES, 5, 1, 5)
    assert reserve_and_put(shelf, 6, next_order) and set(shelf.cached) == {4, 5, 6}


def test_plate_shelf_reserves_one_frame_until_size_is_known():
    shelf, order = PlateShelf(4 * PIXEL_BYTES), PlayOrder.at(FRAMES, 0, 1, 5)
    assert shelf.reserve(0, order) and not shelf.reserve(1, order)
    shelf.put(0, CachedPlate(plate(), None), order)
    assert shelf.reserve(1, order) and shelf.reserve(2, order)


def test_plate_shelf_holds_oversized_frame_alone_while_shown():
    shelf, order = PlateShelf(3 * PIXEL_BYTES), PlayOrder.at(FRAMES, 0, 1, 5)
    assert reserve_and_put(shelf, 0, order) and reserve_and_put(shelf, 1, order, pixels=9)
    assert set(shelf.cached) == {0}  # only when it was read did it turn out too large
    assert not reserve_and_put(shelf, 1, order)
    order_at_frame = PlayOrder.at(FRAMES, 1, 1, 5)
    assert reserve_and_put(shelf, 1, order_at_frame, pixels=9) and set(shelf.cached) == {1}
    assert not reserve_and_put(shelf, 2, order_at_frame)
    order_after_frame = PlayOrder.at(FRAMES, 2, 1, 9)
    shelf.trim(order_after_frame)
    assert not shelf.cached and not shelf.reserve(1, order_after_frame)


def test_plate_shelf_forgets_size_of_frame():
    shelf, order = PlateShelf(3 * PIXEL_BYTES), PlayOrder.at(FRAMES, 0, 1, 5)
    assert reserve_and_put(shelf, 1, PlayOrder.at(FRAMES, 1, 1, 0), pixels=9)
    assert reserve_and_put(shelf, 0, order) and not reserve_and_put(shelf, 1, order)
    shelf.drop_changed(1)
    assert reserve_and_put(shelf, 1, order)


def test_plate_shelf_keeps_damaged_frame_without_cost():
    shelf, order = PlateShelf(PIXEL_BYTES), PlayOrder.at(FRAMES, 0, 1, 5)
    assert shelf.reserve(0, order)
    shelf.put(0, CachedPlate(Damaged(Path("a"), "why"), None), order)
    assert reserve_and_put(shelf, 1, PlayOrder.at(FRAMES, 1, 1, 0))
    assert reserve_and_put(shelf, 5, PlayOrder.at(FRAMES, 5, 1, 0))
    assert set(shelf.cached) == {0, 5}


@given(
    budget=st.integers(1, 12),
    sizes=st.lists(st.integers(1, 15), min_size=10, max_size=10),
    plays=st.lists(
        st.tuples(st.sampled_from(FRAMES), st.sampled_from([1, -1]), st.integers(0, 12))
    ),
)
def test_plate_shelf_stays_within_budget_for_any_playback(budget, sizes, plays):
    """Sizes and budget are in pixels. Reads happen one at a time here, and come to an end."""
    shelf = PlateShelf(budget * PIXEL_BYTES)
    for frame, direction, window in plays:
        order = PlayOrder.at(FRAMES, frame, direction, window)
        shelf.trim(order)
        reads = 0
        while (next_frame := _next_unread(shelf, order)) is not None:
            if not reserve_and_put(shelf, next_frame, order, sizes[next_frame]):
                break
            assert (reads := reads + 1) < 50  # nothing is read and given up for ever
            assert shelf.bytes_in_use <= shelf.budget_bytes or set(shelf.cached) == {order.playhead}
        assert order.playhead in shelf.cached
        ranks = [order.rank(frame) for frame in shelf.cached]
        assert shelf.bytes_in_use == sum(sizes[frame] for frame in shelf.cached) * PIXEL_BYTES
        assert min(ranks) == (0, 0)


def _next_unread(shelf, order):
    return next((frame for frame in order.frames_to_read() if frame not in shelf.cached), None)
