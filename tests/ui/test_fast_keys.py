"""Keys that come faster than frames: each one counts, with the modifiers that were held with it."""

import glfw
import pytest
from imgui_bundle import imgui

from heatlens.ui.actions import pressed
from heatlens.ui.fast_keys import FastKeys, events_wait, imgui_key

_GLFW = {
    imgui.Key.left_shift: glfw.KEY_LEFT_SHIFT,
    imgui.Key.slash: glfw.KEY_SLASH,
    imgui.Key.s: glfw.KEY_S,
    imgui.Key.left_ctrl: glfw.KEY_LEFT_CONTROL,
}
_MODS = {imgui.Key.left_shift: imgui.Key.mod_shift, imgui.Key.left_ctrl: imgui.Key.mod_ctrl}
_BITS = {imgui.Key.left_shift: glfw.MOD_SHIFT, imgui.Key.left_ctrl: glfw.MOD_CONTROL}


class Hand:
    """Sends the events of keys as GLFW does, with the modifiers that are held."""

    def __init__(self) -> None:
        self.keys, self.mods = FastKeys(), 0

    def typed(self, key: imgui.Key, is_down: bool) -> None:
        typed(self.keys, key, is_down, self.mods)
        bit = _BITS.get(key, 0)
        self.mods = self.mods | bit if is_down else self.mods & ~bit


def typed(keys: FastKeys, key: imgui.Key, is_down: bool, mods: int = 0) -> None:
    """Send an event as ImGui's own callback handles it after ours: the modifier first."""
    keys.before(_GLFW[key], glfw.PRESS if is_down else glfw.RELEASE, mods)
    if key in _MODS:
        imgui.get_io().add_key_event(_MODS[key], is_down)
    imgui.get_io().add_key_event(key, is_down)


@pytest.mark.parametrize("count", [1, 2, 10])
def test_question_marks_between_two_frames(gui, count):
    """Shift is let go of before the key, as people and xdotool do."""
    seen, last, hand = 0, gui.ui.shows_keys, Hand()
    hand.typed(imgui.Key.left_shift, True)
    gui.frame()
    for _ in range(count):
        for key, is_down in (
            (imgui.Key.slash, True),
            (imgui.Key.left_shift, False),
            (imgui.Key.slash, False),
            (imgui.Key.left_shift, True),
        ):
            hand.typed(key, is_down)
    while events_wait():
        gui.frame()
        seen, last = seen + (gui.ui.shows_keys != last), gui.ui.shows_keys
    hand.typed(imgui.Key.left_shift, False)
    assert seen == count
    gui.ui.shows_keys = False
    gui.frame(2)


def test_a_modifier_that_comes_behind_a_key_is_not_held_with_it(gui):
    """S, then Ctrl, before the next frame: no Ctrl+S."""
    hand, name = Hand(), next(a.name for a in gui.screen.actions if a.shortcut == "Ctrl+S")
    for key, is_down in (
        (imgui.Key.s, True),
        (imgui.Key.left_ctrl, True),
        (imgui.Key.s, False),
        (imgui.Key.left_ctrl, False),
    ):
        hand.typed(key, is_down)
    done = []
    while events_wait():
        gui.frame()
        done += [a.name for a in pressed(gui.screen.actions)]
    assert name not in done and not gui.ui.dialogs.browser.is_open


def test_a_key_has_the_modifiers_of_its_own_event_where_glfw_left_out_their_press(gui):
    """GLFW then says that Ctrl is not held, which ImGui's callback takes in before the key."""
    keys, name = FastKeys(), next(a.name for a in gui.screen.actions if a.shortcut == "Ctrl+S")
    done = []
    for _ in range(3):
        keys.before(glfw.KEY_S, glfw.PRESS, glfw.MOD_CONTROL)
        gui.io.add_key_event(imgui.Key.mod_ctrl, False)
        gui.io.add_key_event(imgui.Key.s, True)
        keys.before(glfw.KEY_S, glfw.RELEASE, glfw.MOD_CONTROL)
        gui.io.add_key_event(imgui.Key.s, False)
    while events_wait():
        imgui.backends.opengl3_new_frame()
        imgui.new_frame()
        done += [a.name for a in pressed(gui.screen.actions)]
        imgui.end_frame()
    assert done == [name] * 3


def test_every_key_of_a_shortcut_is_known(gui):
    shortcuts = {action.key for action in gui.screen.actions if action.key is not None}
    known = {imgui_key(key) for key in range(glfw.KEY_SPACE, glfw.KEY_LAST + 1)}
    assert shortcuts <= known


def click_at_once(gui, keys: FastKeys, at: tuple[float, float]) -> None:
    """Move and click between two frames, behind a press of a key."""
    io = gui.io
    for is_down in (True, False):
        typed(keys, imgui.Key.left_shift, is_down)
    io.add_mouse_pos_event(*at)
    keys.before_click()
    io.add_mouse_button_event(0, True)
    io.add_mouse_button_event(0, False)
    while events_wait():
        gui.frame()
    gui.frame(2)


def test_a_click_that_comes_with_its_movement_reaches_a_tab(gui):
    def at_tab(name: str) -> tuple[float, float]:
        window = imgui.internal.find_window_by_name(name)
        box = window.dc.dock_tab_item_rect
        return (box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2

    keys = FastKeys()
    for name in ("Plate", "Export", "Look"):
        click_at_once(gui, keys, at_tab(name))
        assert not imgui.internal.find_window_by_name(name).hidden, name


def test_typed_text_takes_few_frames_a_letter(gui):
    keys, text, frames = FastKeys(), "sssss", 0
    gui.key(imgui.Key.p, ctrl=True, shift=True)
    gui.frame(2)
    for letter in text:
        typed(keys, imgui.Key.s, True)
        gui.io.add_input_characters_utf8(letter)
        typed(keys, imgui.Key.s, False)
    while events_wait():
        gui.frame()
        frames += 1
    assert gui.ui.palette._text == text
    assert frames <= 2 * len(text)
    gui.key(imgui.Key.escape)
    gui.frame(2)
