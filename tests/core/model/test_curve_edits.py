"""Edits of a curve's keys do what they say, and nothing further away."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Scale
from support.curves import BEZIER, EASES, HOLD, LINEAR, SMOOTH, VALUES, curve_of, curves


@given(curves(), st.integers(-5000, 5000), st.integers(800, 1300))
def test_moving_all_keys_moves_the_curve(curve, by_frames, frame):
    frames = {key.frame for key in curve.keys}
    assert curve.moved(frames, by_frames).value_at(frame + by_frames) == curve.value_at(frame)


@given(curves(), st.integers(-5000, 5000))
def test_keys_move_there_and_back(curve, by_frames):
    frames = {key.frame for key in curve.keys}
    there = curve.moved(frames, by_frames)
    assert there.moved({key.frame for key in there.keys}, -by_frames) == curve


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


@given(VALUES, EASES)
def test_on_another_scale_a_key_is_passed_as_fast(value, ease):
    dioptres = Curve((Key(0, value, BEZIER, ease, ease),), Scale.RECIPROCAL)
    (key,) = dioptres.on_scale(Scale.LINEAR).keys
    # d(1/v) = -dv / v^2
    speed = pytest.approx(-ease.speed_per_frame * value**2)
    assert (key.ease_in.speed_per_frame, key.ease_out.speed_per_frame) == (speed, speed)
    assert replace(key, ease_out=ease, ease_in=ease) == dioptres.keys[0]
