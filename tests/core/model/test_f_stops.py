"""Test the third stops of the aperture ring: their numbers and stepping along them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import THIRD_STOPS, nearest_index, step_f_stop

ON_THE_RING = st.sampled_from(THIRD_STOPS)
F_STOPS = st.floats(0.05, 200)
WHOLE_STOPS = (0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0)


def test_third_stops_are_rounded_powers_of_sixth_root_of_two():
    """Engraved numbers are off by up to 1/7 stop (1.2 for 1.26), less than half a third stop."""
    exact = 2.0 ** (np.arange(len(THIRD_STOPS)) / 6 - 0.5)
    stops_off = 2 * np.abs(np.log2(np.array(THIRD_STOPS) / exact))
    assert stops_off.max() < 1 / 6
    assert THIRD_STOPS[::3] == WHOLE_STOPS


@given(ON_THE_RING, st.integers(-40, 40))
def test_step_f_stop_moves_along_third_stops_and_stops_at_ends(f_stop, steps):
    index = THIRD_STOPS.index(f_stop) + steps
    assert step_f_stop(f_stop, steps) == THIRD_STOPS[min(max(index, 0), len(THIRD_STOPS) - 1)]


@given(F_STOPS)
def test_step_f_stop_from_between_stops_goes_to_next_third_stop(f_stop):
    up, down = step_f_stop(f_stop, 1), step_f_stop(f_stop, -1)
    above = [n for n in THIRD_STOPS if n > f_stop * (1 + 1e-4)]
    below = [n for n in THIRD_STOPS if n < f_stop * (1 - 1e-4)]
    assert up == (above[0] if above else THIRD_STOPS[-1])
    assert down == (below[-1] if below else THIRD_STOPS[0])


@given(F_STOPS)
def test_step_f_stop_by_zero_returns_f_stop_unchanged(f_stop):
    assert step_f_stop(f_stop, 0) == f_stop


@given(ON_THE_RING)
def test_step_f_stop_treats_float32_third_stop_as_on_the_ring(f_stop):
    as_float32 = float(np.float32(f_stop))
    assert [step_f_stop(as_float32, n) for n in (-1, 1)] == [
        step_f_stop(f_stop, n) for n in (-1, 1)
    ]


@given(ON_THE_RING)
def test_nearest_index_of_third_stop_is_its_own(f_stop):
    assert THIRD_STOPS[nearest_index(f_stop)] == f_stop


@pytest.mark.parametrize(
    ("f_stop", "expected"), [(0.1, 0.7), (1.3, 1.4), (2.9, 2.8), (500.0, 32.0)]
)
def test_nearest_index_matches_worked_examples(f_stop, expected):
    assert THIRD_STOPS[nearest_index(f_stop)] == expected


@given(F_STOPS)
def test_nearest_index_minimizes_distance_in_stops(f_stop):
    stops_off = [abs(math.log2(n / f_stop)) for n in THIRD_STOPS]
    assert stops_off[nearest_index(f_stop)] == min(stops_off)
