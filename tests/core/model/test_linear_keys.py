"""Test `linear_keys`: the fewest linear keys that meet a track of values at every frame."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.curve import Curve
from heatlens.core.model.curves.interpolation import Interpolation, Scale
from heatlens.core.model.curves.key_reduction import linear_keys

TRACKS = st.lists(st.sampled_from([1.0, 1.5, 2.0, 3.0, 8.0]), min_size=2, max_size=12)


@given(TRACKS, st.sampled_from(list(Scale)))
def test_linear_keys_meet_value_at_every_frame(track, scale):
    frames = tuple(range(11, 11 + len(track)))
    keys = linear_keys(frames, tuple(track), scale)
    if len(set(track)) == 1:
        assert keys == ()
        return
    curve = Curve(keys, scale)
    assert [curve.value_at(frame) for frame in frames] == pytest.approx(track, rel=1e-6)
    assert {key.interpolation for key in keys} == {Interpolation.LINEAR}
    assert (keys[0].frame, keys[-1].frame) == (frames[0], frames[-1])


@pytest.mark.parametrize("scale", Scale)
def test_linear_keys_use_two_keys_for_line_and_one_per_bend(scale):
    scaled_ends = [scale.position_of(value) for value in (2.0, 8.0)]

    def values(*bends):
        scaled_values = np.interp(range(21), np.linspace(0, 20, len(bends)), bends)
        return [float(np.float32(scale.value_at(place))) for place in scaled_values]

    frames = tuple(range(21))
    assert [key.frame for key in linear_keys(frames, tuple(values(*scaled_ends)), scale)] == [0, 20]
    bent = values(*scaled_ends, *scaled_ends)  # there and back and there
    keys = linear_keys(tuple(range(0, 42, 2)), tuple(bent), scale)
    assert len(keys) <= 6 and {0, 40} < {key.frame for key in keys}


def test_linear_keys_ignore_errors_below_float32_precision():
    track = [1.0, 2.0, 3.0, 4.0, 5.0]
    frames = (0, 1, 2, 3, 4)
    assert len(linear_keys(frames, tuple(track), Scale.LINEAR)) == 2
    for error, count in ((1e-8, 2), (1e-5, 4)):
        changed_track = (*track[:2], 3.0 * (1 + error), *track[3:])
        assert len(linear_keys(frames, changed_track, Scale.LINEAR)) >= count
        assert (len(linear_keys(frames, changed_track, Scale.LINEAR)) == 2) is (count == 2)


def test_linear_keys_handle_infinity_on_reciprocal_scale():
    keys = linear_keys((1, 2, 3), (2.0, 4.0, math.inf), Scale.RECIPROCAL)
    assert [(key.frame, key.value) for key in keys] == [(1, 2.0), (3, math.inf)]
