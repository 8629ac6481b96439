"""Actions that are impossible with the open source are gray and say why; speeds are measured."""

import math
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.render.preview.speed import Speed

K = imgui.Key
SCENE_ACTIONS = (
    *("Set camera key", "Frame the object", "Compare with raytraced"),
    *("Camera follows the focal length", "Focal length follows the camera"),
)


@pytest.mark.parametrize("name", SCENE_ACTIONS)
def test_palette_reports_why_a_scene_action_is_barred_for_a_plate(gui, name):
    shot, view = gui.session.facts.shot, gui.session.facts.view
    gui.key(K.p, ctrl=True, shift=True)
    gui.type(name.lower())
    gui.key(K.enter)
    gui.frame(2)
    assert "scene" in gui.session.messages.text
    assert (gui.session.facts.shot, gui.session.facts.view) == (shot, view)


@pytest.mark.parametrize("name", SCENE_ACTIONS)
def test_menu_item_of_a_scene_action_is_disabled_for_a_plate(gui, name):
    action = next(action for action in gui.screen.commands if action.name == name)
    assert "scene" in action.why_not()
    view = gui.session.facts.view
    gui.choose_in_menu(action)
    assert gui.session.facts.view == view and gui.session.messages.text == ""


def menu_items(gui, monkeypatch, menu: str) -> dict[str, bool]:
    """Open a menu with the mouse; return for each item its words and whether it is enabled."""
    enabled_by_words: dict[str, bool] = {}
    menu_item = imgui.menu_item

    def record_item(label, shortcut, is_on, is_enabled):
        enabled_by_words[label.partition("###")[0]] = is_enabled
        return menu_item(label, shortcut, is_on, is_enabled)

    gui.click(gui.middle(f"menu {menu}"))
    monkeypatch.setattr(imgui, "menu_item", record_item)
    gui.frame()
    monkeypatch.undo()
    gui.click(gui.middle(f"menu {menu}"))
    return enabled_by_words


def test_undo_item_names_its_step_and_is_gray_without_one(gui, monkeypatch):
    assert menu_items(gui, monkeypatch, "Edit") == {"Undo": False, "Redo": False}
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=7.0))
    gui.rest()
    assert menu_items(gui, monkeypatch, "Edit") == {"Undo focus": True, "Redo": False}
    gui.key(K.z, ctrl=True)
    assert menu_items(gui, monkeypatch, "Edit") == {"Undo": False, "Redo focus": True}


def test_no_other_actions_are_barred_for_a_plate(gui):
    barred = {action.name for action in gui.screen.commands if action.why_not()}
    nothing_yet = {"Undo", "Redo", "Record a pull"}  # a single frame has nothing to play
    of_reels = {"Next shot", "Previous shot", "Leave the reel", "Grade of the shot"}
    assert barred - nothing_yet - of_reels == {*SCENE_ACTIONS, "Compare with accumulation"}


def test_speed_reports_rates_only_once_measured():
    speed = Speed()
    assert speed.mean_ms() is None and speed.pictures_per_second() is None
    speed.note_frame(0.010, 0.0, is_dragging=True)  # no new picture came with it
    speed.note_frame(0.030, 0.02, is_dragging=False)
    assert speed.mean_ms() == pytest.approx(20.0) and speed.pictures_per_second() is None
    speed.note_frame(0.050, 0.04, is_dragging=True)
    assert speed.pictures_per_second() == pytest.approx(20.0)


@pytest.mark.parametrize("is_software", [True, False])
def test_answer_time_is_limited_only_with_a_window(is_software):
    speed = Speed(is_software=is_software)
    assert speed.answer_s == math.inf
    speed.has_window = True
    assert speed.budget_s < speed.answer_s < 10 * speed.budget_s
