"""Test `focused_at`: the distance is 1 / vergence, infinity at 0, and never inside the lens."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.coc_line import focused_at

LENS = Lens(50.0, 2.0, 2.0, 36.0)


@given(st.floats(1e-3, 15.0))
def test_focused_at_sets_reciprocal_distance(dioptres):
    assert focused_at(LENS, dioptres).focus_distance_m == pytest.approx(1 / dioptres)


@given(st.floats(-5.0, 1e-5))
def test_focused_at_no_vergence_or_less_is_infinity(dioptres):
    assert focused_at(LENS, dioptres).focus_distance_m == math.inf


@given(st.floats(20.0, 1e6))
def test_focused_at_keeps_focus_beyond_focal_length(dioptres):
    assert focused_at(LENS, dioptres).focus_distance_m == pytest.approx(0.051)
