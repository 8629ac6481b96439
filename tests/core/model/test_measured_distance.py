"""What people read beside a lens that is measured from the film plane, and what kits allow."""

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
KIT = LensKit("primes", "a lens", (KitLens(50.0, 1.4, 0.45),))


@given(st.floats(0.2, 1e4), st.floats(-200.0, 200.0))
def test_what_is_read_is_typed_back(distance_m, offset_mm):
    lens = replace(FILM, pupil_offset_mm=offset_mm)
    assert from_pupil_m(lens, as_measured_m(lens, distance_m)) == pytest.approx(distance_m)
    assert as_measured_m(replace(lens, measured_from=MeasuredFrom.PUPIL), distance_m) == distance_m


def test_words_and_infinity():
    assert measured_text(FILM, 2.0) == "2.12 m"
    assert parse_measured_m(FILM, "2.12") == pytest.approx(2.0)
    assert measured_text(FILM, float("inf")) == format_distance(float("inf"))


def test_a_kit_tells_its_close_focus_from_where_the_lens_is_measured():
    mounted = KIT.mounted(FILM, KIT.lenses[0])
    assert mounted.close_focus_m == pytest.approx(0.33)
    asked = replace(mounted, focus_distance_m=0.3)
    assert KIT.followed(mounted, asked).focus_distance_m == pytest.approx(0.33)
    said = KIT.refusal(asked)
    assert all(word in said for word in ("50 mm", KIT.name, " 0.45 m", " 0.42 m"))
    nearest = KIT.mounted(replace(FILM, pupil_offset_mm=440.0), KIT.lenses[0])
    assert nearest.close_focus_m == pytest.approx(0.055)  # no lens focuses within its length
