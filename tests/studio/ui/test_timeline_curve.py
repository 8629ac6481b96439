"""The focus curve: keys dragged in both directions, handles bent, tracks of marks behind it."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from imgui_bundle import imgui

from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.focus_track import FocusTrack
from heatlens.core.model.shot.lens_parameter import LensParameter
from support.gui import Gui
from support.sequences import FIRST, LAST, relative_distance
from support.session_files import BALL, BALL_M
from support.timeline_window import reset_window, ruler_position

K = imgui.Key
FOCUS = LensParameter.FOCUS_DISTANCE
FOCUS_M_BY_FRAME = {1002: 1.5, 1004: 3.0, 1007: 2.0}


@pytest.fixture
def gui(ctx, film) -> Gui:
    gui = reset_window(film)
    shot = gui.session.facts.shot
    for number, distance_m in FOCUS_M_BY_FRAME.items():
        shot = shot.with_key(number, FOCUS, distance_m)
    gui.session.editing.begin(shot)
    gui.key(K.c, shift=True)
    gui.frame(4)
    return gui


def focus_keys(gui) -> dict[float, float]:
    return {key.frame: key.value for key in gui.session.facts.shot.curves.focus_distance_m.keys}


def key_position(gui, number: int) -> tuple[float, float]:
    x, y, _, _ = gui.rect(f"key {FOCUS} {number}")
    return x, y


def pixels_per_dioptre(gui) -> float:
    """Return the screen units of a dioptre, from the positions of two keys."""
    return (key_position(gui, 1002)[1] - key_position(gui, 1004)[1]) / (1 / 1.5 - 1 / 3.0)


def test_focus_curve_height_is_linear_in_dioptres_with_far_up(gui):
    heights = {number: key_position(gui, number)[1] for number in FOCUS_M_BY_FRAME}
    assert heights[1004] < heights[1007] < heights[1002]
    fraction = (heights[1007] - heights[1004]) / (heights[1002] - heights[1004])
    assert fraction == pytest.approx((1 / 2 - 1 / 3) / (1 / 1.5 - 1 / 3))


def test_curve_key_drag_changes_frame_and_distance_in_one_undo_step(gui):
    x, y = key_position(gui, 1007)
    rise = 20.0
    dioptres = 1 / 2.0 - rise / pixels_per_dioptre(gui)
    gui.drag((x, y), (ruler_position(gui, 1006)[0], y - rise))
    assert focus_keys(gui) == {1002: 1.5, 1004: 3.0, 1006: pytest.approx(1 / dioptres)}
    assert gui.undo_count() == 1


def test_curve_key_dragged_sideways_keeps_its_distance(gui):
    x, y = key_position(gui, 1007)
    gui.drag((x, y), (ruler_position(gui, LAST)[0], y + 2))
    assert focus_keys(gui) == {1002: 1.5, 1004: 3.0, 1008: 2.0}


def test_curve_key_dragged_beyond_the_top_is_at_infinity(gui):
    x, y = key_position(gui, 1004)
    gui.drag((x, y), (x, y - 900))
    assert focus_keys(gui)[1004] == math.inf and gui.undo_count() == 1


def test_curve_key_within_the_focal_length_is_refused_and_reported(gui):
    gui.session.editing.begin(
        replace(
            gui.session.facts.shot, lens=replace(gui.session.facts.shot.lens, focal_length_mm=900.0)
        )
    )
    gui.frame(2)
    x, y = key_position(gui, 1002)
    gui.drag((x, y), (x, y + 900))
    assert focus_keys(gui)[1002] >= 0.9 and "focal length" in gui.session.messages.text


def test_handle_drag_bends_the_curve_in_one_undo_step(gui):
    gui.click(key_position(gui, 1004))
    gui.do("Interpolate bezier after key")
    gui.frame(30)
    before = gui.session.facts.shot
    position, rise = gui.middle("handle out 1004"), 15.0
    unit = pixels_per_dioptre(gui)
    frames = (position[0] - key_position(gui, 1004)[0]) / (
        ruler_position(gui, 1002)[0] - ruler_position(gui, 1001)[0]
    )
    gui.drag(position, (position[0], position[1] - rise))
    key = gui.session.facts.shot.curves.focus_distance_m.key_at(1004)
    assert key.ease_out.handle(3.0) == (
        pytest.approx(frames, rel=0.02),
        pytest.approx(-rise / unit, abs=1.0 / unit),  # a pixel,
    )
    assert gui.undo_count() == 2  # the Bezier, and the handle
    assert (
        gui.session.facts.shot.lens_at(1005).focus_distance_m
        > before.lens_at(1005).focus_distance_m
    )
    gui.key(K.z, ctrl=True)
    assert gui.session.facts.shot == before


def test_dragged_handle_shows_its_ease_clear_of_the_pointer(gui):
    gui.do("Select all keys")
    gui.do("Interpolate bezier after key")
    x, y = gui.middle("handle out 1004")
    gui.press((x, y))
    gui.move((x + 10, y + 4))
    gui.frame(2)
    x0, y0, _, y1 = gui.rect("value beside the handle")
    assert x0 > x + 10 and (y1 < y + 4 or y0 > y + 20)  # above, or below at the upper edge
    gui.release()
    gui.drawn.clear()
    gui.frame(2)
    assert "value beside the handle" not in gui.drawn


def test_handle_cannot_be_dragged_past_its_key_in_time(gui):
    gui.do("Select all keys")
    gui.do("Interpolate bezier after key")
    gui.frame(30)
    x, y = gui.middle("handle in 1004")
    gui.drag((x, y), (ruler_position(gui, LAST)[0], y))
    key = gui.session.facts.shot.curves.focus_distance_m.key_at(1004)
    assert key.ease_in.influence_percent == 0.0
    assert key.interpolation is Interpolation.BEZIER


def test_focus_track_samples_are_the_sharp_range_at_each_frame(gui):
    samples = FocusTrack().samples(gui.session.facts.shot, FIRST, LAST, 20)
    assert {number for number in FOCUS_M_BY_FRAME} <= {sample.frame for sample in samples}
    for sample in samples:
        lens = gui.session.facts.shot.lens_at(sample.frame)
        assert 1 / sample.focus == pytest.approx(lens.focus_distance_m)
        assert 1 / sample.near == pytest.approx(near_limit_m(lens))
        assert 1 / max(sample.far, 1e-12) == pytest.approx(far_limit_m(lens))


def test_mark_track_has_a_distance_for_each_frame_in_memory(gui):
    gui.session.editing.edit(replace(gui.session.facts.shot, marks=(PointMark("A", *BALL),)))
    gui.frame(2)
    (track,) = gui.session.time.mark_tracks()
    (line,) = track.lines
    assert [number for number, _ in line] == list(range(FIRST, LAST + 1))
    for number, dioptres in line:
        assert 1 / dioptres == pytest.approx(BALL_M * relative_distance(number), rel=1e-5)
    assert gui.session.time.mark_tracks()[0] is track  # kept while nothing is new


def test_focus_curve_without_keys_can_be_clicked_without_a_change(gui):
    gui.do("Select all keys")
    gui.key(K.delete)
    gui.frame(2)
    assert not gui.session.facts.shot.key_frames
    gui.click(gui.middle("keys"))
    assert gui.undo_count() == 1


def test_too_close_frames_lists_frames_within_the_close_focus(gui):
    track, shot = FocusTrack(), gui.session.facts.shot
    lens = replace(shot.lens, close_focus_m=1.8)
    warned_frames = track.too_close_frames(
        replace(shot, lens=lens), gui.session.time.timeline.frames
    )
    expected = [n for n in range(FIRST, LAST + 1) if shot.lens_at(n).focus_distance_m < 1.8]
    assert list(warned_frames) == expected and expected


def test_name_of_the_farthest_track_is_not_cut_off_at_the_top(gui):
    """The farthest line begins at the upper edge, so its name has to stand below it."""
    gui.session.editing.begin(gui.session.facts.shot)
    gui.session.time.marks.set_point(BALL)
    gui.until(lambda: bool(gui.session.time.mark_tracks()), "the line of the mark")
    gui.ui.timeline.toggle_fit()
    gui.frame(2)
    top = gui.rect("timeline ruler")[3]
    assert gui.rect("name A on the curve")[1] >= top


def test_names_of_marks_at_one_distance_stand_side_by_side(gui):
    for _ in range(3):
        gui.session.time.marks.set_here()
    gui.frame(3)
    rects = [gui.rect(f"name {name} on the curve") for name in "CBA"]
    for left, right in pairwise(rects):
        assert left[2] < right[0] and left[1] == right[1]
    assert rects[-1][2] < gui.rect("keys")[2] - imgui.get_font_size()  # room for a grip


def height(gui) -> float:
    _, y0, _, y1 = gui.rect("keys")
    return y1 - y0


def test_timeline_grows_for_the_curve_and_shrinks_without_it(gui):
    em, curve = imgui.get_font_size(), height(gui)
    picture = gui.rect("picture")
    assert curve >= 220 / 13 * em - em
    gui.key(K.c, shift=True)
    gui.frame(4)
    assert height(gui) < 0.7 * curve
    assert gui.rect("picture")[3] > picture[3] + 0.3 * curve
    gui.key(K.c, shift=True)
    gui.frame(4)
    assert height(gui) == pytest.approx(curve, abs=1.0)
    assert gui.rect("picture") == pytest.approx(picture, abs=1.0)


def test_f_key_over_the_curve_toggles_fitting_keys_or_also_marks(gui):
    near_and_far = DistanceMark("near", 0.5), DistanceMark("far", 80.0)
    gui.session.editing.edit(replace(gui.session.facts.shot, marks=near_and_far))
    gui.move(gui.middle("keys"))
    gui.drawn.clear()
    gui.frame(2)
    units_per_dioptre = pixels_per_dioptre(gui)
    assert (1 / 1.5 - 1 / 3.0) * units_per_dioptre > 0.4 * height(gui)
    assert "name near on the curve" not in gui.drawn
    zoom = gui.session.facts.view.zoom
    gui.key(K.f)
    gui.frame(2)
    assert {"name near on the curve", "name far on the curve"} <= gui.drawn.keys()
    assert pixels_per_dioptre(gui) < units_per_dioptre / 2
    gui.key(K.f)
    gui.frame(2)
    assert pixels_per_dioptre(gui) == pytest.approx(units_per_dioptre)
    assert gui.session.facts.view.zoom == zoom


def test_f_key_over_the_picture_fits_the_picture(gui):
    gui.do("1:1")
    gui.move(gui.middle("picture"))
    gui.key(K.f)
    assert gui.session.facts.view.zoom is None and not gui.ui.timeline.fits_marks


def test_alt_wheel_over_the_curve_zooms_its_values_at_the_pointer(gui):
    position = key_position(gui, 1004)
    before = pixels_per_dioptre(gui)
    scale = gui.ui.timeline.scale
    gui.move(position)
    gui.io.add_key_event(K.mod_alt, True)
    gui.hold(K.left_alt)
    gui.later()
    gui.later()
    assert not gui.session.pictures.view.is_lens_held_off
    gui.wheel(position, -2)  # so that both keys stay in sight
    gui.io.add_key_event(K.mod_alt, False)
    gui.hold(K.left_alt, down=False)
    assert pixels_per_dioptre(gui) == pytest.approx(before / 1.25**2, rel=0.01)
    assert key_position(gui, 1004) == pytest.approx(position, abs=1.0)
    assert gui.ui.timeline.scale is scale  # the frames stay as they are
    gui.key(K.f)
    gui.key(K.f)
    gui.frame(2)
    assert pixels_per_dioptre(gui) == pytest.approx(before)


def test_value_is_shown_above_the_dragged_key(gui):
    x, y = key_position(gui, 1004)
    gui.move(gui.middle("picture"))
    gui.drawn.clear()
    gui.frame(2)
    assert "value beside the key" not in gui.drawn
    gui.press((x, y))
    gui.move((x, y + 12))
    gui.frame(2)
    x0, y0, _, y1 = gui.rect("value beside the key")
    assert x0 - x < 20 and y1 <= y + 12 - 8 and y0 > y + 12 - 50  # clear of the pointer
    gui.release()


def test_key_dragged_with_shift_goes_onto_the_line_of_a_mark_that_is_near(gui):
    shot = gui.session.facts.shot
    gui.session.editing.begin(replace(shot, marks=(DistanceMark("A", 2.2),)))
    gui.frame(3)
    x, y = key_position(gui, 1004)
    rise = pixels_per_dioptre(gui) * (1 / 2.2 - 1 / 3.0)  # down to the mark
    gui.press((x, y))
    gui.hold(K.mod_shift)
    gui.move((x, y + rise + 6))
    assert focus_keys(gui)[1004] == pytest.approx(2.2, rel=1e-6)
    gui.move((x, y + rise + 60))
    assert focus_keys(gui)[1004] < 2.0  # farther away than it reaches
    gui.hold(K.mod_shift, down=False)
    gui.move((x, y + rise + 6))
    gui.release()
    assert focus_keys(gui)[1004] != pytest.approx(2.2, rel=1e-4) and gui.undo_count() == 1


def test_handle_without_influence_can_be_dragged_beside_its_key(gui):
    gui.do("Select all keys")
    gui.do("Interpolate bezier after key")
    key = gui.session.facts.shot.curves.focus_distance_m.key_at(1004)
    key_without_ease = replace(key, ease_out=replace(key.ease_out, influence_percent=0.0))
    curve = gui.session.facts.shot.curves.focus_distance_m.with_key(key_without_ease)
    gui.session.editing.edit(gui.session.facts.shot.with_curve(FOCUS, curve))
    gui.frame(30)
    (x, y), (key_x, key_y) = gui.middle("handle out 1004"), key_position(gui, 1004)
    assert math.hypot(x - key_x, y - key_y) > imgui.get_font_size()
    gui.drag((x, y), (x + 20, y - 9))
    dragged_key = gui.session.facts.shot.curves.focus_distance_m.key_at(1004)
    assert dragged_key.ease_out.influence_percent > 0 and dragged_key.value == key.value
