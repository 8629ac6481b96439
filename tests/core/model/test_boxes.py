"""Compare boxes with the sets of their pixels."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.boxes import Box

EDGE = st.integers(-6, 6)
BOXES = st.builds(Box, EDGE, EDGE, EDGE, EDGE)


def pixels(box: Box) -> set[tuple[int, int]]:
    return {(x, y) for x in range(box.x0, box.x1) for y in range(box.y0, box.y1)}


@given(BOXES, BOXES)
def test_box_intersection_holds_the_pixels_of_both_boxes(first, second):
    shared = first.intersection(second)
    assert pixels(shared) == pixels(first) & pixels(second)
    assert shared.is_empty == (not pixels(shared))


@given(BOXES)
def test_box_contains_and_size_agree_with_its_pixel_set(box):
    inside = {(x, y) for x in range(-7, 8) for y in range(-7, 8) if box.contains(x, y)}
    assert inside == pixels(box)
    if not box.is_empty:
        assert box.width * box.height == len(pixels(box))


def test_box_shape_is_height_then_width():
    assert Box(-1, 2, 4, 9).shape == (7, 5)


def test_intersection_of_disjoint_boxes_has_no_pixels():
    apart = Box(0, 0, 2, 2).intersection(Box(5, 0, 9, 2))
    assert apart.shape == (2, 0)


def test_box_excludes_its_right_and_bottom_edge():
    box = Box(0, 0, 3, 2)
    assert box.contains(2.99, 1.5)
    assert not box.contains(3, 1)
    assert not box.contains(1, 2)
