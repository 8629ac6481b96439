"""The lens that is focused at a vergence: its reciprocal, infinity at 0, never inside the lens."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.coc_line import focused_at

LENS = Lens(50.0, 2.0, 2.0, 36.0)


@given(st.floats(1e-3, 15.0))
def test_the_distance_is_the_reciprocal(dioptres):
    assert focused_at(LENS, dioptres).focus_distance_m == pytest.approx(1 / dioptres)


@given(st.floats(-5.0, 1e-5))
def test_no_vergence_is_infinity_as_what_lies_beyond(dioptres):
    assert focused_at(LENS, dioptres).focus_distance_m == math.inf


@given(st.floats(20.0, 1e6))
def test_focus_stays_beyond_the_focal_length(dioptres):
    assert focused_at(LENS, dioptres).focus_distance_m == pytest.approx(0.051)
