"""Test the guides over a picture: accepted aspects, and positions of lines and mattes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.view.guides import (
    ACTION_SAFE,
    MATTES,
    SQUEEZES,
    TITLE_SAFE,
    Guides,
    guide_shapes,
    inner_rect,
    parse_aspect,
    parse_desqueeze,
)

PICTURE = (10.0, 20.0, 210.0, 120.0)  # twice as wide as high


@pytest.mark.parametrize("parse", [parse_aspect, parse_desqueeze])
@pytest.mark.parametrize(
    ("text", "ratio"), [("2.2", 2.2), (" 2,2 ", 2.2), ("2.2:1", 2.2), ("4:3", 4 / 3), ("3:4", 0.75)]
)
def test_parse_ratio_reads_number_or_pair(parse, text, ratio):
    assert parse(text) == pytest.approx(ratio)


@pytest.mark.parametrize(
    ("parse", "least", "most"), [(parse_aspect, 0.1, 10.0), (parse_desqueeze, 0.25, 4.0)]
)
def test_parse_ratio_rejects_text_and_values_out_of_range(parse, least, most):
    assert parse(f"{least}") == least and parse(f"{most}") == most
    for wrong in (f"{least * 0.99}", f"{most * 1.01}", "wide", "", "1:0", "nan", "-2", "1:2:3"):
        with pytest.raises(InputError, match=r"Examples: 2"):
            parse(wrong)


@pytest.mark.parametrize(
    ("field", "least", "most"),
    [("aspect", 0.1, 10.0), ("opacity", 0.0, 1.0), ("desqueeze", 0.25, 4.0)],
)
def test_guides_reject_values_outside_option_ranges(field, least, most):
    for right in (least, most):
        assert getattr(Guides(**{field: right}), field) == right
    for wrong in (least - 0.01, most + 0.01, float("nan")):
        with pytest.raises(InputError, match=field):
            Guides(**{field: wrong})


def test_standard_mattes_squeezes_and_safe_areas():
    assert MATTES["2.39"] == 2.39 and MATTES["16:9"] == 16 / 9 and MATTES["9:16"] == 9 / 16
    assert MATTES["1:1"] == 1.0 and MATTES["4:3"] == 4 / 3 and MATTES["1.85"] == 1.85
    assert SQUEEZES == {"1.25": 1.25, "1.33": 4 / 3, "1.5": 1.5, "1.65": 1.65, "1.8": 1.8, "2": 2.0}
    assert (ACTION_SAFE, TITLE_SAFE) == (0.93, 0.90)  # EBU R 95
    plain = Guides()
    assert plain.opacity == 0.72 and plain.aspect is None is plain.desqueeze
    assert not (plain.safe_areas or plain.thirds or plain.centre)


@given(st.floats(0.1, 10.0), st.floats(1, 500), st.floats(1, 500))
def test_matte_shades_cover_all_outside_largest_centered_rect(aspect, width, height):
    x0, y0, x1, y1 = inner = inner_rect((0.0, 0.0, width, height), aspect)
    assert (x1 - x0) / (y1 - y0) == pytest.approx(aspect)
    assert x0 + x1 == pytest.approx(width) and y0 + y1 == pytest.approx(height)
    assert x1 - x0 == pytest.approx(width) or y1 - y0 == pytest.approx(height)
    shades = guide_shapes(Guides(aspect), (0.0, 0.0, width, height)).shades
    covered = sum((c - a) * (d - b) for a, b, c, d in (*shades, inner))
    assert covered == pytest.approx(width * height)


def test_matte_shades_lie_above_and_below_or_left_and_right():
    above, below = guide_shapes(Guides(4.0), PICTURE).shades
    assert above == (10, 20, 210, 45) and below == (10, 95, 210, 120)
    left, right = guide_shapes(Guides(1.0), PICTURE).shades
    assert left == (10, 20, 60, 120) and right == (160, 20, 210, 120)
    assert guide_shapes(Guides(1.0), PICTURE).frames == ((60, 20, 160, 120),)


def test_guide_shapes_are_empty_without_guides():
    shapes = guide_shapes(Guides(), PICTURE)
    assert shapes.shades == shapes.frames == shapes.lines == ()


def test_thirds_and_center_cross_lie_inside_matte():
    lines = guide_shapes(Guides(1.0, thirds=True), (0.0, 0.0, 400.0, 300.0)).lines
    expected = [(150, 0, 150, 300), (250, 0, 250, 300), (50, 100, 350, 100), (50, 200, 350, 200)]
    np.testing.assert_allclose(lines, expected)
    across, up = guide_shapes(Guides(centre=True), PICTURE).lines
    assert across == (105, 70, 115, 70) and up == (110, 65, 110, 75)  # 5 % of the height each way


def test_safe_area_frames_are_fractions_of_matte_opening():
    matte, action, title = guide_shapes(Guides(1.0, safe_areas=True), PICTURE).frames
    assert matte == (60, 20, 160, 120)
    assert action == pytest.approx((63.5, 23.5, 156.5, 116.5))
    assert title == pytest.approx((65, 25, 155, 115))
    assert len(guide_shapes(Guides(safe_areas=True), PICTURE).frames) == 2
