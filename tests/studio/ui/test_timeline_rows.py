"""The curve of the chosen row: its scale, its labels and its handles."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from imgui_bundle import imgui

from heatlens.core.model.curves.interpolation import Scale
from heatlens.core.model.lens.lens import THIRD_STOPS
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.studio.ui.timeline.curve_axis import AXES, CurveLine
from support.gui import Gui
from support.sequences import LAST
from support.timeline_window import reset_window, ruler_position

K = imgui.Key
FOCUS, F_STOP = LensParameter.FOCUS_DISTANCE, LensParameter.F_STOP
FOCAL, SQUEEZE = LensParameter.FOCAL_LENGTH, LensParameter.SQUEEZE
KEY_VALUES = {
    FOCUS: {1003: 2.0},
    F_STOP: {1002: 2.0, 1004: 8.0, 1007: 4.0},
    FOCAL: {1002: 25.0, 1004: 100.0, 1007: 50.0},
    SQUEEZE: {1002: 1.0, 1004: 2.0, 1007: 1.5},
}
SCALED_PARAMETERS = (F_STOP, FOCAL, SQUEEZE)


@pytest.fixture
def gui(ctx, film) -> Gui:
    gui = reset_window(film)
    shot = gui.session.facts.shot
    for parameter, keys in KEY_VALUES.items():
        for number, value in keys.items():
            shot = shot.with_key(number, parameter, value)
    gui.session.editing.begin(shot)
    gui.frame(2)
    return gui


def choose(gui: Gui, parameter: LensParameter) -> None:
    """Select a row by its name, then show its curve."""
    gui.click(gui.middle(f"row {parameter}"))
    gui.key(K.c, shift=True)
    gui.frame(3)


def key_position(gui: Gui, number: int, parameter: LensParameter) -> tuple[float, float]:
    x, y, _, _ = gui.rect(f"key {parameter} {number}")
    return x, y


def values(gui: Gui, parameter: LensParameter) -> dict[float, float]:
    return {key.frame: key.value for key in gui.session.facts.shot.curves.of(parameter).keys}


# The scale


@given(st.sampled_from(list(LensParameter)), st.floats(1.0, 2.0), st.floats(1.001, 1.9))
def test_axis_level_falls_with_the_value_and_is_invertible(parameter, value, factor):
    axis = AXES[parameter]
    assert axis.level_of(value * factor) < axis.level_of(value)
    assert axis.value_at(axis.level_of(value)) == pytest.approx(value)


@given(st.floats(0.5, 64.0), st.floats(0.0, 8.0))
def test_axis_unit_is_a_stop_a_doubling_or_a_dioptre(value, offset):
    assert AXES[F_STOP].value_at(AXES[F_STOP].level_of(value) - offset) == pytest.approx(
        value * math.sqrt(2.0) ** offset
    )
    assert AXES[FOCAL].value_at(AXES[FOCAL].level_of(value) - offset) == pytest.approx(
        value * 2**offset
    )
    assert AXES[FOCUS].level_of(value) == pytest.approx(1 / value)


@given(st.floats(0.01, 3.0))
def test_focus_axis_converts_linear_scale_to_dioptres(position):
    axis = AXES[FOCUS]
    assert axis.from_scale(1 / position, Scale.LINEAR) == pytest.approx(position)
    assert axis.to_scale(position, Scale.LINEAR) == pytest.approx(1 / position)
    assert math.isfinite(axis.to_scale(-position, Scale.LINEAR))


def test_f_stop_labels_are_third_or_whole_stops_by_their_least_distance():
    axis = AXES[F_STOP]  # one level is one stop
    assert axis.labels_for(levels_apart=0.1) == THIRD_STOPS
    whole_stops = axis.labels_for(levels_apart=0.5)
    assert {1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0} <= set(whole_stops)
    gaps = [axis.level_of(a) - axis.level_of(b) for a, b in pairwise(whole_stops)]
    assert gaps == pytest.approx([1.0] * len(gaps), abs=0.1)
    assert axis.labels_for(levels_apart=9.0) == whole_stops  # there is no shorter list


def test_format_value_of_axis_adds_the_unit_of_its_parameter():
    assert [AXES[p].format_value(v, "ft") for p, v in ((F_STOP, 2.8), (FOCAL, 35))] == [
        "f/2.8",
        "35 mm",
    ]
    assert AXES[FOCUS].format_value(0.3048, "ft").startswith("1")


# The window


@pytest.mark.parametrize("parameter", SCALED_PARAMETERS)
def test_click_on_a_row_name_shows_its_curve(gui, parameter):
    choose(gui, parameter)
    heights = {number: key_position(gui, number, parameter)[1] for number in KEY_VALUES[parameter]}
    assert heights[1004] < heights[1007] < heights[1002]
    fraction = (heights[1007] - heights[1004]) / (heights[1002] - heights[1004])
    assert fraction == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("parameter", SCALED_PARAMETERS)
def test_key_drag_changes_frame_and_value_in_one_undo_step(gui, parameter):
    choose(gui, parameter)
    axis, (x, y) = AXES[parameter], key_position(gui, 1007, parameter)
    low, high = (key_position(gui, number, parameter)[1] for number in (1002, 1004))
    ends = [axis.level_of(KEY_VALUES[parameter][number]) for number in (1002, 1004)]
    unit = (low - high) / (ends[0] - ends[1])
    gui.drag((x, y), (ruler_position(gui, 1006)[0], y - 10.0))
    expected = axis.value_at(axis.level_of(KEY_VALUES[parameter][1007]) - 10.0 / unit)
    assert values(gui, parameter)[1006] == pytest.approx(expected, rel=1e-4)
    assert 1007 not in values(gui, parameter) and gui.undo_count() == 1
    assert values(gui, FOCUS) == KEY_VALUES[FOCUS]


def test_handle_drag_bends_the_f_stop_curve_only(gui):
    choose(gui, F_STOP)
    gui.click(key_position(gui, 1004, F_STOP))
    gui.do("Interpolate bezier after key")
    gui.frame(30)
    before = gui.session.facts.shot.lens_at(1005).f_stop
    focus = gui.session.facts.shot.curves.focus_distance_m
    x, y = gui.middle("handle out 1004")
    gui.drag((x, y), (x, y - 15.0))
    assert gui.session.facts.shot.lens_at(1005).f_stop > before * 1.01
    assert gui.session.facts.shot.curves.focus_distance_m == focus
    assert gui.undo_count() == 2


def test_impossible_squeeze_is_refused_and_reported(gui):
    choose(gui, SQUEEZE)
    gui.drag(key_position(gui, 1004, SQUEEZE), (key_position(gui, 1004, SQUEEZE)[0], 0.0))
    assert values(gui, SQUEEZE)[1004] <= 2.0 and "squeeze" in gui.session.messages.text


def test_curve_list_chooses_another_parameter(gui):
    choose(gui, F_STOP)
    gui.frame(30)
    gui.click(gui.middle("curve of"))
    gui.click(gui.middle("curve of: focal length"))
    gui.frame(3)
    assert gui.session.time.keys.rows.curve_parameter is FOCAL
    low, high = (key_position(gui, number, FOCAL)[1] for number in (1002, 1004))
    assert low - high > 20


def test_click_on_a_key_chooses_the_curve_of_its_row(gui):
    gui.click(key_position(gui, 1004, FOCAL))
    assert gui.session.time.keys.rows.curve_parameter is FOCAL


def test_curve_of_a_parameter_without_keys_is_level(gui):
    still = gui.session.facts.shot.without_keys(1002, F_STOP)
    gui.session.editing.begin(still)
    choose(gui, F_STOP)
    line, axis = CurveLine(), AXES[F_STOP]
    level_points = line.points(still, axis, 1001, 1008, 5)
    positions = {y for _, y in level_points}
    assert positions == {axis.level_of(still.lens.f_stop)} and len(level_points) == 5
    assert line.points(still, axis, 1001, 1008, 5) is level_points  # kept while nothing is new
    keyed = dict(line.points(still, AXES[FOCAL], 1001, 1008, 5))
    for number, value in KEY_VALUES[FOCAL].items():
        assert keyed[number] == pytest.approx(AXES[FOCAL].level_of(value))


def test_tilt_row_appears_once_the_tilt_has_a_key(gui: Gui) -> None:
    """Its key is set and dragged like any other."""
    assert "row tilt_deg" not in gui.drawn and "row split_dioptres" not in gui.drawn
    editing, first_frame = gui.session.editing, gui.session.facts.frame
    editing.begin(editing.shot.with_key(first_frame, LensParameter.TILT, 2.0))
    gui.frame(2)
    gui.session.time.timeline.go_to(LAST)
    editing.edit_lens(replace(editing.lens, tilt_deg=5.0))
    assert values(gui, LensParameter.TILT) == {first_frame: 2.0, LAST: 5.0}
    assert gui.session.facts.shot.lens_at((first_frame + LAST) / 2).tilt_deg == pytest.approx(3.5)
    gui.frame(2)
    assert "row split_dioptres" not in gui.drawn
    choose(gui, LensParameter.TILT)
    x, y = key_position(gui, LAST, LensParameter.TILT)
    gui.drag((x, y), (x, y + 20))
    assert values(gui, LensParameter.TILT)[LAST] < 5.0
