"""Test the live focus, a function of measured marks and the current lens that can become keys."""

from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.focus.live_focus import Follow, LiveFocus, MeasuredMark, Pursuit
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import bake_live_focus, pull
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.media.documents.shot_file import read_shot, write_shot

LENS = Lens(focal_length_mm=50, f_stop=1.4, focus_distance_m=3, sensor_width_mm=36)
MARKS = (DistanceMark("A", 2.0), DistanceMark("B", 4.0))
WALKS = st.lists(st.none() | st.floats(0.8, 30), min_size=2, max_size=30).filter(any)
EXACT, ONE = Follow(ignored_part=0), (Pursuit("A"),)


def live_shot(walk, follow=EXACT, pursuits=ONE, others=(), lens=LENS):
    measured = (MeasuredMark("A", tuple(walk)), *others)
    live = LiveFocus(tuple(pursuits), follow, 10, measured, "0")
    return Shot(lens, marks=MARKS, curves=LensCurves(live=live))


def focus_dioptres(shot, frame):
    return 1 / shot.lens_at(frame).focus_distance_m


@given(WALKS, st.integers(0, 3), st.integers(-2, 2), st.floats(0, 0.5))
def test_baked_keys_stay_within_quarter_of_sharp_range_of_live_focus(walk, ease, late, ignored):
    shot = live_shot(walk, Follow(ignored_part=ignored, late_frames=late, ease_frames=ease))
    keyed = bake_live_focus(shot)
    assert keyed.curves.live is None and keyed.marks == MARKS
    for frame in range(10, 10 + len(walk)):
        sharp = sharp_dioptres(LENS)
        assert abs(focus_dioptres(keyed, frame) - focus_dioptres(shot, frame)) <= 2 * 0.1251 * sharp


@given(WALKS)
def test_live_focus_equals_measured_distance_where_mark_is_seen(walk):
    shot, seen_dioptres = live_shot(walk), [1 / it for it in walk if it is not None]
    for frame, distance_m in enumerate(walk, 10):
        assert (
            min(seen_dioptres) * 0.999
            <= focus_dioptres(shot, frame + 0.5)
            <= max(seen_dioptres) * 1.001
        )
        if distance_m is not None:
            assert focus_dioptres(shot, frame) == pytest.approx(1 / distance_m, rel=1e-9)
        assert shot.focus_distance_at(frame) == shot.lens_at(frame).focus_distance_m


@given(WALKS, st.floats(0.1, 5))
def test_live_focus_never_exceeds_speed_limit(walk, most_dioptres_per_s):
    shot = live_shot(walk, Follow(0, most_dioptres_per_s=most_dioptres_per_s))
    track_dioptres = [focus_dioptres(shot, frame) for frame in range(10, 10 + len(walk))]
    step = max(abs(b - a) for a, b in pairwise(track_dioptres))
    assert step <= most_dioptres_per_s / shot.frames_per_second * 1.0001


def test_live_focus_ignores_moves_by_sharp_range_of_current_lens():
    walk = [3.0, 3.1, 3.0, 3.1]
    wide_open = live_shot(walk, Follow(0.125))
    stopped_down = live_shot(walk, Follow(0.125), lens=replace(LENS, f_stop=16))
    assert focus_dioptres(wide_open, 10) != focus_dioptres(wide_open, 11)
    assert focus_dioptres(stopped_down, 10) == focus_dioptres(stopped_down, 11)


def test_live_focus_pulls_between_two_moving_marks():
    second_mark = MeasuredMark("B", (8.0, 7.0, 6.0, 5.0, 4.0))
    pursuits = (Pursuit("A"), Pursuit(mark="B", start_frame=11, frames=2))
    shot = live_shot([2.0, 2.2, 2.4, 2.6, 2.8], EXACT, pursuits, (second_mark,))
    expected = [1 / 2, 1 / 2.2, 0.5 / 2.4 + 0.5 / 6, 1 / 5, 1 / 4]
    assert [focus_dioptres(shot, frame) for frame in range(10, 15)] == pytest.approx(expected)
    live = shot.curves.live
    assert live.add_pull("A", 14, 3).pursuits == (*pursuits, Pursuit("A", 14, 3))
    assert live.add_pull("A", 12, 3).pursuits == (Pursuit("A"), Pursuit("A", 12, 3))


def test_live_focus_survives_shot_file(tmp_path):
    shot = live_shot([2.0, None, float("inf")], Follow(0.2, -3, 2, 1.5))
    write_shot(tmp_path / "s.heatlens.json", shot)
    assert read_shot(tmp_path / "s.heatlens.json") == shot


@pytest.mark.parametrize(
    ("pursuits", "message"),
    [
        ((), "at least one mark"),
        ((Pursuit(mark="A", start_frame=3, frames=4),), "first without a start frame"),
        ((Pursuit("A"), Pursuit("B")), "start frame"),
        ((Pursuit("A"), Pursuit(mark="B", start_frame=5, frames=0)), "1 frame or more"),
        (
            (
                Pursuit("A"),
                Pursuit(mark="B", start_frame=5, frames=9),
                Pursuit(mark="A", start_frame=8, frames=2),
            ),
            "before",
        ),
    ],
)
def test_live_focus_rejects_impossible_pursuits(pursuits, message):
    with pytest.raises(InputError, match=message):
        LiveFocus(pursuits)


def test_read_shot_rejects_live_focus_on_missing_mark(tmp_path):
    path = tmp_path / "s.heatlens.json"
    write_shot(path, Shot(LENS, marks=MARKS, curves=LensCurves(live=LiveFocus((Pursuit("Q"),)))))
    with pytest.raises(InputError, match="Q"):
        read_shot(path)


def test_unmeasured_live_focus_leaves_lens_unchanged():
    unmeasured = Shot(LENS, marks=MARKS, curves=LensCurves(live=LiveFocus((Pursuit("A"),))))
    assert unmeasured.lens_at(5) == LENS and bake_live_focus(unmeasured).lens == LENS


def test_focus_key_is_refused_during_live_focus_and_pull_replaces_it():
    shot = live_shot([2.0, 3.0])
    with pytest.raises(InputError, match="follows A"):
        shot.with_key(10, LensParameter.FOCUS_DISTANCE, 5.0)
    assert shot.with_key(10, LensParameter.F_STOP, 4).curves.live == shot.curves.live
    assert pull(shot, 2, 4, 10, 5).curves.live is None


def test_live_focus_at_distance_of_lens_wins_over_keys():
    live = live_shot([LENS.focus_distance_m] * 3)
    keyed = pull(Shot(LENS), 5, 9, 10, 2)
    both = replace(
        live, curves=replace(live.curves, focus_distance_m=keyed.curves.focus_distance_m)
    )
    for frame in (10, 11, 12):
        assert both.lens_at(frame).focus_distance_m == both.focus_distance_at(frame)
