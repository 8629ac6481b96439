"""Test lens breathing: the angle of view and the disc size change with the focus distance."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.lens.breathing import (
    breathing_note,
    plate_ratio,
    view_ratio,
    without_breathing,
)
from heatlens.core.model.lens.lens import Lens, LensModel

FOCI = st.floats(0.3, 1e4) | st.just(math.inf)
RATIOS = st.floats(0.7, 1.3)


def lens(focus_m: float, ratio: float, model: LensModel = LensModel.PHOTOGRAPHIC) -> Lens:
    return Lens(50.0, 2.0, focus_m, 36.0, close_focus_m=0.5, breathing=ratio, model=model)


@given(RATIOS)
def test_view_ratio_goes_from_1_at_infinity_to_ratio_at_close_focus(ratio):
    assert view_ratio(lens(math.inf, ratio)) == 1.0
    assert view_ratio(lens(0.5, ratio)) == pytest.approx(ratio)
    assert view_ratio(lens(0.4, ratio)) == pytest.approx(ratio)  # nearer it stays
    assert view_ratio(lens(1.0, ratio)) == pytest.approx((1 + ratio) / 2)  # half the dioptres


@given(RATIOS)
def test_unknown_close_focus_is_half_a_meter(ratio):
    unknown = replace(lens(1.0, ratio), close_focus_m=None)
    assert view_ratio(unknown) == view_ratio(lens(1.0, ratio))


@given(FOCI)
def test_lens_without_breathing_is_unchanged_and_has_no_note(focus_m):
    still = lens(focus_m, 1.0)
    assert without_breathing(still) is still and plate_ratio(still, 1.0) == 1.0
    assert breathing_note(still, 1.0) == ""


@given(FOCI, RATIOS)
def test_breathing_keeps_aperture_diameter_and_scales_discs(focus_m, ratio):
    breathing = lens(focus_m, ratio, LensModel.RENDERER)
    breathing_view = without_breathing(breathing)
    assert breathing_view.aperture_diameter_mm == pytest.approx(breathing.aperture_diameter_mm)
    still = lens(focus_m, 1.0, LensModel.RENDERER)
    wide, narrow = (coc_line(it, 1000).per_dioptre_px for it in (still, breathing_view))
    assert narrow * view_ratio(breathing) == pytest.approx(wide, rel=1e-9)


def test_plate_ratio_enlarges_plate_where_overscan_is_too_small():
    wider = 1.04
    far, near = lens(math.inf, wider), lens(0.5, wider)
    assert plate_ratio(far, 1.1) == 1.0 and plate_ratio(near, 1.1) == pytest.approx(1.04)
    assert plate_ratio(near, 1.0) == pytest.approx(1.0)
    assert plate_ratio(far, 1.0) == pytest.approx(1 / 1.04)
    assert plate_ratio(near, 1.02) == pytest.approx(1.02)


@pytest.mark.parametrize(
    ("ratio", "room", "message"),
    [(0.95, 1.0, "cut from the plate"), (1.04, 1.1, "overscan of the plate has"),
     (1.04, 1.0, "enlarged 1.04x"), (0.95, None, "5 % less than at infinity.")],
)  # fmt: skip
def test_breathing_note_names_crop_overscan_or_enlargement(ratio, room, message):
    assert message in breathing_note(lens(2.0, ratio), room)
