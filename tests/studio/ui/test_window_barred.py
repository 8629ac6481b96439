"""What cannot be done with what is open is grey, and says why; what was not measured says so."""

import math
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.studio.session.speed import Speed

K = imgui.Key
OF_SCENES = (
    *("Set camera key", "Frame selected", "Compare with raytraced"),
    *("Camera follows the focal length", "Focal length follows the camera"),
)


@pytest.mark.parametrize("name", OF_SCENES)
def test_of_a_plate_the_palette_says_why_not(gui, name):
    shot, view = gui.session.facts.shot, gui.session.facts.view
    gui.key(K.p, ctrl=True, shift=True)
    gui.type(name.lower())
    gui.key(K.enter)
    gui.frame(2)
    assert "scene" in gui.session.messages.text
    assert (gui.session.facts.shot, gui.session.facts.view) == (shot, view)


@pytest.mark.parametrize("name", OF_SCENES)
def test_of_a_plate_its_item_in_the_menu_is_dead(gui, name):
    action = next(action for action in gui.screen.commands if action.name == name)
    assert "scene" in action.why_not()
    view = gui.session.facts.view
    gui.click(gui.middle(f"menu {action.menu}"))
    gui.click(gui.middle(f"item {name}"))
    assert gui.session.facts.view == view and gui.session.messages.text == ""


def items(gui, monkeypatch, menu: str) -> dict[str, bool]:
    """Open a menu by hand; return what its items say, and whether they can be chosen."""
    found: dict[str, bool] = {}
    drawn = imgui.menu_item

    def listened(label, shortcut, is_on, is_enabled):
        found[label.partition("###")[0]] = is_enabled
        return drawn(label, shortcut, is_on, is_enabled)

    gui.click(gui.middle(f"menu {menu}"))
    monkeypatch.setattr(imgui, "menu_item", listened)
    gui.frame()
    monkeypatch.undo()
    gui.click(gui.middle(f"menu {menu}"))
    return found


def test_undo_says_what_it_takes_back_and_is_grey_where_there_is_nothing(gui, monkeypatch):
    assert items(gui, monkeypatch, "Edit") == {"Undo": False, "Redo": False}
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=7.0))
    gui.rest()
    assert items(gui, monkeypatch, "Edit") == {"Undo focus": True, "Redo": False}
    gui.key(K.z, ctrl=True)
    assert items(gui, monkeypatch, "Edit") == {"Undo": False, "Redo focus": True}


def test_nothing_else_is_barred(gui):
    barred = {action.name for action in gui.screen.commands if action.why_not()}
    nothing_yet = {"Undo", "Redo", "Record a pull"}  # a single frame has nothing to play
    of_reels = {"Next shot", "Previous shot", "Grade of the shot"}
    assert barred - nothing_yet - of_reels == {*OF_SCENES, "Compare with accumulation"}


def test_speeds_are_told_once_they_were_measured():
    speed = Speed()
    assert speed.mean_ms() is None and speed.pictures_per_second() is None
    speed.frame(0.010, 0.0, is_held=True)  # no new picture came with it
    speed.frame(0.030, 0.02, is_held=False)
    assert speed.mean_ms() == pytest.approx(20.0) and speed.pictures_per_second() is None
    speed.frame(0.050, 0.04, is_held=True)
    assert speed.pictures_per_second() == pytest.approx(20.0)


@pytest.mark.parametrize("is_software", [True, False])
def test_only_a_window_has_its_answers_cut_into_slices(is_software):
    speed = Speed(is_software=is_software)
    assert speed.answer_s == math.inf
    speed.has_window = True
    assert speed.budget_s < speed.answer_s < 10 * speed.budget_s
