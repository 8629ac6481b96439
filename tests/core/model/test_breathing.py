"""A lens that breathes shows less as it is focused nearer, and its discs are scaled with it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.lens.breathing import as_seen, breathing_note, plate_ratio, view_ratio
from heatlens.core.model.lens.lens import Lens, LensModel

FOCI = st.floats(0.3, 1e4) | st.just(math.inf)
RATIOS = st.floats(0.7, 1.3)


def lens(focus_m: float, ratio: float, model: LensModel = LensModel.PHOTOGRAPHIC) -> Lens:
    return Lens(50.0, 2.0, focus_m, 36.0, close_focus_m=0.5, breathing=ratio, model=model)


@given(RATIOS)
def test_the_view_is_whole_at_infinity_and_the_ratio_at_close_focus(ratio):
    assert view_ratio(lens(math.inf, ratio)) == 1.0
    assert view_ratio(lens(0.5, ratio)) == pytest.approx(ratio)
    assert view_ratio(lens(0.4, ratio)) == pytest.approx(ratio)  # nearer it stays
    assert view_ratio(lens(1.0, ratio)) == pytest.approx((1 + ratio) / 2)  # half the dioptres


@given(FOCI)
def test_a_lens_that_does_not_breathe_is_itself(focus_m):
    still = lens(focus_m, 1.0)
    assert as_seen(still) is still and plate_ratio(still, 1.0) == 1.0
    assert breathing_note(still, 1.0) == ""


@given(FOCI, RATIOS)
def test_the_opening_stays_and_the_discs_grow_with_the_picture(focus_m, ratio):
    breathing = lens(focus_m, ratio, LensModel.RENDERER)
    seen = as_seen(breathing)
    assert seen.aperture_diameter_mm == pytest.approx(breathing.aperture_diameter_mm)
    still = lens(focus_m, 1.0, LensModel.RENDERER)
    wide, narrow = (coc_line(it, 1000).per_dioptre_px for it in (still, seen))
    assert narrow * view_ratio(breathing) == pytest.approx(wide, rel=1e-9)


def test_a_plate_without_room_is_enlarged_alike_at_every_focus():
    wider = 1.04
    far, near = lens(math.inf, wider), lens(0.5, wider)
    assert plate_ratio(far, 1.1) == 1.0 and plate_ratio(near, 1.1) == pytest.approx(1.04)
    assert plate_ratio(near, 1.0) == pytest.approx(1.0)
    assert plate_ratio(far, 1.0) == pytest.approx(1 / 1.04)
    assert plate_ratio(near, 1.02) == pytest.approx(1.02)


@pytest.mark.parametrize(
    ("ratio", "room", "told"),
    [(0.95, 1.0, "cut from the plate"), (1.04, 1.1, "overscan of the plate has"),
     (1.04, 1.0, "enlarged 1.04x"), (0.95, None, "5 % less than at infinity.")],
)  # fmt: skip
def test_what_it_does_is_said(ratio, room, told):
    assert told in breathing_note(lens(2.0, ratio), room)
