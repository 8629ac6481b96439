"""A channel turns a ring: ends, curve, what is usual, and what is learnt by turning."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.live.ring.channel_map import (
    ChannelMap,
    Learning,
    Ring,
    channels_of,
    mapped,
    maps_for,
    usual_map,
)
from heatlens.media.live.ring.sources import LensSample

FOCUS = ChannelMap("/f", Ring.FOCUS, 10.0, 110.0, 0.5, math.inf)
ENDS = st.floats(0.3, 100.0)


def test_focus_turns_evenly_in_dioptres():
    assert FOCUS.value_at(10.0) == 0.5 and FOCUS.value_at(110.0) == math.inf
    assert FOCUS.value_at(60.0) == pytest.approx(1.0)  # half of two dioptres
    assert FOCUS.value_at(-5.0) == 0.5 and FOCUS.value_at(1e6) == math.inf


def test_a_bend_turns_slowly_at_the_first_end():
    bent = ChannelMap("/f", Ring.IRIS, 0.0, 1.0, 2.0, 8.0, bend=2.0)
    assert bent.value_at(0.5) == pytest.approx(2.0 * 4.0**0.25)
    assert (bent.value_at(0.0), bent.value_at(1.0)) == (2.0, 8.0)


@given(st.floats(-10, 10), st.sampled_from(Ring), ENDS, ENDS, st.floats(0.2, 5.0))
def test_the_value_stays_between_its_ends(told, ring, at_low, at_high, bend):
    found = ChannelMap("/x", ring, 1.0, -2.0, at_low, at_high, bend)
    low, high = sorted((at_low, at_high))
    assert low * (1 - 1e-9) <= found.value_at(told) <= high * (1 + 1e-9)


@pytest.mark.parametrize(
    "values",
    [{"low": 1.0, "high": 1.0}, {"bend": 9.0}, {"at_low": 0.0}, {"at_low": -1.0}],
)
def test_a_map_that_cannot_be_is_refused(values):
    with pytest.raises(InputError):
        ChannelMap(**{"channel": "/x", "ring": Ring.IRIS} | values)


def test_channels_with_a_usual_name_need_no_choice():
    sample = LensSample(channels={"/focus": 1.0, "/other": 0.3})
    assert mapped(sample, ()) == {"focus_distance_m": math.inf}
    assert maps_for(sample, ()) == (usual_map("/focus", Ring.FOCUS),)


def test_a_ring_that_tells_its_value_is_not_turned_by_its_encoder():
    sample = LensSample(focus_distance_m=2.0, focus_turn=0.5, iris_turn=0.5)
    assert set(mapped(sample, ())) == {"f_stop"}
    assert channels_of(sample) == {"focus ring": 0.5, "iris ring": 0.5}


def test_a_chosen_channel_comes_before_the_usual_one():
    sample = LensSample(channels={"/focus": 1.0, "/f": 60.0})
    assert mapped(sample, (FOCUS,)) == {"focus_distance_m": pytest.approx(1.0)}


@pytest.mark.parametrize(("first", "last"), [(3.0, 120.0), (120.0, 3.0)])
def test_a_control_is_learnt_by_turning_it(first, last):
    learning = Learning(Ring.FOCUS)
    for part in range(11):
        turned = first + (last - first) * part / 10
        learning.hear({"/still": 5.0, "/noisy": 5.0 + 0.01 * (part % 2), "/wheel": turned})
    found = learning.learnt()
    assert found is not None and found.channel == "/wheel"
    assert (found.low, found.high) == (first, last)
    assert found.value_at(first) == 0.5


def test_where_nothing_is_turned_nothing_is_learnt():
    learning = Learning(Ring.IRIS)
    assert learning.learnt() is None
    learning.hear({"/still": 0.0})
    learning.hear({"/still": 0.0})
    assert learning.learnt() is None
