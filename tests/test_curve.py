"""Curves meet their keys and nothing beyond them, on every scale; edits do what they say."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from heatlens.errors import InputError
from heatlens.model.curve import Curve, Key
from heatlens.model.interpolation import Ease, Interpolation, Scale

HOLD, LINEAR, SMOOTH, BEZIER = Interpolation
UNBENT = (HOLD, LINEAR, SMOOTH)  # those that stay between their keys whatever the handles say

FRAMES = st.lists(st.integers(900, 1200), min_size=1, max_size=7, unique=True).map(sorted)
VALUES = st.floats(0.05, 500.0)
EASES = st.builds(Ease, st.floats(0, 100), st.floats(-0.01, 0.01))
PARTS = st.floats(0, 1)


@st.composite
def curves(draw, interpolations=tuple(Interpolation), least=1, scales=tuple(Scale), values=VALUES):
    frames = draw(FRAMES.filter(lambda found: len(found) >= least))
    keys = [
        Key(frame, draw(values), draw(st.sampled_from(interpolations)), draw(EASES), draw(EASES))
        for frame in frames
    ]
    return Curve(tuple(keys), draw(st.sampled_from(scales)))


def curve_of(*frames_and_values, interpolation=SMOOTH, scale=Scale.LINEAR):
    keys = (Key(frame, value, interpolation) for frame, value in frames_and_values)
    return Curve(tuple(keys), scale)


def over(curve: Curve, count: int = 201) -> list[float]:
    first, last = curve.keys[0].frame, curve.keys[-1].frame
    return [curve.value_at(float(frame)) for frame in np.linspace(first, last, count)]


@given(curves())
def test_keys_are_met_exactly(curve):
    assert all(curve.value_at(key.frame) == key.value for key in curve.keys)


@given(curves(), st.floats(0, 1e6))
def test_the_value_stands_still_before_the_first_key_and_after_the_last(curve, far):
    assert curve.value_at(curve.keys[0].frame - far) == curve.keys[0].value
    assert curve.value_at(curve.keys[-1].frame + far) == curve.keys[-1].value


@given(curves(UNBENT), st.floats(800, 1300))
def test_no_value_lies_beyond_the_keys_on_either_side(curve, frame):
    before = [key for key in curve.keys if key.frame <= frame][-1:] or curve.keys[:1]
    after = [key for key in curve.keys if key.frame > frame][:1] or before
    low, high = sorted((before[0].value, after[0].value))
    assert low <= curve.value_at(frame) <= high


@given(curves((SMOOTH,), least=3))
def test_values_that_only_grow_make_a_smooth_curve_that_only_grows(curve):
    rising = [
        replace(key, value=value)
        for key, value in zip(curve.keys, sorted(k.value for k in curve.keys), strict=True)
    ]
    found = over(replace(curve, keys=tuple(rising)))
    # In dioptres a rise below the rounding of 1/value can come back as a fall of that size.
    assert all(b >= a * (1 - 1e-14) for a, b in pairwise(found))


@given(curves((SMOOTH,), least=2), PARTS)
def test_a_smooth_curve_is_the_monotone_cubic_of_scipy(curve, part):
    frames = [key.frame for key in curve.keys]
    places = [curve.scale.place_of(key.value) for key in curve.keys]
    # Standing still before and after is what makes the ends flat.
    padded = PchipInterpolator(
        [frames[0] - 1, *frames, frames[-1] + 1], [places[0], *places, places[-1]]
    )
    frame = frames[0] + part * (frames[-1] - frames[0])
    expected = curve.scale.value_at(float(padded(frame)))
    assert curve.value_at(frame) == pytest.approx(expected, rel=1e-9)


@given(curves((HOLD,), least=2), st.integers(0, 5), st.floats(0, 1, exclude_max=True))
def test_hold_is_piecewise_constant(curve, index, part):
    assume(index < len(curve.keys) - 1)
    key, after = curve.keys[index : index + 2]
    frame = key.frame + part * (after.frame - key.frame)
    assume(frame < after.frame)  # the sum can round up to it
    assert curve.value_at(frame) == key.value


@given(PARTS)
def test_after_a_hold_a_smooth_value_sets_off_from_rest(part):
    curve = Curve((Key(0, 1.0, HOLD), Key(10, 5.0), Key(20, 9.0)))
    expected = 5 + 4 * (3 * part**2 - 2 * part**3)
    assert curve.value_at(10 + 10 * part) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("scale", "middle"),
    [(Scale.LINEAR, 5.0), (Scale.RECIPROCAL, 3.2), (Scale.LOGARITHMIC, 4.0)],
)
def test_halfway_is_a_mean_of_the_scales_kind(scale, middle):
    for interpolation in (LINEAR, SMOOTH, BEZIER):
        curve = curve_of((0, 2.0), (10, 8.0), interpolation=interpolation, scale=scale)
        assert curve.value_at(5) == pytest.approx(middle, rel=1e-12)


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
@pytest.mark.parametrize("t", np.linspace(0, 1, 21))
def test_handles_over_the_whole_segment_can_be_followed(influences, t):
    out, into = (Ease(influence) for influence in influences)
    curve = Curve((Key(0, 0.0, BEZIER, ease_out=out), Key(10, 1.0, ease_in=into)))
    inner = np.array([0, influences[0] / 10, 10 - influences[1] / 10, 10])
    frame = float(np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3]) @ inner)
    assert curve.value_at(frame) == pytest.approx(3 * t**2 - 2 * t**3, abs=1e-4)


@pytest.mark.parametrize("digits", range(17))
@pytest.mark.parametrize("side", [-1, 1])
def test_where_a_curve_stands_upright_it_still_has_a_value(digits, side):
    steep = Ease(100.0)
    curve = Curve((Key(-12, -1.0, BEZIER, steep, steep), Key(12, 1.0, BEZIER, steep, steep)))
    value = curve.value_at(side * 10.0**-digits) * side
    # Near the middle the time is 96 (t - 1/2)^3 frames, and the value 3 (t - 1/2).
    assert value == pytest.approx(3 * (10.0**-digits / 96) ** (1 / 3), rel=0.2, abs=1e-4)


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


@given(curves(), st.integers(-5000, 5000), st.integers(800, 1300))
def test_moving_all_keys_moves_the_curve(curve, by_frames, frame):
    frames = {key.frame for key in curve.keys}
    assert curve.moved(frames, by_frames).value_at(frame + by_frames) == curve.value_at(frame)


@given(curves(), st.integers(-5000, 5000))
def test_keys_move_there_and_back(curve, by_frames):
    frames = {key.frame for key in curve.keys}
    there = curve.moved(frames, by_frames)
    assert there.moved({key.frame for key in there.keys}, -by_frames) == curve


@given(curves(), st.floats(0.1, 10), st.floats(800, 1300))
def test_multiplied_keys_multiply_the_value_everywhere(curve, factor, frame):
    expected = curve.value_at(frame) * factor
    found = curve.multiplied(factor).value_at(frame)
    assert found == pytest.approx(expected, rel=1e-6)


@given(curves(), st.integers(900, 1200), VALUES)
def test_a_key_takes_the_place_of_the_one_at_its_frame(curve, frame, value):
    frames = {key.frame for key in curve.keys} | {frame}
    changed = curve.with_value(frame, value)
    assert [key.frame for key in changed.keys] == sorted(frames)
    assert changed.value_at(frame) == value
    assert changed.without_keys({frame}).keys == curve.without_keys({frame}).keys


def test_an_edit_moves_nothing_further_than_two_segments_away():
    curve = curve_of(*((10 * i, float(i * i % 7)) for i in range(8)))
    changed = curve.with_value(30, 9.0)
    untouched = [*range(11), *range(50, 71)]
    assert all(changed.value_at(f) == curve.value_at(f) for f in untouched)
    assert changed.value_at(15) != curve.value_at(15)


def test_a_new_key_goes_on_as_the_one_before_it():
    curve = Curve((Key(0, 1.0, LINEAR), Key(10, 3.0, HOLD), Key(20, 5.0)))
    assert curve.with_value(5, 2.5).key_at(5) == Key(5, 2.5, LINEAR)
    assert curve.with_value(15, 2.5).key_at(15) == Key(15, 2.5, HOLD)
    assert curve.with_value(-5, 2.5).key_at(-5) == Key(-5, 2.5, SMOOTH)


def test_a_key_that_takes_a_value_keeps_its_handles():
    key = Key(5, 1.0, BEZIER, Ease(80.0), Ease(10.0))
    assert Curve((key,)).with_value(5, 2.0).keys == (replace(key, value=2.0),)


def test_ripple_makes_room_and_cuts_out():
    curve = curve_of((0, 1.0), (10, 2.0), (20, 3.0), (30, 4.0))
    assert [k.frame for k in curve.rippled(20, 5).keys] == [0, 10, 25, 35]
    shorter = curve.rippled(20, -12)
    assert [(k.frame, k.value) for k in shorter.keys] == [(0, 1.0), (8, 3.0), (18, 4.0)]


def test_keys_are_copied_to_another_time():
    curve = curve_of((0, 1.0), (10, 2.0), (20, 3.0), (30, 4.0))
    pasted = curve.pasted(curve.copied({10, 20}), 30)
    assert [(k.frame, k.value) for k in pasted.keys][2:] == [(20, 3.0), (30, 2.0), (40, 3.0)]
    assert curve.copied({11}) == ()


def test_moved_keys_replace_those_they_land_on():
    curve = curve_of((0, 1.0), (10, 2.0), (20, 3.0))
    assert [(k.frame, k.value) for k in curve.moved({0}, 10).keys] == [(10, 1.0), (20, 3.0)]
    assert [(k.frame, k.value) for k in curve.moved({0}, 9.9999).keys] == [
        (9.9999, 1.0),
        (20, 3.0),
    ]


def test_focus_at_infinity_is_zero_dioptres():
    curve = curve_of((0, 2.0), (10, math.inf), interpolation=LINEAR, scale=Scale.RECIPROCAL)
    assert curve.value_at(5) == pytest.approx(4.0, rel=1e-12)
    assert curve.value_at(9.999) > 1e4
    assert curve.value_at(10) == curve.value_at(11) == math.inf
    still = curve_of((0, math.inf), (10, math.inf), scale=Scale.RECIPROCAL)
    assert still.value_at(5) == math.inf


def test_a_handle_that_points_beyond_infinity_stops_there():
    fast = Ease(50.0, -1.0)
    curve = Curve((Key(0, 2.0, BEZIER, fast), Key(10, 4.0, ease_in=Ease())), Scale.RECIPROCAL)
    assert max(over(curve)) == math.inf
    assert min(over(curve)) > 0


@given(VALUES, EASES)
def test_on_another_scale_a_key_is_passed_as_fast(value, ease):
    dioptres = Curve((Key(0, value, BEZIER, ease, ease),), Scale.RECIPROCAL)
    (key,) = dioptres.on_scale(Scale.LINEAR).keys
    # d(1/v) = -dv / v^2
    speed = pytest.approx(-ease.speed_per_frame * value**2)
    assert (key.ease_in.speed_per_frame, key.ease_out.speed_per_frame) == (speed, speed)
    assert replace(key, ease_out=ease, ease_in=ease) == dioptres.keys[0]


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
def test_a_value_without_a_place_on_its_scale_is_refused(scale, value):
    with pytest.raises(InputError, match="cannot have the value"):
        Curve((Key(0, value),), scale)


@pytest.mark.parametrize("frames", [(1, 0), (0, 0), (0, 1e-5)])
def test_keys_follow_each_other(frames):
    with pytest.raises(InputError, match="must follow each other"):
        curve_of(*((frame, 1.0) for frame in frames))


@pytest.mark.parametrize("frame", [math.nan, math.inf, 1e9])
def test_a_frame_is_a_number_of_nine_digits(frame):
    with pytest.raises(InputError, match="nine digits"):
        Key(frame, 1.0)


@pytest.mark.parametrize("ease", [(-1.0, 0.0), (101.0, 0.0), (math.nan, 0.0), (50.0, math.inf)])
def test_impossible_handles_are_refused(ease):
    with pytest.raises(InputError):
        Ease(*ease)


@pytest.mark.parametrize("factor", [0.0, -1.0, math.inf, math.nan])
def test_keys_are_multiplied_by_positive_numbers_only(factor):
    with pytest.raises(InputError, match="multiplied by a number above 0"):
        curve_of((0, 1.0)).multiplied(factor)


def test_curves_are_values_that_can_be_kept_in_a_set():
    assert len({curve_of((0, 1.0)), curve_of((0, 1.0)), curve_of((0, 2.0))}) == 2


def test_a_curve_without_keys_has_no_value():
    with pytest.raises(ValueError, match="without keys"):
        Curve().value_at(0)


@given(st.floats(0, 1), st.floats(0, 100), st.sampled_from(list(Scale)))
def test_a_bezier_between_equal_keys_stands_still_to_the_last_digit(part, influence, scale):
    """A squeeze of exactly 1 must not become less than any lens has."""
    ease = Ease(influence)
    first = Key(0, 1.1, Interpolation.BEZIER, ease, ease)
    curve = Curve((first, Key(7, 1.1, Interpolation.BEZIER, ease, ease)), scale)
    assert curve.value_at(7 * part) == 1.1
