"""Handles of keys bend a curve as cubic Béziers do, and stay inside their segment."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from support.curves import BEZIER, HOLD, PARTS, SMOOTH, curve_of, curves, over


@given(PARTS)
def test_two_smooth_keys_make_the_smoothstep_and_so_do_handles_at_rest(part):
    expected = 2 + 6 * (3 * part**2 - 2 * part**3)
    for interpolation in (SMOOTH, BEZIER):
        curve = curve_of((1000, 2.0), (1024, 8.0), interpolation=interpolation)
        assert curve.value_at(1000 + 24 * part) == pytest.approx(expected, rel=1e-9)


@given(PARTS)
def test_handles_without_influence_make_a_line(part):
    still = Ease(0.0)
    curve = Curve((Key(0, 2.0, BEZIER, still, still), Key(8, 6.0, BEZIER, still, still)))
    assert curve.value_at(8 * part) == pytest.approx(2 + 4 * part, rel=1e-9)


@given(st.floats(0, 100), st.floats(-5, 5), st.floats(0.01, 0.99))
def test_a_bezier_with_two_equal_handles_is_point_symmetric(influence, speed, part):
    ease = Ease(influence, speed)
    curve = Curve((Key(-12, -1.0, BEZIER, ease, ease), Key(12, 1.0, BEZIER, ease, ease)))
    # Handles over the whole segment meet in the middle, where the curve stands upright.
    assume(influence < 95 or abs(part - 0.5) > 0.01)
    there, back = curve.value_at(24 * part - 12), curve.value_at(12 - 24 * part)
    assert there == pytest.approx(-back, abs=1e-6)


@given(st.floats(0, 100), st.floats(0, 100), st.floats(-3, 3), st.floats(-3, 3), PARTS)
def test_a_bezier_runs_through_its_control_polygons_cubic(out, into, fast, slow, t):
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
def test_handles_over_the_whole_segment_can_be_followed(influences):
    out, into = (Ease(influence) for influence in influences)
    curve = Curve((Key(0, 0.0, BEZIER, ease_out=out), Key(10, 1.0, ease_in=into)))
    inner = np.array([0, influences[0] / 10, 10 - influences[1] / 10, 10])
    for t in np.linspace(0, 1, 21):
        weights = np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        wanted = pytest.approx(3 * t**2 - 2 * t**3, abs=1e-4)
        assert curve.value_at(float(weights @ inner)) == wanted, t


@pytest.mark.parametrize("side", [-1, 1])
def test_where_a_curve_stands_upright_it_still_has_a_value(side):
    steep = Ease(100.0)
    curve = Curve((Key(-12, -1.0, BEZIER, steep, steep), Key(12, 1.0, BEZIER, steep, steep)))
    for digits in range(17):
        value = curve.value_at(side * 10.0**-digits) * side
        # Near the middle the time is 96 (t - 1/2)^3 frames, and the value 3 (t - 1/2).
        wanted = pytest.approx(3 * (10.0**-digits / 96) ** (1 / 3), rel=0.2, abs=1e-4)
        assert value == wanted, digits


@given(st.floats(0.1, 100), st.floats(-50, 50), st.floats(1, 500))
def test_a_handle_dragged_to_its_own_tip_stays_as_it_is(influence, speed, frames):
    ease = Ease(influence, speed)
    again = Ease.of_handle(*ease.handle(frames), frames)
    assert again.influence_percent == pytest.approx(influence)
    assert again.speed_per_frame == pytest.approx(speed, abs=1e-12)


@given(st.floats(-100, 100), st.floats(-100, 100), st.floats(1, 50))
def test_a_handle_cannot_leave_its_segment(frames, rise, segment):
    reach, height = Ease.of_handle(frames, rise, segment).handle(segment)
    assert 0 <= reach <= segment * (1 + 1e-12)
    if frames > 1e-3:  # it keeps its direction
        assert height * frames == pytest.approx(rise * reach, abs=1e-9)


@given(curves(), st.floats(800, 1300), st.floats(800, 1300))
def test_handles_for_a_segment_change_no_value(curve, at, frame):
    bent = curve.with_handles(at)
    assert bent.value_at(frame) == pytest.approx(curve.value_at(frame), rel=1e-6)
    segment = [key for key in bent.keys[:-1] if key.frame <= at][-1:]
    assert all(key.interpolation in (BEZIER, HOLD) for key in segment if at < bent.keys[-1].frame)


@pytest.mark.parametrize("way", [Interpolation.LINEAR, Interpolation.SMOOTH])
def test_handles_keep_the_path_of_a_line_and_of_a_smooth_segment(way):
    values = {1000.0: 2.0, 1010.0: 4.0, 1030.0: 8.0}
    curve = Curve(tuple(Key(frame, value, way) for frame, value in values.items()), Scale.LINEAR)
    bent = curve.with_handles(1012.0)
    assert [key.interpolation for key in bent.keys] == [way, BEZIER, way]
    for frame in np.linspace(1000, 1030, 31):
        assert bent.value_at(frame) == pytest.approx(curve.value_at(frame), rel=1e-6)


def test_a_handle_that_points_beyond_infinity_stops_there():
    fast = Ease(50.0, -1.0)
    curve = Curve((Key(0, 2.0, BEZIER, fast), Key(10, 4.0, ease_in=Ease())), Scale.RECIPROCAL)
    assert max(over(curve)) == math.inf
    assert min(over(curve)) > 0


@pytest.mark.parametrize("ease", [(-1.0, 0.0), (101.0, 0.0), (math.nan, 0.0), (50.0, math.inf)])
def test_impossible_handles_are_refused(ease):
    with pytest.raises(InputError):
        Ease(*ease)


@given(st.floats(0, 1), st.floats(0, 100), st.sampled_from(list(Scale)))
def test_a_bezier_between_equal_keys_stands_still_to_the_last_digit(part, influence, scale):
    """A squeeze of exactly 1 must not become less than any lens has."""
    ease = Ease(influence)
    first = Key(0, 1.1, Interpolation.BEZIER, ease, ease)
    curve = Curve((first, Key(7, 1.1, Interpolation.BEZIER, ease, ease)), scale)
    assert curve.value_at(7 * part) == 1.1
