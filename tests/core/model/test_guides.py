"""Guides: mattes are the largest rectangle of their aspect in the picture."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.view.guides import (
    MATTES,
    Canvas,
    FrameLine,
    inner_rect,
    lines_of,
    parse_aspect,
    scaled_rect,
)

SIDES = st.floats(1.0, 4000.0)


@given(SIDES, SIDES, st.sampled_from(sorted(MATTES.values())))
def test_a_matte_leaves_the_largest_picture_of_its_aspect(width, height, aspect):
    x0, y0, x1, y1 = inner_rect((10.0, 20.0, 10.0 + width, 20.0 + height), aspect)
    assert (x1 - x0) == pytest.approx(aspect * (y1 - y0), rel=1e-6)
    assert x1 - x0 == pytest.approx(width, rel=1e-6) or y1 - y0 == pytest.approx(height, rel=1e-6)
    assert 10.0 - 1e-6 <= x0 and 20.0 - 1e-6 <= y0
    assert (x0 + x1) / 2 == pytest.approx(10.0 + width / 2, rel=1e-6)


def test_no_matte_leaves_all_and_safe_areas_lie_inside():
    assert inner_rect((0, 0, 16, 9), None) == (0, 0, 16, 9)
    assert scaled_rect((0, 0, 100, 50), 0.9, 0.9) == pytest.approx((5, 2.5, 95, 47.5))


@pytest.mark.parametrize(("text", "aspect"), [("2.2", 2.2), ("2,2", 2.2), ("16:9", 16 / 9)])
def test_an_aspect_is_typed_as_people_write_it(text, aspect):
    assert parse_aspect(text) == pytest.approx(aspect)


@pytest.mark.parametrize("text", ["", "wide", "0", "-2", "1:0", "99", "nan"])
def test_what_is_no_aspect_is_refused(text):
    with pytest.raises(InputError, match="not an aspect"):
        parse_aspect(text)


def test_lines_are_those_of_the_size_else_of_the_shape():
    names = ("another shape", "the shape", "the size", "the size again")
    sizes = ((1920, 1200), (3840, 2160), (1920, 1080), (1920, 1080))
    lines = [(FrameLine(name, (0.0, 0.0, 1.0, 1.0)),) for name in names]
    canvases = [Canvas(*size, of) for size, of in zip(sizes, lines, strict=True)]
    assert lines_of(canvases, 1920, 1080) == lines[2]
    assert lines_of(canvases, 1280, 720) == lines[1]
    assert lines_of(canvases, 1000, 1000) == ()
