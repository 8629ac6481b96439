"""Bars, sliders and fields: a drag is one undo step; wrong typed text is refused and reported."""

import math
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.lens.lens import THIRD_STOPS
from heatlens.core.model.units import FOOT_M
from support.session_files import LENS

K = imgui.Key


def focus_m(gui) -> float:
    return gui.session.facts.lens.focus_distance_m


def type_into(gui, name: str, text: str) -> None:
    gui.later()  # or two clicks would be a double click
    gui.click(gui.middle(name))
    gui.type(text)
    gui.key(K.enter)
    gui.frame(2)


def test_focus_bar_drag_is_linear_in_dioptres_and_one_undo_step(gui):
    x0, y0, x1, y1 = gui.rect("focus bar")
    y = (y0 + y1) / 2
    gui.drag((x1 - 3, y), (x0 + 0.25 * (x1 - x0), y))
    assert focus_m(gui) == pytest.approx(
        1 / (0.75 * gui.session.facts.histogram.most_dioptres), rel=0.02
    )
    assert gui.undo_count() == 1
    gui.drag((x0 + 20, y), (x1 + 200, y))
    assert focus_m(gui) == math.inf and gui.undo_count() == 2


@pytest.mark.parametrize(
    ("name", "field"),
    [
        ("f-stop", "f_stop"),
        ("focal length", "focal_length_mm"),
        ("squeeze", "squeeze"),
        ("sensor width", "sensor_width_mm"),
        ("sharp up to", "acceptable_coc_mm"),
    ],
)
def test_lens_slider_drag_is_one_undo_step(gui, name, field):
    gui.ui.panels = {panel: panel == "Lens" for panel in gui.ui.panels}  # it has all the room
    gui.frame(3)
    gui.unfolded("Film back, squeeze, sharpness", "sharp up to")
    before = gui.session.facts.shot
    x, y = gui.middle(name)
    gui.drag((x - 20, y), (x + 35, y), steps=6)
    after = gui.session.facts.shot
    assert getattr(after.lens, field) != getattr(before.lens, field)
    assert gui.undo_count() == 1
    assert (
        replace(after, lens=replace(after.lens, **{field: getattr(before.lens, field)})) == before
    )
    gui.key(K.z, ctrl=True)
    assert gui.session.facts.shot == before
    gui.key(K.z, ctrl=True, shift=True)
    assert gui.session.facts.shot == after


def test_drag_with_pauses_is_one_undo_step(gui, monkeypatch):
    clock_s = 1000.0
    monkeypatch.setattr(gui.session.editing, "clock", lambda: clock_s)
    x0, y0, *_ = gui.rect("focus bar")
    gui.press((x0 + 50, y0 + 5))
    for x in (x0 + 80, x0 + 120):
        clock_s += 5.0
        gui.frame(3)
        gui.move((x, y0 + 5))
    gui.release()
    clock_s += 0.1
    gui.wheel((x0 + 50, y0 + 5), 1)  # so soon after, it belongs to it
    clock_s += 5.0
    gui.frame(2)
    assert len(gui.session.editing.history.past) == 1
    for _ in range(2):
        gui.key(K.right_bracket, shift=True)
        clock_s += 5.0
        gui.frame(2)
    assert len(gui.session.editing.history.past) == 3


def test_exposure_drag_is_no_undo_step(gui):
    imgui.set_window_focus("Display")
    gui.frame(2)
    x, y = gui.middle("exposure")
    gui.drag((x, y), (x + 40, y))
    assert gui.session.facts.view.exposure_stops > 0
    assert gui.undo_count() == 0


def test_f_stop_slider_snaps_to_third_stops(gui):
    x0, y0, x1, y1 = gui.rect("f-stop")
    for fraction in (0.2, 0.5, 0.8):
        gui.later()
        gui.click((x0 + fraction * (x1 - x0), (y0 + y1) / 2))
        assert gui.session.facts.lens.f_stop in THIRD_STOPS


@pytest.mark.parametrize(
    ("text", "distance_m"),
    [("6'3\"", 1.905), ("2.24", 2.24), ("190cm", 1.9), ("inf", math.inf), (" 10 ft ", 10 * FOOT_M)],
)
def test_distance_field_takes_any_unit(gui, text, distance_m):
    type_into(gui, "distance", text)
    assert focus_m(gui) == pytest.approx(distance_m, rel=1e-12)
    assert gui.undo_count() == 1


@pytest.mark.parametrize("text", ["two metres", "-3", "", "6'3''5"])
def test_distance_field_refuses_other_text_with_a_message(gui, text):
    type_into(gui, "distance", "3.5")
    type_into(gui, "distance", text or " ")
    assert focus_m(gui) == 3.5
    assert "is not a distance" in gui.session.messages.text


def test_distance_field_refuses_a_focus_within_the_focal_length(gui):
    type_into(gui, "distance", "5cm")
    assert focus_m(gui) == LENS.focus_distance_m
    assert "beyond the focal length of 85 mm" in gui.session.messages.text


@pytest.mark.parametrize(
    ("name", "text", "field", "value"),
    [
        ("f-stop field", "f/1.7", "f_stop", 1.7),
        ("f-stop field", "3,3", "f_stop", 3.3),
        ("T-stop", "T2.2", "t_stop", 2.2),
    ],
)
def test_stop_fields_take_numbers_and_refuse_other_text(gui, name, text, field, value):
    type_into(gui, name, text)
    assert getattr(gui.session.facts.lens, field) == value
    type_into(gui, name, "wide open")
    assert getattr(gui.session.facts.lens, field) == value
    assert "is not a number" in gui.session.messages.text


def test_emptied_t_stop_field_clears_the_t_stop(gui):
    type_into(gui, "T-stop", "2.8")
    type_into(gui, "T-stop", " ")
    assert gui.session.facts.lens.t_stop is None


def test_field_left_unchanged_keeps_the_exact_value(gui):
    gui.session.editing.edit_lens(replace(LENS, focus_distance_m=1.23456789))
    gui.rest()
    before = gui.session.facts.shot
    gui.click(gui.middle("distance"))
    gui.key(K.enter)
    gui.click(gui.middle("T-stop"))
    gui.key(K.escape)
    assert gui.session.facts.shot == before


def test_keys_typed_in_a_field_run_no_shortcuts(gui):
    type_into(gui, "distance", "3.5")
    gui.rest()
    before, view = gui.session.facts.shot, gui.session.facts.view
    gui.later()
    gui.click(gui.middle("distance"))
    gui.type("9")
    for key in (K.d, K.w, K.z, K.left_bracket, K.q):
        gui.key(key)
    for key in (K.a, K.c, K.v, K.z):
        gui.key(key, ctrl=True)
    assert (gui.session.facts.shot, gui.session.facts.view, gui.session.messages.text) == (
        before,
        view,
        "",
    )
    gui.key(K.escape)


# Numbers that are dragged, typed


def ctrl_click_and_type(gui, name: str, text: str) -> None:
    """Ctrl+click on a number field and type."""
    gui.later()
    gui.io.add_key_event(K.mod_ctrl, True)
    gui.click(gui.middle(name))
    gui.io.add_key_event(K.mod_ctrl, False)
    gui.frame(3)
    gui.key(K.a, ctrl=True)
    gui.type(text)
    gui.key(K.enter)
    gui.frame(3)


@pytest.mark.parametrize("text", ["40,5", "40.5", "40.5mm", "40.5 mm"])
def test_focal_length_field_takes_decimal_comma_or_point(gui, text):
    ctrl_click_and_type(gui, "focal length", text)
    assert gui.session.facts.lens.focal_length_mm == 40.5
    assert gui.undo_count() == 1


@pytest.mark.parametrize("text", ["-5", "xyz", "0", "1e9"])
def test_impossible_focal_length_is_reported_and_the_value_stays(gui, text):
    before = gui.session.facts.lens.focal_length_mm
    ctrl_click_and_type(gui, "focal length", text)
    assert gui.session.facts.lens.focal_length_mm == before
    assert "focal length" in gui.session.messages.text and gui.session.messages.is_problem
    x, y = gui.middle("focal length")  # it can be dragged again
    gui.drag((x, y), (x + 60, y))
    assert gui.session.facts.lens.focal_length_mm > before
