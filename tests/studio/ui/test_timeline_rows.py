"""The row that is chosen is the one whose curve is seen: its scale, its labels, its handles."""

import math
from collections.abc import Iterator
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
from support.timeline_window import at_frame, film_window, fresh

K = imgui.Key
FOCUS, F_STOP = LensParameter.FOCUS_DISTANCE, LensParameter.F_STOP
FOCAL, SQUEEZE = LensParameter.FOCAL_LENGTH, LensParameter.SQUEEZE
KEYED = {
    FOCUS: {1003: 2.0},
    F_STOP: {1002: 2.0, 1004: 8.0, 1007: 4.0},
    FOCAL: {1002: 25.0, 1004: 100.0, 1007: 50.0},
    SQUEEZE: {1002: 1.0, 1004: 2.0, 1007: 1.5},
}
SCALED = (F_STOP, FOCAL, SQUEEZE)


@pytest.fixture(scope="module")
def film(session_context, tmp_path_factory) -> Iterator[Gui]:
    with film_window(session_context, tmp_path_factory.mktemp("film")) as gui:
        yield gui


@pytest.fixture
def gui(ctx, film) -> Gui:
    gui = fresh(film)
    shot = gui.session.facts.shot
    for parameter, keys in KEYED.items():
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


def place(gui: Gui, number: int, parameter: LensParameter) -> tuple[float, float]:
    x, y, _, _ = gui.rect(f"key {parameter} {number}")
    return x, y


def values(gui: Gui, parameter: LensParameter) -> dict[float, float]:
    return {key.frame: key.value for key in gui.session.facts.shot.curves.of(parameter).keys}


def steps(gui: Gui) -> int:
    gui.rest()
    return len(gui.session.editing.history.past)


# The scale


@given(st.sampled_from(list(LensParameter)), st.floats(1.0, 2.0), st.floats(1.001, 1.9))
def test_more_is_higher_and_every_place_is_one_value(parameter, value, factor):
    axis = AXES[parameter]
    assert axis.place_of(value * factor) < axis.place_of(value)
    assert axis.value_at(axis.place_of(value)) == pytest.approx(value)


@given(st.floats(0.5, 64.0), st.floats(0.0, 8.0))
def test_a_place_is_a_stop_a_doubling_or_a_dioptre(value, by):
    assert AXES[F_STOP].value_at(AXES[F_STOP].place_of(value) - by) == pytest.approx(
        value * math.sqrt(2.0) ** by
    )
    assert AXES[FOCAL].value_at(AXES[FOCAL].place_of(value) - by) == pytest.approx(value * 2**by)
    assert AXES[FOCUS].place_of(value) == pytest.approx(1 / value)


@given(st.floats(0.01, 3.0))
def test_focus_that_goes_in_metres_is_still_seen_in_dioptres(place):
    axis = AXES[FOCUS]
    assert axis.from_scale(1 / place, Scale.LINEAR) == pytest.approx(place)
    assert axis.to_scale(place, Scale.LINEAR) == pytest.approx(1 / place)
    assert math.isfinite(axis.to_scale(-place, Scale.LINEAR))


def test_labels_are_whole_stops_until_there_is_room_for_thirds():
    axis = AXES[F_STOP]
    assert axis.labels_for(0.1) == THIRD_STOPS
    whole = axis.labels_for(0.5)
    assert {1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0} <= set(whole)
    gaps = [axis.place_of(a) - axis.place_of(b) for a, b in pairwise(whole)]
    assert gaps == pytest.approx([1.0] * len(gaps), abs=0.1)
    assert axis.labels_for(9.0) == whole
    assert [AXES[p].words(v, "ft") for p, v in ((F_STOP, 2.8), (FOCAL, 35))] == ["f/2.8", "35 mm"]
    assert AXES[FOCUS].words(0.3048, "ft").startswith("1")


# The window


@pytest.mark.parametrize("parameter", SCALED)
def test_the_name_of_a_row_chooses_whose_curve_is_seen(gui, parameter):
    choose(gui, parameter)
    heights = {number: place(gui, number, parameter)[1] for number in KEYED[parameter]}
    assert heights[1004] < heights[1007] < heights[1002]
    part = (heights[1007] - heights[1004]) / (heights[1002] - heights[1004])
    assert part == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("parameter", SCALED)
def test_a_key_is_dragged_over_frames_and_values_in_one_step(gui, parameter):
    choose(gui, parameter)
    axis, (x, y) = AXES[parameter], place(gui, 1007, parameter)
    low, high = (place(gui, number, parameter)[1] for number in (1002, 1004))
    ends = [axis.place_of(KEYED[parameter][number]) for number in (1002, 1004)]
    unit = (low - high) / (ends[0] - ends[1])
    gui.drag((x, y), (at_frame(gui, 1006)[0], y - 10.0))
    expected = axis.value_at(axis.place_of(KEYED[parameter][1007]) - 10.0 / unit)
    assert values(gui, parameter)[1006] == pytest.approx(expected, rel=1e-4)
    assert 1007 not in values(gui, parameter) and steps(gui) == 1
    assert values(gui, FOCUS) == KEYED[FOCUS]


def test_a_handle_bends_the_curve_of_the_f_stop(gui):
    choose(gui, F_STOP)
    gui.click(place(gui, 1004, F_STOP))
    gui.do("Interpolate bezier after key")
    gui.frame(30)
    before, focus = (
        gui.session.facts.shot.lens_at(1005).f_stop,
        gui.session.facts.shot.curves.focus_distance_m,
    )
    x, y = gui.middle("handle out 1004")
    gui.drag((x, y), (x, y - 15.0))
    assert gui.session.facts.shot.lens_at(1005).f_stop > before * 1.01
    assert gui.session.facts.shot.curves.focus_distance_m == focus
    assert steps(gui) == 2


def test_what_no_lens_can_be_is_refused_aloud(gui):
    choose(gui, SQUEEZE)
    gui.drag(place(gui, 1004, SQUEEZE), (place(gui, 1004, SQUEEZE)[0], 0.0))
    assert values(gui, SQUEEZE)[1004] <= 2.0 and "squeeze" in gui.session.messages.text


def test_the_list_beside_the_curve_chooses_another(gui):
    choose(gui, F_STOP)
    gui.frame(30)
    gui.click(gui.middle("curve of"))
    gui.click(gui.middle("curve of: focal length"))
    gui.frame(3)
    assert gui.session.time.keys.rows.curve_of is FOCAL
    low, high = (place(gui, number, FOCAL)[1] for number in (1002, 1004))
    assert low - high > 20


def test_the_key_that_was_clicked_last_is_of_the_chosen_row(gui):
    gui.click(place(gui, 1004, FOCAL))
    assert gui.session.time.keys.rows.curve_of is FOCAL


def test_a_parameter_without_keys_is_a_level_line(gui):
    still = gui.session.facts.shot.without_keys(1002, F_STOP)
    gui.session.editing.begin(still)
    choose(gui, F_STOP)
    line, axis = CurveLine(), AXES[F_STOP]
    level = line.points(still, axis, 1001, 1008, 5)
    places = {place for _, place in level}
    assert places == {axis.place_of(still.lens.f_stop)} and len(level) == 5
    assert line.points(still, axis, 1001, 1008, 5) is level  # kept while nothing is new
    keyed = dict(line.points(still, AXES[FOCAL], 1001, 1008, 5))
    for number, value in KEYED[FOCAL].items():
        assert keyed[number] == pytest.approx(AXES[FOCAL].place_of(value))


def test_tilt_and_split_have_rows_where_they_are_used(gui: Gui) -> None:
    """A key of them is set and dragged like any other."""
    assert "row tilt_deg" not in gui.drawn and "row split_dioptres" not in gui.drawn
    editing, at = gui.session.editing, gui.session.facts.frame
    editing.edit_lens(replace(editing.lens, tilt_deg=2.0))
    gui.frame(2)
    gui.click(gui.middle("dot tilt_deg"))
    gui.session.time.timeline.go(LAST)
    editing.edit_lens(replace(editing.lens, tilt_deg=5.0))
    assert values(gui, LensParameter.TILT) == {at: 2.0, LAST: 5.0}
    assert gui.session.facts.shot.lens_at((at + LAST) / 2).tilt_deg == pytest.approx(3.5)
    gui.frame(2)
    assert "row split_dioptres" not in gui.drawn
    choose(gui, LensParameter.TILT)
    x, y = place(gui, LAST, LensParameter.TILT)
    gui.drag((x, y), (x, y + 20))
    assert values(gui, LensParameter.TILT)[LAST] < 5.0
