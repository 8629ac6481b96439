"""Test that curves meet their keys and stay between them, on every scale."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Scale
from support.curves import (
    BEZIER,
    HOLD,
    LINEAR,
    PARTS,
    SMOOTH,
    UNBENT,
    curve_of,
    curves,
    sampled_values,
)


@given(curves())
def test_curve_value_at_key_frame_equals_key_value(curve):
    assert all(curve.value_at(key.frame) == key.value for key in curve.keys)


@given(curves(), st.floats(0, 1e6))
def test_curve_is_constant_before_first_and_after_last_key(curve, far):
    assert curve.value_at(curve.keys[0].frame - far) == curve.keys[0].value
    assert curve.value_at(curve.keys[-1].frame + far) == curve.keys[-1].value


@given(curves(UNBENT), st.floats(800, 1300))
def test_unbent_curve_stays_between_its_neighboring_keys(curve, frame):
    before = [key for key in curve.keys if key.frame <= frame][-1:] or curve.keys[:1]
    after = [key for key in curve.keys if key.frame > frame][:1] or before
    low, high = sorted((before[0].value, after[0].value))
    assert low <= curve.value_at(frame) <= high


@given(curves((SMOOTH,), least=3))
def test_smooth_curve_through_rising_keys_never_falls(curve):
    rising = [
        replace(key, value=value)
        for key, value in zip(curve.keys, sorted(k.value for k in curve.keys), strict=True)
    ]
    curve_values = sampled_values(replace(curve, keys=tuple(rising)))
    # In dioptres a rise below the rounding of 1/value can come back as a fall of that size.
    assert all(b >= a * (1 - 1e-14) for a, b in pairwise(curve_values))


@given(curves((SMOOTH,), least=2), PARTS)
def test_smooth_curve_equals_scipy_pchip_interpolator(curve, part):
    from scipy.interpolate import PchipInterpolator  # here: costs every worker a second to collect

    frames = [key.frame for key in curve.keys]
    scaled_values = [curve.scale.position_of(key.value) for key in curve.keys]
    # Standing still before and after is what makes the ends flat.
    padded = PchipInterpolator(
        [frames[0] - 1, *frames, frames[-1] + 1],
        [scaled_values[0], *scaled_values, scaled_values[-1]],
    )
    frame = frames[0] + part * (frames[-1] - frames[0])
    expected = curve.scale.value_at(float(padded(frame)))
    assert curve.value_at(frame) == pytest.approx(expected, rel=1e-9)


@given(curves((HOLD,), least=2), st.integers(0, 5), st.floats(0, 1, exclude_max=True))
def test_hold_segment_keeps_value_of_its_first_key(curve, index, part):
    assume(index < len(curve.keys) - 1)
    key, after = curve.keys[index : index + 2]
    frame = key.frame + part * (after.frame - key.frame)
    assume(frame < after.frame)  # the sum can round up to it
    assert curve.value_at(frame) == key.value


@given(PARTS)
def test_smooth_segment_after_hold_starts_with_zero_slope(part):
    curve = Curve((Key(frame=0, value=1.0, interpolation=HOLD), Key(10, 5.0), Key(20, 9.0)))
    expected = 5 + 4 * (3 * part**2 - 2 * part**3)
    assert curve.value_at(10 + 10 * part) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("scale", "middle"), [(Scale.LINEAR, 5.0), (Scale.RECIPROCAL, 3.2), (Scale.LOGARITHMIC, 4.0)]
)
def test_curve_value_halfway_is_mean_on_its_scale(scale, middle):
    for interpolation in (LINEAR, SMOOTH, BEZIER):
        curve = curve_of((0, 2.0), (10, 8.0), interpolation=interpolation, scale=scale)
        assert curve.value_at(5) == pytest.approx(middle, rel=1e-12)


def test_reciprocal_curve_reaches_infinity_as_zero_dioptres():
    curve = curve_of((0, 2.0), (10, math.inf), interpolation=LINEAR, scale=Scale.RECIPROCAL)
    assert curve.value_at(5) == pytest.approx(4.0, rel=1e-12)
    assert curve.value_at(9.999) > 1e4
    assert curve.value_at(10) == curve.value_at(11) == math.inf
    still = curve_of((0, math.inf), (10, math.inf), scale=Scale.RECIPROCAL)
    assert still.value_at(5) == math.inf


@pytest.mark.parametrize(
    ("scale", "value"),
    [
        (Scale.LINEAR, math.inf),
        (Scale.LINEAR, -math.inf),
        (Scale.LOGARITHMIC, math.inf),
        (Scale.LOGARITHMIC, 0.0),
        (Scale.RECIPROCAL, 0.0),
        (Scale.RECIPROCAL, -1.0),
        *((scale, math.nan) for scale in Scale),
    ],
)
def test_curve_rejects_value_outside_its_scale(scale, value):
    with pytest.raises(InputError, match="cannot have the value"):
        Curve((Key(0, value),), scale)


@pytest.mark.parametrize(
    ("frames", "words"),
    [((1, 0), "must be sorted by frame"), ((0, 0), "two keys"), ((0, 1e-5), "two keys at frame 0")],
)
def test_curve_rejects_unsorted_or_coinciding_keys(frames, words):
    with pytest.raises(InputError, match=words):
        curve_of(*((frame, 1.0) for frame in frames))


@pytest.mark.parametrize("frame", [math.nan, math.inf, 1e9])
def test_key_rejects_frame_of_more_than_nine_digits(frame):
    with pytest.raises(InputError, match="nine digits"):
        Key(frame, 1.0)


def test_equal_curves_have_equal_hashes():
    assert len({curve_of((0, 1.0)), curve_of((0, 1.0)), curve_of((0, 2.0))}) == 2


def test_value_at_of_empty_curve_raises_value_error():
    with pytest.raises(ValueError, match="without keys"):
        Curve().value_at(0)
