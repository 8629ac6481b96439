"""A focus that follows: near what is seen, over what is hidden, as a hand would."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.focus.live_focus import Follow, bridged
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import followed, pull
from heatlens.core.model.shot.shot import Shot

SHOT = Shot(Lens(focal_length_mm=50, f_stop=1.4, focus_distance_m=3, sensor_width_mm=36))
WALKS = st.lists(st.floats(0.8, 30), min_size=2, max_size=40)


def at(shot, frame):
    return 1 / shot.lens_at(frame).focus_distance_m


def keys(shot):
    return shot.curves.of(LensParameter.FOCUS_DISTANCE).keys


@given(WALKS)
def test_the_focus_is_within_a_quarter_of_the_sharp_range(walk):
    shot = followed(SHOT, dict(enumerate(walk, 10)))
    for frame, distance_m in enumerate(walk, 10):
        range_dioptres = 2 * sharp_dioptres(SHOT.lens)
        assert abs(at(shot, frame) - 1 / distance_m) <= 0.2501 * range_dioptres


@given(st.floats(1, 20), st.floats(-0.12, 0.12), st.integers(2, 60))
def test_small_moves_are_ignored(distance_m, part, count):
    move = part * 2 * sharp_dioptres(SHOT.lens)
    walk = {frame: 1 / (1 / distance_m + move * (frame % 2)) for frame in range(count)}
    assert len({key.value for key in keys(followed(SHOT, walk))}) == 1


def test_a_steady_walk_is_a_few_keys_and_no_faster_than_it_was():
    walk = {frame: 5 - 0.1 * frame for frame in range(31)}
    shot = followed(SHOT, walk)
    assert len(keys(shot)) <= 5
    speeds = [at(shot, frame + 1) - at(shot, frame) for frame in range(30)]
    assert min(speeds) >= 0 and max(speeds) <= 1.3 * (1 / 2 - 1 / 2.1)


@given(st.lists(st.one_of(st.none(), st.floats(0.5, 50)), min_size=1, max_size=30))
def test_a_gap_is_bridged_between_what_is_seen(distances_m):
    seen = [1 / it for it in distances_m if it is not None]
    if not seen:
        with pytest.raises(InputError, match="every frame"):
            followed(SHOT, dict(enumerate(distances_m)))
        return
    track = bridged(distances_m)
    assert min(seen) - 1e-12 <= min(track) and max(track) <= max(seen) + 1e-12
    for place, distance_m in zip(track, distances_m, strict=True):
        assert distance_m is None or place == pytest.approx(1 / distance_m)


def test_a_gap_is_a_straight_line_in_dioptres_and_its_ends_are_held():
    track = bridged([None, 2.0, None, None, 0.5, None])
    assert track == pytest.approx([0.5, 0.5, 1.0, 1.5, 2.0, 2.0])


def test_the_hand_is_late_gentle_and_no_faster_than_the_ring():
    step = {frame: 5.0 if frame < 20 else 2.0 for frame in range(41)}
    exact = {"ignored_part": 0.0}
    assert at(followed(SHOT, step, Follow(**exact)), 20) == pytest.approx(0.5, abs=0.01)
    late = followed(SHOT, step, Follow(late_frames=5, **exact))
    assert [at(late, 24), at(late, 25)] == pytest.approx([0.2, 0.5], abs=0.01)
    early = followed(SHOT, step, Follow(late_frames=-5, **exact))
    assert at(early, 15) == pytest.approx(0.5, abs=0.01)
    eased = followed(SHOT, step, Follow(ease_frames=4, **exact))
    assert 0.25 < at(eased, 18) < at(eased, 19) < at(eased, 20) < 0.45
    slow = followed(SHOT, step, Follow(most_dioptres_per_s=0.24, **exact))  # 0.01 dioptres a frame
    assert at(slow, 30) == pytest.approx(0.2 + 0.01 * 11, abs=0.01)


def test_impossible_hands_are_refused():
    for wrong in ({"ignored_part": -1}, {"ease_frames": -1}, {"most_dioptres_per_s": float("nan")}):
        with pytest.raises(InputError, match="--follow-"):
            Follow(**wrong)


def test_a_pull_in_mid_walk_leaves_one_followed_mark_for_another():
    """Follow A, then B from where the pull arrives, then pull: each is followed on its side."""
    first = {frame: 4.0 - 0.05 * frame for frame in range(1, 31)}
    second = {frame: 2.0 + 0.03 * frame for frame in range(18, 31)}
    shot = followed(followed(SHOT, first), second)
    shot = pull(shot, first[12], second[18], 12, 6)
    for frame in range(1, 31):
        place = at(shot, frame)
        slack = 0.51 * sharp_dioptres(shot.lens_at(frame))
        if frame <= 12:
            assert abs(place - 1 / first[frame]) <= slack, frame
        elif frame >= 18:
            assert abs(place - 1 / second[frame]) <= slack, frame
        else:
            ends = sorted((1 / first[12], 1 / second[18]))
            assert ends[0] - 1e-9 <= place <= ends[1] + 1e-9
