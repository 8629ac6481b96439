"""The focus as a curve: keys dragged in both directions, handles bent, marked things behind it."""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import pytest
from imgui_bundle import imgui

from heatlens.model.coc import far_limit_m, near_limit_m
from heatlens.model.interpolation import Interpolation
from heatlens.model.marks import PointMark
from heatlens.model.shot import LensParameter
from heatlens.session.time.focus_track import FocusTrack
from support.gui import Gui
from support.sequences import FIRST, LAST, nearer
from support.session_files import BALL, BALL_M
from support.timeline_window import at_frame, film_window, fresh

K = imgui.Key
FOCUS = LensParameter.FOCUS_DISTANCE
KEYED = {1002: 1.5, 1004: 3.0, 1007: 2.0}


@pytest.fixture(scope="module")
def film(session_context, tmp_path_factory) -> Iterator[Gui]:
    with film_window(session_context, tmp_path_factory.mktemp("film")) as gui:
        yield gui


@pytest.fixture
def gui(ctx, film) -> Gui:
    gui = fresh(film)
    shot = gui.session.facts.shot
    for number, distance_m in KEYED.items():
        shot = shot.with_key(number, FOCUS, distance_m)
    gui.session.editing.begin(shot)
    gui.key(K.c, shift=True)
    gui.frame(2)
    return gui


def focus_keys(gui) -> dict[float, float]:
    return {key.frame: key.value for key in gui.session.facts.shot.curves.focus_distance_m.keys}


def place(gui, number: int) -> tuple[float, float]:
    x, y, _, _ = gui.rect(f"key {FOCUS} {number}")
    return x, y


def steps(gui) -> int:
    gui.rest()
    return len(gui.session.editing.history.past)


def per_dioptre(gui) -> float:
    """Return screen units, from two keys."""
    return (place(gui, 1002)[1] - place(gui, 1004)[1]) / (1 / 1.5 - 1 / 3.0)


def test_far_is_up_and_heights_are_dioptres(gui):
    heights = {number: place(gui, number)[1] for number in KEYED}
    assert heights[1004] < heights[1007] < heights[1002]
    part = (heights[1007] - heights[1004]) / (heights[1002] - heights[1004])
    assert part == pytest.approx((1 / 2 - 1 / 3) / (1 / 1.5 - 1 / 3))


def test_a_key_is_dragged_over_frames_and_distances_in_one_step(gui):
    x, y = place(gui, 1007)
    rise = 20.0
    dioptres = 1 / 2.0 - rise / per_dioptre(gui)
    gui.drag((x, y), (at_frame(gui, 1006)[0], y - rise))
    assert focus_keys(gui) == {1002: 1.5, 1004: 3.0, 1006: pytest.approx(1 / dioptres)}
    assert steps(gui) == 1


def test_a_key_dragged_sideways_keeps_its_distance(gui):
    x, y = place(gui, 1007)
    gui.drag((x, y), (at_frame(gui, LAST)[0], y + 2))
    assert focus_keys(gui) == {1002: 1.5, 1004: 3.0, 1008: 2.0}


def test_a_key_dragged_beyond_the_top_is_at_infinity(gui):
    x, y = place(gui, 1004)
    gui.drag((x, y), (x, y - 900))
    assert focus_keys(gui)[1004] == math.inf and steps(gui) == 1


def test_nearer_than_the_lens_can_be_focused_is_refused_aloud(gui):
    gui.session.editing.begin(
        replace(
            gui.session.facts.shot, lens=replace(gui.session.facts.shot.lens, focal_length_mm=900.0)
        )
    )
    gui.frame(2)
    x, y = place(gui, 1002)
    gui.drag((x, y), (x, y + 900))
    assert focus_keys(gui)[1002] >= 0.9 and "focal length" in gui.session.messages.text


def test_a_handle_is_dragged_as_one_step_and_bends_the_curve(gui):
    gui.click(place(gui, 1004))
    gui.do("Interpolate bezier after key")
    gui.frame(30)
    before = gui.session.facts.shot
    at, rise = gui.middle("handle out 1004"), 15.0
    unit = per_dioptre(gui)
    frames = (at[0] - place(gui, 1004)[0]) / (at_frame(gui, 1002)[0] - at_frame(gui, 1001)[0])
    gui.drag(at, (at[0], at[1] - rise))
    key = gui.session.facts.shot.curves.focus_distance_m.key_at(1004)
    assert key.ease_out.handle(3.0) == (
        pytest.approx(frames, rel=0.02),
        pytest.approx(-rise / unit, abs=1.0 / unit),  # a pixel,
    )
    assert steps(gui) == 2  # the Bezier, and the handle
    assert (
        gui.session.facts.shot.lens_at(1005).focus_distance_m
        > before.lens_at(1005).focus_distance_m
    )
    gui.key(K.z, ctrl=True)
    assert gui.session.facts.shot == before


def test_a_handle_never_runs_back_in_time(gui):
    gui.do("Select all keys")
    gui.do("Interpolate bezier after key")
    gui.frame(30)
    x, y = gui.middle("handle in 1004")
    gui.drag((x, y), (at_frame(gui, LAST)[0], y))
    key = gui.session.facts.shot.curves.focus_distance_m.key_at(1004)
    assert key.ease_in.influence_percent == 0.0
    assert key.interpolation is Interpolation.BEZIER


def test_the_band_is_what_is_sharp_at_each_time(gui):
    samples = FocusTrack().samples(gui.session.facts.shot, FIRST, LAST, 20)
    assert {number for number in KEYED} <= {sample.frame for sample in samples}
    for sample in samples:
        lens = gui.session.facts.shot.lens_at(sample.frame)
        assert 1 / sample.focus == pytest.approx(lens.focus_distance_m)
        assert 1 / sample.near == pytest.approx(near_limit_m(lens))
        assert 1 / max(sample.far, 1e-12) == pytest.approx(far_limit_m(lens))


def test_a_marked_thing_is_followed_over_the_frames_in_memory(gui):
    gui.session.editing.edit(replace(gui.session.facts.shot, marks=(PointMark("A", *BALL),)))
    gui.frame(2)
    (track,) = gui.session.time.mark_tracks()
    (line,) = track.lines
    assert [number for number, _ in line] == list(range(FIRST, LAST + 1))
    for number, dioptres in line:
        assert 1 / dioptres == pytest.approx(BALL_M * nearer(number), rel=1e-5)
    assert gui.session.time.mark_tracks()[0] is track  # kept while nothing is new


def test_a_still_focus_is_a_line_without_keys(gui):
    gui.do("Select all keys")
    gui.key(K.delete)
    gui.frame(2)
    assert not gui.session.facts.shot.key_frames
    gui.click(gui.middle("keys"))
    assert steps(gui) == 1


def test_frames_too_near_for_the_lens_are_warned_of(gui):
    track, shot = FocusTrack(), gui.session.facts.shot
    lens = replace(shot.lens, close_focus_m=1.8)
    seen = track.too_close(replace(shot, lens=lens), gui.session.time.timeline.frames)
    expected = [n for n in range(FIRST, LAST + 1) if shot.lens_at(n).focus_distance_m < 1.8]
    assert list(seen) == expected and expected


def test_the_names_of_lines_are_not_cut_off_at_the_top(gui):
    """The farthest one begins at the upper edge, where there is no room above it."""
    gui.session.editing.begin(gui.session.facts.shot)
    gui.session.time.marks.set_point(BALL)
    gui.until(lambda: bool(gui.session.time.mark_tracks()), "the line of the mark")
    gui.frame(2)
    top = gui.rect("timeline ruler")[3]
    assert gui.rect("name A on the curve")[1] >= top


def test_names_of_marks_at_one_distance_stand_beside_each_other(gui):
    for _ in range(3):
        gui.session.time.marks.set_here()
    gui.frame(3)
    rects = [gui.rect(f"name {name} on the curve") for name in "ABC"]
    for left, right in pairwise(rects):
        assert left[2] < right[0] and left[1] == right[1]
    assert rects[0][0] > gui.rect("timeline ruler")[0] + imgui.get_font_size()  # room for a grip
