"""Test channel maps of a lens ring: ends, curve, usual names, and learning by turning."""

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
    default_map,
    map_channels,
    maps_for,
)
from heatlens.media.live.ring.sources import LensSample

FOCUS = ChannelMap(
    channel="/f", ring=Ring.FOCUS, low=10.0, high=110.0, at_low=0.5, at_high=math.inf
)
ENDS = st.floats(0.3, 100.0)


def test_channel_map_of_focus_is_linear_in_dioptres():
    assert FOCUS.value_at(10.0) == 0.5 and FOCUS.value_at(110.0) == math.inf
    assert FOCUS.value_at(60.0) == pytest.approx(1.0)  # half of two dioptres
    assert FOCUS.value_at(-5.0) == 0.5 and FOCUS.value_at(1e6) == math.inf


def test_channel_map_bend_is_slow_at_the_first_end():
    bent_map = ChannelMap(
        channel="/f", ring=Ring.IRIS, low=0.0, high=1.0, at_low=2.0, at_high=8.0, bend=2.0
    )
    assert bent_map.value_at(0.5) == pytest.approx(2.0 * 4.0**0.25)
    assert (bent_map.value_at(0.0), bent_map.value_at(1.0)) == (2.0, 8.0)


@given(st.floats(-10, 10), st.sampled_from(Ring), ENDS, ENDS, st.floats(0.2, 5.0))
def test_channel_map_value_stays_between_its_ends(told, ring, at_low, at_high, bend):
    channel_map = ChannelMap(
        channel="/x", ring=ring, low=1.0, high=-2.0, at_low=at_low, at_high=at_high, bend=bend
    )
    low, high = sorted((at_low, at_high))
    assert low * (1 - 1e-9) <= channel_map.value_at(told) <= high * (1 + 1e-9)


@pytest.mark.parametrize(
    "values", [{"low": 1.0, "high": 1.0}, {"bend": 9.0}, {"at_low": 0.0}, {"at_low": -1.0}]
)
def test_channel_map_rejects_impossible_values(values):
    with pytest.raises(InputError):
        ChannelMap(**{"channel": "/x", "ring": Ring.IRIS} | values)


def test_map_channels_uses_channels_with_usual_names():
    sample = LensSample(channels={"/focus": 1.0, "/other": 0.3})
    assert map_channels(sample, ()) == {"focus_distance_m": math.inf}
    assert maps_for(sample, ()) == (default_map("/focus", Ring.FOCUS),)


def test_map_channels_ignores_encoder_of_ring_that_reports_its_value():
    sample = LensSample(focus_distance_m=2.0, focus_turn=0.5, iris_turn=0.5)
    assert set(map_channels(sample, ())) == {"f_stop"}
    assert channels_of(sample) == {"focus ring": 0.5, "iris ring": 0.5}


def test_map_channels_prefers_chosen_channel_over_usual_one():
    sample = LensSample(channels={"/focus": 1.0, "/f": 60.0})
    assert map_channels(sample, (FOCUS,)) == {"focus_distance_m": pytest.approx(1.0)}


@pytest.mark.parametrize(("first", "last"), [(3.0, 120.0), (120.0, 3.0)])
def test_learning_finds_the_channel_that_is_turned(first, last):
    learning = Learning(Ring.FOCUS)
    for step in range(11):
        turned = first + (last - first) * step / 10
        learning.observe({"/still": 5.0, "/noisy": 5.0 + 0.01 * (step % 2), "/wheel": turned})
    channel_map = learning.learned_map()
    assert channel_map is not None and channel_map.channel == "/wheel"
    assert (channel_map.low, channel_map.high) == (first, last)
    assert channel_map.value_at(first) == 0.5


def test_learning_without_turned_channel_finds_none():
    learning = Learning(Ring.IRIS)
    assert learning.learned_map() is None
    learning.observe({"/still": 0.0})
    learning.observe({"/still": 0.0})
    assert learning.learned_map() is None
