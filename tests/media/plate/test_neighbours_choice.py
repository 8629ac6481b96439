"""Test the choice of the neighboring frames that are read."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.plate.neighbours.trust import (
    choose_frame_step,
    choose_frames,
    is_static_between,
)
from heatlens.media.plate.plate import ReadPixels
from support.cards import POST, Card, view_of_cards

FRAMES = range(1001, 1101)


@given(
    st.sets(st.integers(1, 200), min_size=1),
    st.integers(1, 4),
    st.integers(1, 12),
    st.integers(1, 200),
)
def test_choose_frames_returns_existing_frames_without_the_frame_itself(
    available, count, step, frame
):
    neighbors = choose_frames(frame, available, count, step)
    assert set(neighbors) <= available - {frame}
    assert len(neighbors) <= 2 * count and neighbors == tuple(sorted(neighbors))


@pytest.mark.parametrize("step", [1, 3, 5])
def test_choose_frames_changes_by_one_from_frame_to_frame(step):
    """The frame that enters replaces the one that is left out because it is shown itself."""
    for frame in range(1020, 1080):
        current_set, next_set = (
            set(choose_frames(it, FRAMES, 2, step)) for it in (frame, frame + 1)
        )
        assert len((next_set - {frame}) - (current_set - {frame + 1})) <= 1


def test_choose_frames_skips_gaps_and_missing_frames():
    odd = set(range(1001, 1101, 2)) - {1049}
    assert len(choose_frames(1051, odd, 2, 2)) == 4
    assert choose_frames(1001, range(1001, 1101), 2) == (1002, 1003, 1004, 1005)
    assert choose_frames(1, [1], 2) == ()


def cameras(metres_a_frame: float) -> dict:
    return {k: view_of_cards(metres_a_frame * k).world_to_camera for k in range(100)}


def test_choose_frame_step_is_wider_for_slower_camera():
    plate = view_of_cards(0.0, (Card(2.0, (-9.0, 0.0)),)).plate
    steps = [
        choose_frame_step(cameras(speed), plate, 80.0, 2) for speed in (0.2, 0.02, 0.01, 0.0001)
    ]
    assert steps[0] == 1 < steps[1] < steps[2] < steps[3] == 24
    assert steps[1] == choose_frame_step(cameras(-0.02), plate, 80.0, 2)
    assert (
        choose_frame_step({}, plate, 80.0, 2)
        == choose_frame_step(cameras(0.0), plate, 80.0, 2)
        == 8
    )


def test_standing_recognizes_static_camera_although_somebody_walks():
    a, b = (
        view_of_cards(0.0, (POST, Card(4.0, (x, x + 1.0), light=0.2))).plate for x in (-1.5, 0.3)
    )
    assert is_static_between(a, b) and is_static_between(b, a)


@pytest.mark.parametrize("metres", [0.15, -0.5])
def test_standing_is_false_for_camera_moving_along_wall(metres):
    assert not is_static_between(view_of_cards(0.0).plate, view_of_cards(metres).plate)


def test_standing_ignores_grain():
    plate, rng = textured_plate(), np.random.default_rng(1)
    grain = rng.normal(1, 0.05, plate.depth_m.shape)[..., None]
    noisy = np.concatenate([plate.color[..., :3] * grain, plate.color[..., 3:]], -1)
    pixels = ReadPixels(noisy.astype(np.float32), plate.depth_m)
    assert is_static_between(plate, replace(plate, pixels=pixels))


def textured_plate():
    """Return a plate with a pattern on its wall."""
    plate, rng = view_of_cards(0.0).plate, np.random.default_rng(2)
    pattern = rng.uniform(0.5, 1.5, plate.depth_m.shape)[..., None]
    color = np.concatenate([plate.color[..., :3] * pattern, plate.color[..., 3:]], -1)
    return replace(plate, pixels=ReadPixels(color.astype(np.float32), plate.depth_m))
