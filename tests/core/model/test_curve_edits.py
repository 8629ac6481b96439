"""Test edits of curve keys, and that they change nothing far away from the key."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Scale
from support.curves import BEZIER, EASES, HOLD, LINEAR, SMOOTH, VALUES, curve_of, curves


@given(curves(), st.integers(-5000, 5000), st.integers(800, 1300))
def test_moving_all_keys_shifts_curve_in_time(curve, by_frames, frame):
    frames = {key.frame for key in curve.keys}
    assert curve.move_keys(frames, by_frames).value_at(frame + by_frames) == curve.value_at(frame)


@given(curves(), st.integers(-5000, 5000))
def test_moving_keys_forth_and_back_restores_curve(curve, by_frames):
    frames = {key.frame for key in curve.keys}
    shifted_curve = curve.move_keys(frames, by_frames)
    assert shifted_curve.move_keys({key.frame for key in shifted_curve.keys}, -by_frames) == curve


@given(curves(), st.integers(900, 1200), VALUES)
def test_with_value_replaces_key_at_same_frame(curve, frame, value):
    frames = {key.frame for key in curve.keys} | {frame}
    changed = curve.with_value(frame, value)
    assert [key.frame for key in changed.keys] == sorted(frames)
    assert changed.value_at(frame) == value
    assert changed.without_keys({frame}).keys == curve.without_keys({frame}).keys


def test_with_value_changes_at_most_two_segments_on_each_side():
    curve = curve_of(*((10 * i, float(i * i % 7)) for i in range(8)))
    changed = curve.with_value(30, 9.0)
    untouched = [*range(11), *range(50, 71)]
    assert all(changed.value_at(f) == curve.value_at(f) for f in untouched)
    assert changed.value_at(15) != curve.value_at(15)


def test_new_key_takes_interpolation_of_key_before_it():
    curve = Curve(
        (
            Key(frame=0, value=1.0, interpolation=LINEAR),
            Key(frame=10, value=3.0, interpolation=HOLD),
            Key(20, 5.0),
        )
    )
    assert curve.with_value(5, 2.5).key_at(5) == Key(frame=5, value=2.5, interpolation=LINEAR)
    assert curve.with_value(15, 2.5).key_at(15) == Key(frame=15, value=2.5, interpolation=HOLD)
    assert curve.with_value(-5, 2.5).key_at(-5) == Key(frame=-5, value=2.5, interpolation=SMOOTH)


def test_with_value_keeps_handles_of_existing_key():
    key = Key(frame=5, value=1.0, interpolation=BEZIER, ease_out=Ease(80.0), ease_in=Ease(10.0))
    assert Curve((key,)).with_value(5, 2.0).keys == (replace(key, value=2.0),)


def test_rippled_shifts_later_keys_and_drops_cut_ones():
    curve = curve_of((0, 1.0), (10, 2.0), (20, 3.0), (30, 4.0))
    assert [k.frame for k in curve.ripple_keys(20, 5).keys] == [0, 10, 25, 35]
    shorter = curve.ripple_keys(20, -12)
    assert [(k.frame, k.value) for k in shorter.keys] == [(0, 1.0), (8, 3.0), (18, 4.0)]


def test_pasted_puts_copied_keys_at_new_frame():
    curve = curve_of((0, 1.0), (10, 2.0), (20, 3.0), (30, 4.0))
    pasted = curve.paste_keys(curve_of((0, 2.0), (10, 3.0)).keys, 30)
    assert [(k.frame, k.value) for k in pasted.keys][2:] == [(20, 3.0), (30, 2.0), (40, 3.0)]


def test_moved_key_replaces_key_at_target_frame():
    curve = curve_of((0, 1.0), (10, 2.0), (20, 3.0))
    assert [(k.frame, k.value) for k in curve.move_keys({0}, 10).keys] == [(10, 1.0), (20, 3.0)]
    assert [(k.frame, k.value) for k in curve.move_keys({0}, 9.9999).keys] == [
        (9.9999, 1.0),
        (20, 3.0),
    ]


@given(VALUES, EASES)
def test_convert_scale_keeps_speed_at_each_key(value, ease):
    dioptres = Curve((Key(0, value, BEZIER, ease, ease),), Scale.RECIPROCAL)
    (key,) = dioptres.convert_scale(Scale.LINEAR).keys
    # d(1/v) = -dv / v^2
    speed = pytest.approx(-ease.speed_per_frame * value**2)
    assert (key.ease_in.speed_per_frame, key.ease_out.speed_per_frame) == (speed, speed)
    assert replace(key, ease_out=ease, ease_in=ease) == dioptres.keys[0]
