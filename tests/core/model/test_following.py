"""Test focus keys that follow a distance: tolerance, hidden gaps, delay, easing and speed limit."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.focus.live_focus import Follow, bridge_gaps
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import focus_on_distances, pull
from heatlens.core.model.shot.shot import Shot

SHOT = Shot(Lens(focal_length_mm=50, f_stop=1.4, focus_distance_m=3, sensor_width_mm=36))
WALKS = st.lists(st.floats(0.8, 30), min_size=2, max_size=40)


def focus_dioptres(shot, frame):
    return 1 / shot.lens_at(frame).focus_distance_m


def focus_keys(shot):
    return shot.curves.of(LensParameter.FOCUS_DISTANCE).keys


@given(WALKS)
def test_followed_focus_stays_within_quarter_of_sharp_range(walk):
    shot = focus_on_distances(SHOT, dict(enumerate(walk, 10)))
    for frame, distance_m in enumerate(walk, 10):
        range_dioptres = 2 * sharp_dioptres(SHOT.lens)
        assert abs(focus_dioptres(shot, frame) - 1 / distance_m) <= 0.2501 * range_dioptres


@given(st.floats(1, 20), st.floats(-0.12, 0.12), st.integers(2, 60))
def test_focus_on_distances_ignores_moves_below_sharp_range(distance_m, part, count):
    move = part * 2 * sharp_dioptres(SHOT.lens)
    walk = {frame: 1 / (1 / distance_m + move * (frame % 2)) for frame in range(count)}
    assert len({key.value for key in focus_keys(focus_on_distances(SHOT, walk))}) == 1


def test_focus_on_steady_walk_has_few_keys_and_keeps_speed():
    walk = {frame: 5 - 0.1 * frame for frame in range(31)}
    shot = focus_on_distances(SHOT, walk)
    assert len(focus_keys(shot)) <= 5
    speeds = [focus_dioptres(shot, frame + 1) - focus_dioptres(shot, frame) for frame in range(30)]
    assert min(speeds) >= 0 and max(speeds) <= 1.3 * (1 / 2 - 1 / 2.1)


@given(st.lists(st.one_of(st.none(), st.floats(0.5, 50)), min_size=1, max_size=30))
def test_bridge_gaps_stays_within_range_of_seen_distances(distances_m):
    seen_dioptres = [1 / it for it in distances_m if it is not None]
    if not seen_dioptres:
        with pytest.raises(InputError, match="every frame"):
            focus_on_distances(SHOT, dict(enumerate(distances_m)))
        return
    track = bridge_gaps(distances_m)
    assert min(seen_dioptres) - 1e-12 <= min(track) and max(track) <= max(seen_dioptres) + 1e-12
    for dioptres, distance_m in zip(track, distances_m, strict=True):
        assert distance_m is None or dioptres == pytest.approx(1 / distance_m)


def test_bridge_gaps_interpolates_dioptres_and_keeps_end_values():
    distances_m = [None, 4.0, None, None, 1.0, None]
    dioptres = bridge_gaps(distances_m)
    assert dioptres == pytest.approx([0.25, 0.25, 0.5, 0.75, 1.0, 1.0])


def test_follow_options_delay_ease_and_limit_speed():
    step = {frame: 5.0 if frame < 20 else 2.0 for frame in range(41)}
    exact = {"ignored_part": 0.0}
    assert focus_dioptres(focus_on_distances(SHOT, step, Follow(**exact)), 20) == pytest.approx(
        0.5, abs=0.01
    )
    late = focus_on_distances(SHOT, step, Follow(late_frames=5, **exact))
    assert [focus_dioptres(late, 24), focus_dioptres(late, 25)] == pytest.approx(
        [0.2, 0.5], abs=0.01
    )
    early = focus_on_distances(SHOT, step, Follow(late_frames=-5, **exact))
    assert focus_dioptres(early, 15) == pytest.approx(0.5, abs=0.01)
    eased = focus_on_distances(SHOT, step, Follow(ease_frames=4, **exact))
    assert (
        0.25
        < focus_dioptres(eased, 18)
        < focus_dioptres(eased, 19)
        < focus_dioptres(eased, 20)
        < 0.45
    )
    slow = focus_on_distances(
        SHOT, step, Follow(most_dioptres_per_s=0.24, **exact)
    )  # 0.01 dioptres a frame
    assert focus_dioptres(slow, 30) == pytest.approx(0.2 + 0.01 * 11, abs=0.01)


def test_follow_rejects_impossible_options():
    for wrong in ({"ignored_part": -1}, {"ease_frames": -1}, {"most_dioptres_per_s": float("nan")}):
        with pytest.raises(InputError, match="--follow-"):
            Follow(**wrong)


def test_pull_between_two_followed_tracks_keeps_each_on_its_side():
    """Follow A, then B from the end of the pull, then pull: each side follows its own mark."""
    first = {frame: 4.0 - 0.05 * frame for frame in range(1, 31)}
    second = {frame: 2.0 + 0.03 * frame for frame in range(18, 31)}
    shot = focus_on_distances(focus_on_distances(SHOT, first), second)
    shot = pull(shot, first[12], second[18], 12, 6)
    for frame in range(1, 31):
        dioptres = focus_dioptres(shot, frame)
        slack = 0.51 * sharp_dioptres(shot.lens_at(frame))
        if frame <= 12:
            assert abs(dioptres - 1 / first[frame]) <= slack, frame
        elif frame >= 18:
            assert abs(dioptres - 1 / second[frame]) <= slack, frame
        else:
            ends = sorted((1 / first[12], 1 / second[18]))
            assert ends[0] - 1e-9 <= dioptres <= ends[1] + 1e-9
