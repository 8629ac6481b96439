"""Test shapes of focus pulls (linear, late snap, overshoot), reversed pulls and held focus."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import (
    PullShape,
    apply_recorded_parameter,
    hold_focus,
    reverse_focus,
    shaped_pull,
)
from heatlens.core.model.shot.shot import Shot

SHOT = Shot(Lens(50.0, 2.0, 3.0, 36.0))
FOCUS = LensParameter.FOCUS_DISTANCE
DISTANCES = st.floats(0.5, 50.0)


def dioptres(shot: Shot, frame: float) -> float:
    return 1.0 / shot.lens_at(frame).focus_distance_m


@given(DISTANCES, DISTANCES, st.integers(4, 200), st.sampled_from(PullShape))
def test_shaped_pull_starts_at_origin_and_ends_at_target(origin, target, frames, shape):
    shot = shaped_pull(SHOT, origin, target, 10, frames, shape)
    assert shot.lens_at(10).focus_distance_m == pytest.approx(origin)
    assert shot.lens_at(10 + frames).focus_distance_m == pytest.approx(target)


def test_linear_pull_is_half_way_at_middle_and_snap_starts_late():
    linear = shaped_pull(
        SHOT,
        from_distance_m=1.0,
        to_distance_m=4.0,
        start_frame=0,
        frames=20,
        shape=PullShape.LINEAR,
    )
    assert dioptres(linear, 10) == pytest.approx((1.0 + 0.25) / 2)
    assert dioptres(linear, 5) == pytest.approx(1.0 - 0.75 / 4)
    snap = shaped_pull(
        SHOT, from_distance_m=1.0, to_distance_m=4.0, start_frame=0, frames=20, shape=PullShape.SNAP
    )
    assert dioptres(snap, 13) == pytest.approx(1.0) and dioptres(snap, 17) < 0.99


@given(DISTANCES, DISTANCES, st.integers(8, 60))
def test_overshoot_pull_passes_target_by_8_percent(origin, target, frames):
    shot = shaped_pull(SHOT, origin, target, 0, frames, PullShape.OVERSHOOT)
    change_dioptres = 1.0 / target - 1.0 / origin
    reached_dioptres = [
        (dioptres(shot, frame) - 1.0 / origin) * math.copysign(1, change_dioptres)
        for frame in range(frames)
    ]
    most = max(abs(1.0 / target - 1.0 / origin) * 1.08, 0.0)
    assert max(reached_dioptres) <= most + 1e-6
    if abs(change_dioptres) > 1e-3 and 1.0 / target + 0.08 * change_dioptres > 1e-3:
        assert max(reached_dioptres) == pytest.approx(most, rel=1e-3)


@given(
    DISTANCES, DISTANCES, st.integers(2, 60), st.sampled_from([PullShape.EASE, PullShape.LINEAR])
)
def test_reverse_focus_mirrors_pull_and_twice_restores_it(origin, target, frames, shape):
    shot = shaped_pull(SHOT, origin, target, 0, frames, shape)
    span = FrameRange(0, frames)
    mirrored = reverse_focus(shot, span)
    for frame in range(frames + 1):
        assert dioptres(mirrored, frame) == pytest.approx(dioptres(shot, frames - frame), rel=1e-5)
    reversed_twice = reverse_focus(mirrored, span)
    assert [key.value for key in reversed_twice.curves.focus_distance_m.keys] == pytest.approx(
        [key.value for key in shot.curves.focus_distance_m.keys]
    )


def test_reverse_focus_needs_two_keys_and_hold_focus_is_constant():
    with pytest.raises(InputError, match="two keys"):
        reverse_focus(SHOT.with_key(1, FOCUS), FrameRange(1, 9))
    shot = shaped_pull(
        SHOT,
        from_distance_m=1.0,
        to_distance_m=4.0,
        start_frame=0,
        frames=20,
        shape=PullShape.LINEAR,
    )
    held_shot = hold_focus(shot, 5)
    assert dioptres(held_shot, 5) == dioptres(held_shot, 19) == pytest.approx(dioptres(shot, 5))
    assert dioptres(held_shot, 20) == pytest.approx(0.25)


@pytest.mark.parametrize("target", [50.0, math.inf])
def test_overshoot_past_infinity_is_clamped_to_infinity(target):
    shot = shaped_pull(
        SHOT,
        from_distance_m=1.0,
        to_distance_m=target,
        start_frame=0,
        frames=20,
        shape=PullShape.OVERSHOOT,
    )
    assert shot.lens_at(15).focus_distance_m == math.inf
    assert dioptres(shot, 20) == pytest.approx(1.0 / target)


@pytest.mark.parametrize(
    ("parameter", "share", "least", "most"),
    [(LensParameter.F_STOP, 0.01, 1.4, 16.0), (LensParameter.FOCAL_LENGTH, 0.002, 24.0, 70.0)],
)
@given(data=st.data())
def test_recorded_values_are_met_within_tolerance_and_keep_outer_keys(
    parameter, share, least, most, data
):
    values = data.draw(st.lists(st.floats(least, most), min_size=2, max_size=12))
    before = SHOT
    for frame in (5.0, 12.0, 90.0):  # a key before, one among, and one after what is recorded
        before = before.with_key(frame, parameter, least)
    track = {10 + 3 * i: value for i, value in enumerate(values)}
    after = apply_recorded_parameter(before, parameter, track)
    for frame, value in track.items():
        assert getattr(after.lens_at(frame), parameter) == pytest.approx(value, rel=share)
    frames = {key.frame for key in after.curves.of(parameter).keys}
    assert {5.0, 90.0} <= frames and frames - {5.0, 90.0} <= set(map(float, track))
