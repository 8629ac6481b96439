"""Test handles of keys, which bend a curve as cubic Béziers do and stay in their segment."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from support.curves import BEZIER, HOLD, PARTS, SMOOTH, curve_of, curves, sampled_values


@given(PARTS)
def test_smooth_keys_and_default_handles_give_smoothstep(part):
    expected = 2 + 6 * (3 * part**2 - 2 * part**3)
    for interpolation in (SMOOTH, BEZIER):
        curve = curve_of((1000, 2.0), (1024, 8.0), interpolation=interpolation)
        assert curve.value_at(1000 + 24 * part) == pytest.approx(expected, rel=1e-9)


@given(PARTS)
def test_bezier_without_influence_is_straight_line(part):
    still = Ease(0.0)
    curve = Curve((Key(0, 2.0, BEZIER, still, still), Key(8, 6.0, BEZIER, still, still)))
    assert curve.value_at(8 * part) == pytest.approx(2 + 4 * part, rel=1e-9)


@given(st.floats(0, 100), st.floats(-5, 5), st.floats(0.01, 0.99))
def test_bezier_with_equal_handles_is_point_symmetric(influence, speed, part):
    ease = Ease(influence, speed)
    curve = Curve((Key(-12, -1.0, BEZIER, ease, ease), Key(12, 1.0, BEZIER, ease, ease)))
    # Handles over the whole segment meet in the middle, where the curve stands upright.
    assume(influence < 95 or abs(part - 0.5) > 0.01)
    value, mirrored_value = curve.value_at(24 * part - 12), curve.value_at(12 - 24 * part)
    assert value == pytest.approx(-mirrored_value, abs=1e-6)


@given(st.floats(0, 100), st.floats(0, 100), st.floats(-3, 3), st.floats(-3, 3), PARTS)
def test_bezier_segment_equals_cubic_of_control_polygon(out, into, fast, slow, t):
    start, end = Ease(out, fast), Ease(into, slow)
    curve = Curve((Key(0, 1.0, BEZIER, ease_out=start), Key(10, 4.0, ease_in=end)))
    (x1, y1), (x2, y2) = start.handle(10), end.handle(10)
    weights = np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    frame = float(weights @ [0, x1, 10 - x2, 10])
    slope = float(np.diff([0, x1, 10 - x2, 10]) @ [(1 - t) ** 2, 2 * t * (1 - t), t**2])
    assume(slope > 1e-2)
    value = float(weights @ [1, 1 + y1, 4 - y2, 4])
    assert curve.value_at(frame) == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize("influences", [(0, 100), (100, 0), (100, 100), (99.999, 100)])
def test_bezier_with_full_length_handles_has_exact_values(influences):
    out, into = (Ease(influence) for influence in influences)
    curve = Curve((Key(0, 0.0, BEZIER, ease_out=out), Key(10, 1.0, ease_in=into)))
    inner = np.array([0, influences[0] / 10, 10 - influences[1] / 10, 10])
    for t in np.linspace(0, 1, 21):
        weights = np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        expected = pytest.approx(3 * t**2 - 2 * t**3, abs=1e-4)
        assert curve.value_at(float(weights @ inner)) == expected, t


@pytest.mark.parametrize("side", [-1, 1])
def test_bezier_has_value_near_vertical_tangent(side):
    steep = Ease(100.0)
    curve = Curve((Key(-12, -1.0, BEZIER, steep, steep), Key(12, 1.0, BEZIER, steep, steep)))
    for digits in range(17):
        value = curve.value_at(side * 10.0**-digits) * side
        # Near the middle the time is 96 (t - 1/2)^3 frames, and the value 3 (t - 1/2).
        expected = pytest.approx(3 * (10.0**-digits / 96) ** (1 / 3), rel=0.2, abs=1e-4)
        assert value == expected, digits


@given(st.floats(0.1, 100), st.floats(-50, 50), st.floats(1, 500))
def test_ease_survives_conversion_to_handle_and_back(influence, speed, frames):
    ease = Ease(influence, speed)
    dragged_ease = Ease.of_handle(*ease.handle(frames), frames)
    assert dragged_ease.influence_percent == pytest.approx(influence)
    assert dragged_ease.speed_per_frame == pytest.approx(speed, abs=1e-12)


@given(st.floats(-100, 100), st.floats(-100, 100), st.floats(1, 50))
def test_ease_of_handle_clamps_handle_to_segment(frames, rise, segment):
    reach, height = Ease.of_handle(frames, rise, segment).handle(segment)
    assert 0 <= reach <= segment * (1 + 1e-12)
    if frames > 1e-3:  # it keeps its direction
        assert height * frames == pytest.approx(rise * reach, abs=1e-9)


@given(curves(), st.floats(800, 1300), st.floats(800, 1300))
def test_with_handles_changes_no_value_of_curve(curve, at, frame):
    bent = curve.with_handles(at)
    assert bent.value_at(frame) == pytest.approx(curve.value_at(frame), rel=1e-6)
    segment = [key for key in bent.keys[:-1] if key.frame <= at][-1:]
    assert all(key.interpolation in (BEZIER, HOLD) for key in segment if at < bent.keys[-1].frame)


@pytest.mark.parametrize("interpolation", [Interpolation.LINEAR, Interpolation.SMOOTH])
def test_with_handles_converts_one_segment_to_bezier_of_same_path(interpolation):
    values = {1000.0: 2.0, 1010.0: 4.0, 1030.0: 8.0}
    curve = Curve(
        tuple(Key(frame, value, interpolation) for frame, value in values.items()), Scale.LINEAR
    )
    bent = curve.with_handles(1012.0)
    assert [key.interpolation for key in bent.keys] == [interpolation, BEZIER, interpolation]
    for frame in np.linspace(1000, 1030, 31):
        assert bent.value_at(frame) == pytest.approx(curve.value_at(frame), rel=1e-6)


def test_reciprocal_bezier_beyond_infinity_is_clamped_to_infinity():
    fast = Ease(50.0, -1.0)
    curve = Curve((Key(0, 2.0, BEZIER, fast), Key(10, 4.0, ease_in=Ease())), Scale.RECIPROCAL)
    assert max(sampled_values(curve)) == math.inf
    assert min(sampled_values(curve)) > 0


@pytest.mark.parametrize("ease", [(-1.0, 0.0), (101.0, 0.0), (math.nan, 0.0), (50.0, math.inf)])
def test_ease_rejects_influence_or_speed_out_of_range(ease):
    with pytest.raises(InputError):
        Ease(*ease)


@given(st.floats(0, 1), st.floats(0, 100), st.sampled_from(list(Scale)))
def test_bezier_between_equal_keys_is_exactly_constant(part, influence, scale):
    """Rounding must not turn a squeeze of exactly 1 into one below the range of a lens."""
    ease = Ease(influence)
    first = Key(frame=0, value=1.1, interpolation=Interpolation.BEZIER, ease_out=ease, ease_in=ease)
    curve = Curve((first, Key(7, 1.1, Interpolation.BEZIER, ease, ease)), scale)
    assert curve.value_at(7 * part) == 1.1
