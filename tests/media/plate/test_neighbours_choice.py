"""Which neighbouring frames are read."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.plate.neighbours.trust import chosen_frames, standing, step_of
from heatlens.media.plate.plate import ReadPixels
from support.cards import POST, Card, seen

FRAMES = range(1001, 1101)


@given(
    st.sets(st.integers(1, 200), min_size=1),
    st.integers(1, 4),
    st.integers(1, 12),
    st.integers(1, 200),
)
def test_the_chosen_frames_are_there_and_not_the_frame_itself(available, count, step, frame):
    chosen = chosen_frames(frame, available, count, step)
    assert set(chosen) <= available - {frame}
    assert len(chosen) <= 2 * count and chosen == tuple(sorted(chosen))


@pytest.mark.parametrize("step", [1, 3, 5])
def test_the_set_changes_by_one_from_frame_to_frame(step):
    """The frame that enters counts for the one that is left out because it is shown itself."""
    for frame in range(1020, 1080):
        now, after = (set(chosen_frames(it, FRAMES, 2, step)) for it in (frame, frame + 1))
        assert len((after - {frame}) - (now - {frame + 1})) <= 1


def test_frames_on_twos_and_gaps_serve_as_well():
    odd = set(range(1001, 1101, 2)) - {1049}
    assert len(chosen_frames(1051, odd, 2, 2)) == 4
    assert chosen_frames(1001, range(1001, 1101), 2) == (1002, 1003, 1004, 1005)
    assert chosen_frames(1, [1], 2) == ()


def cameras(metres_a_frame: float) -> dict:
    return {k: seen(metres_a_frame * k).world_to_camera for k in range(100)}


def test_the_slower_the_camera_the_wider_the_step():
    plate = seen(0.0, (Card(2.0, (-9.0, 0.0)),)).plate
    steps = [step_of(cameras(speed), plate, 80.0, 2) for speed in (0.2, 0.02, 0.01, 0.0001)]
    assert steps[0] == 1 < steps[1] < steps[2] < steps[3] == 24
    assert steps[1] == step_of(cameras(-0.02), plate, 80.0, 2)
    assert step_of({}, plate, 80.0, 2) == step_of(cameras(0.0), plate, 80.0, 2) == 8


def test_a_camera_that_stands_is_recognised_although_somebody_walks():
    a, b = (seen(0.0, (POST, Card(4.0, (x, x + 1.0), light=0.2))).plate for x in (-1.5, 0.3))
    assert standing(a, b) and standing(b, a)


@pytest.mark.parametrize("metres", [0.15, -0.5])
def test_a_camera_that_moves_along_a_wall_does_not_stand(metres):
    assert not standing(seen(0.0).plate, seen(metres).plate)


def test_grain_does_not_make_a_camera_move():
    plate, chance = textured(), np.random.default_rng(1)
    grain = chance.normal(1, 0.05, plate.depth_m.shape)[..., None]
    noisy = np.concatenate([plate.color[..., :3] * grain, plate.color[..., 3:]], -1)
    pixels = ReadPixels(noisy.astype(np.float32), plate.depth_m)
    assert standing(plate, replace(plate, pixels=pixels))


def textured():
    """Return a plate with a pattern on its wall."""
    plate, chance = seen(0.0).plate, np.random.default_rng(2)
    pattern = chance.uniform(0.5, 1.5, plate.depth_m.shape)[..., None]
    color = np.concatenate([plate.color[..., :3] * pattern, plate.color[..., 3:]], -1)
    return replace(plate, pixels=ReadPixels(color.astype(np.float32), plate.depth_m))
