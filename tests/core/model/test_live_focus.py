"""A focus that follows live: what keys are made of, and a function of the lens as it is now."""

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
from heatlens.core.model.shot.pull import baked, pull
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


def at(shot, frame):
    return 1 / shot.lens_at(frame).focus_distance_m


@given(WALKS, st.integers(0, 3), st.integers(-2, 2), st.floats(0, 0.5))
def test_keys_made_of_it_are_within_an_eighth_of_the_sharp_range(walk, ease, late, ignored):
    shot = live_shot(walk, Follow(ignored, late, ease))
    keyed = baked(shot)
    assert keyed.curves.live is None and keyed.marks == MARKS
    for frame in range(10, 10 + len(walk)):
        sharp = sharp_dioptres(LENS)
        assert abs(at(keyed, frame) - at(shot, frame)) <= 2 * 0.1251 * sharp


@given(WALKS)
def test_it_is_where_the_mark_is_seen_and_within_its_distances(walk):
    shot, seen = live_shot(walk), [1 / it for it in walk if it is not None]
    for frame, far_m in enumerate(walk, 10):
        assert min(seen) * 0.999 <= at(shot, frame + 0.5) <= max(seen) * 1.001
        if far_m is not None:
            assert at(shot, frame) == pytest.approx(1 / far_m, rel=1e-9)


@given(WALKS, st.floats(0.1, 5))
def test_it_is_never_faster_than_the_ring(walk, most):
    shot = live_shot(walk, Follow(0, most_dioptres_per_s=most))
    places = [at(shot, frame) for frame in range(10, 10 + len(walk))]
    step = max(abs(b - a) for a, b in pairwise(places))
    assert step <= most / shot.frames_per_second * 1.0001


def test_small_moves_are_ignored_by_the_lens_as_it_is_now():
    walk = [3.0, 3.1, 3.0, 3.1]
    wide_open = live_shot(walk, Follow(0.125))
    stopped_down = live_shot(walk, Follow(0.125), lens=replace(LENS, f_stop=16))
    assert at(wide_open, 10) != at(wide_open, 11)
    assert at(stopped_down, 10) == at(stopped_down, 11)


def test_a_pull_goes_from_one_moving_mark_to_another():
    other = MeasuredMark("B", (8.0, 7.0, 6.0, 5.0, 4.0))
    pursuits = (Pursuit("A"), Pursuit("B", 11, 2))
    shot = live_shot([2.0, 2.2, 2.4, 2.6, 2.8], EXACT, pursuits, (other,))
    expected = [1 / 2, 1 / 2.2, 0.5 / 2.4 + 0.5 / 6, 1 / 5, 1 / 4]
    assert [at(shot, frame) for frame in range(10, 15)] == pytest.approx(expected)
    live = shot.curves.live
    assert live.pulled_to("A", 14, 3).pursuits == (*pursuits, Pursuit("A", 14, 3))
    assert live.pulled_to("A", 12, 3).pursuits == (Pursuit("A"), Pursuit("A", 12, 3))


def test_its_files_hold_all_of_it(tmp_path):
    shot = live_shot([2.0, None, float("inf")], Follow(0.2, -3, 2, 1.5))
    write_shot(tmp_path / "s.heatlens.json", shot)
    assert read_shot(tmp_path / "s.heatlens.json") == shot


@pytest.mark.parametrize(
    ("pursuits", "told"),
    [
        ((), "begins"),
        ((Pursuit("A", 3, 4),), "begins"),
        ((Pursuit("A"), Pursuit("B")), "start frame"),
        ((Pursuit("A"), Pursuit("B", 5, 0)), "frames"),
        ((Pursuit("A"), Pursuit("B", 5, 9), Pursuit("A", 8, 2)), "before"),
    ],
)
def test_an_impossible_order_is_refused(pursuits, told):
    with pytest.raises(InputError, match=told):
        LiveFocus(pursuits)


def test_a_file_needs_the_marks_that_its_focus_follows(tmp_path):
    path = tmp_path / "s.heatlens.json"
    write_shot(path, Shot(LENS, marks=MARKS, curves=LensCurves(live=LiveFocus((Pursuit("Q"),)))))
    with pytest.raises(InputError, match="Q"):
        read_shot(path)


def test_before_it_is_measured_the_lens_has_its_own_focus():
    unmeasured = Shot(LENS, marks=MARKS, curves=LensCurves(live=LiveFocus((Pursuit("A"),))))
    assert unmeasured.lens_at(5) == LENS and baked(unmeasured).lens == LENS


def test_keys_of_the_focus_take_its_place_and_none_is_set_beside_it():
    shot = live_shot([2.0, 3.0])
    with pytest.raises(InputError, match="follows A"):
        shot.with_key(10, LensParameter.FOCUS_DISTANCE, 5.0)
    assert shot.with_key(10, LensParameter.F_STOP, 4).curves.live == shot.curves.live
    assert pull(shot, 2, 4, 10, 5).curves.live is None
