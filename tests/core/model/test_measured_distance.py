"""Test distances measured from the film plane: their text, and the close focus of lens kits."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import (
    Lens,
    MeasuredFrom,
    as_measured_m,
    from_pupil_m,
    measured_text,
    parse_measured_m,
)
from heatlens.core.model.lens.lens_kit import KitLens, LensKit
from heatlens.core.model.units import format_distance

FILM = Lens(50.0, 2.8, 2.0, 36.0, measured_from=MeasuredFrom.FILM, pupil_offset_mm=120.0)
KIT = LensKit(
    name="primes",
    words="a lens",
    lenses=(KitLens(focal_length_mm=50.0, f_stop=1.4, close_focus_m=0.45),),
)


@given(st.floats(0.2, 1e4), st.floats(-200.0, 200.0))
def test_as_measured_and_from_pupil_are_inverse(distance_m, offset_mm):
    lens = replace(FILM, pupil_offset_mm=offset_mm)
    assert from_pupil_m(lens, as_measured_m(lens, distance_m)) == pytest.approx(distance_m)
    assert as_measured_m(replace(lens, measured_from=MeasuredFrom.PUPIL), distance_m) == distance_m


def test_measured_text_adds_pupil_offset_and_handles_infinity():
    assert measured_text(FILM, 2.0) == "2.12 m"
    assert parse_measured_m(FILM, "2.12") == pytest.approx(2.0)
    assert measured_text(FILM, float("inf")) == format_distance(float("inf"))


def test_kit_converts_close_focus_from_film_plane_to_pupil():
    mounted = KIT.mount(FILM, KIT.lenses[0])
    assert mounted.close_focus_m == pytest.approx(0.33)
    too_close = replace(mounted, focus_distance_m=0.3)
    assert KIT.limit_change(mounted, too_close).focus_distance_m == pytest.approx(0.33)
    message = KIT.refusal_message(too_close)
    assert all(word in message for word in ("50 mm", KIT.name, " 0.45 m", " 0.42 m"))
    nearest = KIT.mount(replace(FILM, pupil_offset_mm=440.0), KIT.lenses[0])
    assert nearest.close_focus_m == pytest.approx(0.055)  # no lens focuses within its length
