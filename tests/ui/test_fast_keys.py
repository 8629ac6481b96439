"""Keys that come faster than frames: each one counts, with the modifiers that were held with it."""

import glfw
import pytest
from imgui_bundle import imgui

from heatlens.ui.actions import pressed
from heatlens.ui.fast_keys import FastKeys, events_wait

_GLFW = {
    imgui.Key.left_shift: glfw.KEY_LEFT_SHIFT,
    imgui.Key.slash: glfw.KEY_SLASH,
    imgui.Key.s: glfw.KEY_S,
    imgui.Key.left_ctrl: glfw.KEY_LEFT_CONTROL,
}
_MODS = {imgui.Key.left_shift: imgui.Key.mod_shift, imgui.Key.left_ctrl: imgui.Key.mod_ctrl}


def typed(keys: FastKeys, key: imgui.Key, is_down: bool) -> None:
    """An event as ImGui's own callback takes it in behind ours: the modifier first."""
    keys.before(_GLFW[key], glfw.PRESS if is_down else glfw.RELEASE)
    if key in _MODS:
        imgui.get_io().add_key_event(_MODS[key], is_down)
    imgui.get_io().add_key_event(key, is_down)


@pytest.mark.parametrize("count", [1, 2, 10])
def test_question_marks_between_two_frames(gui, count):
    """Shift is let go of before the key, as people and xdotool do."""
    seen, last, keys = 0, gui.ui.shows_keys, FastKeys()
    typed(keys, imgui.Key.left_shift, True)
    gui.frame()
    for _ in range(count):
        for key, is_down in (
            (imgui.Key.slash, True),
            (imgui.Key.left_shift, False),
            (imgui.Key.slash, False),
            (imgui.Key.left_shift, True),
        ):
            typed(keys, key, is_down)
    while events_wait():
        gui.frame()
        seen, last = seen + (gui.ui.shows_keys != last), gui.ui.shows_keys
    typed(keys, imgui.Key.left_shift, False)
    assert seen == count
    gui.ui.shows_keys = False
    gui.frame(2)


def test_a_modifier_that_comes_behind_a_key_is_not_held_with_it(gui):
    """S, then Ctrl, before the next frame: no Ctrl+S."""
    keys, name = FastKeys(), next(a.name for a in gui.screen.actions if a.shortcut == "Ctrl+S")
    for key, is_down in (
        (imgui.Key.s, True),
        (imgui.Key.left_ctrl, True),
        (imgui.Key.s, False),
        (imgui.Key.left_ctrl, False),
    ):
        typed(keys, key, is_down)
    done = []
    while events_wait():
        gui.frame()
        done += [a.name for a in pressed(gui.screen.actions)]
    assert name not in done and not gui.ui.dialogs.browser.is_open
