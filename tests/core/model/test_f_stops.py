"""The aperture ring: its numbers against the powers they stand for, and what stepping promises."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import THIRD_STOPS, nearest_index, stepped

ON_THE_RING = st.sampled_from(THIRD_STOPS)
F_STOPS = st.floats(0.05, 200)
WHOLE_STOPS = (0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0)


def test_they_are_the_powers_of_the_sixth_root_of_two():
    """Engravers round by up to a seventh of a stop (1.2 for 1.26): less than half a third."""
    exact = 2.0 ** (np.arange(len(THIRD_STOPS)) / 6 - 0.5)
    stops_off = 2 * np.abs(np.log2(np.array(THIRD_STOPS) / exact))
    assert stops_off.max() < 1 / 6
    assert THIRD_STOPS[::3] == WHOLE_STOPS


@given(ON_THE_RING, st.integers(-40, 40))
def test_steps_go_along_the_ring_and_stay_on_it(f_stop, steps):
    index = THIRD_STOPS.index(f_stop) + steps
    assert stepped(f_stop, steps) == THIRD_STOPS[min(max(index, 0), len(THIRD_STOPS) - 1)]


@given(F_STOPS)
def test_a_step_from_between_goes_to_the_next_one_engraved(f_stop):
    up, down = stepped(f_stop, 1), stepped(f_stop, -1)
    above = [n for n in THIRD_STOPS if n > f_stop * (1 + 1e-4)]
    below = [n for n in THIRD_STOPS if n < f_stop * (1 - 1e-4)]
    assert up == (above[0] if above else THIRD_STOPS[-1])
    assert down == (below[-1] if below else THIRD_STOPS[0])


@given(F_STOPS)
def test_no_step_changes_nothing(f_stop):
    assert stepped(f_stop, 0) == f_stop


@given(ON_THE_RING)
def test_a_value_that_went_through_single_precision_is_still_on_the_ring(f_stop):
    as_float32 = float(np.float32(f_stop))
    assert [stepped(as_float32, n) for n in (-1, 1)] == [stepped(f_stop, n) for n in (-1, 1)]


@given(ON_THE_RING)
def test_each_is_nearest_to_itself(f_stop):
    assert THIRD_STOPS[nearest_index(f_stop)] == f_stop


@pytest.mark.parametrize(("f_stop", "shown"), [(0.1, 0.7), (1.3, 1.4), (2.9, 2.8), (500.0, 32.0)])
def test_the_nearest_place(f_stop, shown):
    assert THIRD_STOPS[nearest_index(f_stop)] == shown


@given(F_STOPS)
def test_nothing_engraved_is_nearer_in_stops(f_stop):
    stops_off = [abs(math.log2(n / f_stop)) for n in THIRD_STOPS]
    assert stops_off[nearest_index(f_stop)] == min(stops_off)
