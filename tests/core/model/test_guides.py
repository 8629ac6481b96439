"""Guides: mattes are the largest rectangle of their aspect in the picture."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.view.guides import (
    MATTES,
    Canvas,
    FrameLine,
    frame_lines_for,
    inner_rect,
    parse_aspect,
    scaled_rect,
)

SIDES = st.floats(1.0, 4000.0)


@given(SIDES, SIDES, st.sampled_from(sorted(MATTES.values())))
def test_inner_rect_is_largest_centered_rect_of_aspect(width, height, aspect):
    x0, y0, x1, y1 = inner_rect((10.0, 20.0, 10.0 + width, 20.0 + height), aspect)
    assert (x1 - x0) == pytest.approx(aspect * (y1 - y0), rel=1e-6)
    assert x1 - x0 == pytest.approx(width, rel=1e-6) or y1 - y0 == pytest.approx(height, rel=1e-6)
    assert 10.0 - 1e-6 <= x0 and 20.0 - 1e-6 <= y0
    assert (x0 + x1) / 2 == pytest.approx(10.0 + width / 2, rel=1e-6)


def test_inner_rect_without_aspect_is_whole_and_scaled_rect_is_inside():
    assert inner_rect((0, 0, 16, 9), None) == (0, 0, 16, 9)
    assert scaled_rect((0, 0, 100, 50), 0.9, 0.9) == pytest.approx((5, 2.5, 95, 47.5))


@pytest.mark.parametrize(("text", "aspect"), [("2.2", 2.2), ("2,2", 2.2), ("16:9", 16 / 9)])
def test_parse_aspect_reads_decimal_comma_and_ratio(text, aspect):
    assert parse_aspect(text) == pytest.approx(aspect)


@pytest.mark.parametrize("text", ["", "wide", "0", "-2", "1:0", "99", "nan"])
def test_parse_aspect_rejects_invalid_text(text):
    with pytest.raises(InputError, match="not an aspect"):
        parse_aspect(text)


def test_lines_of_prefers_canvas_of_same_size_then_same_shape():
    names = ("another shape", "the shape", "the size", "the size again")
    sizes = ((1920, 1200), (3840, 2160), (1920, 1080), (1920, 1080))
    lines = [(FrameLine(name, (0.0, 0.0, 1.0, 1.0)),) for name in names]
    canvases = [Canvas(*size, of) for size, of in zip(sizes, lines, strict=True)]
    assert frame_lines_for(canvases, 1920, 1080) == lines[2]
    assert frame_lines_for(canvases, 1280, 720) == lines[1]
    assert frame_lines_for(canvases, 1000, 1000) == ()
