"""Input that comes faster than frames: repeated events are merged, and no other is lost."""

import runpy
import sys
from itertools import pairwise

import glfw
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from imgui_bundle import imgui

from heatlens.core.model.view.view import Compare
from heatlens.studio.board.user_keys import NAMED_KEYS
from heatlens.studio.ui import devices
from heatlens.studio.ui.devices import imgui_key
from heatlens.studio.ui.input_queue import Button, Focus, InputQueue, Motion, Press, Release, Wheel
from heatlens.studio.ui.shortcuts import KEY_NAMES, chord_of, pressed

K = imgui.Key
CTRL, SHIFT = int(K.mod_ctrl), int(K.mod_shift)
_BITS = {K.left_shift: SHIFT, K.left_ctrl: CTRL}
_MOST_FRAMES = 500


class QueuedInput:
    """Puts events into an `InputQueue` as GLFW does, each with the modifiers held down."""

    def __init__(self, gui) -> None:
        self.gui, self.mods = gui, 0
        self.queue = InputQueue(gui.screen.must_wait_after)

    def down(self, key: K, text: str = "") -> None:
        self.mods |= _BITS.get(key, 0)
        self.queue.add(Press(key, self.mods))
        if text:
            self.queue.add_text(text)

    def up(self, key: K) -> None:
        self.mods &= ~_BITS.get(key, 0)
        self.queue.add(Release(key, self.mods))

    def tap(self, key: K, text: str = "", mod: K | None = None) -> None:
        if mod is not None:
            self.down(mod)
        self.down(key, text)
        self.up(key)
        if mod is not None:
            self.up(mod)

    def frame(self) -> bool:
        """Run a frame as the window does; return whether it was drawn."""
        self.queue.hand_out()
        self.gui.screen.typed_keys = self.queue.typed_keys
        is_drawn = not self.queue.has_waiting
        if is_drawn:
            self.gui.frame()
        else:
            self.gui.begin_imgui_frame()
            self.gui.screen.make_frame(imgui.end_frame, is_visible=False)  # handles the input
        return is_drawn

    def run_until_empty(self) -> int:
        """Run frames until nothing waits; return how many it took, of which one was drawn."""
        for count in range(1, _MOST_FRAMES):
            if self.frame():
                return count
        raise AssertionError("input waits for ever")


@pytest.fixture
def input_queue(gui) -> QueuedInput:
    gui.frame(3)
    queued_input = QueuedInput(gui)
    queued_input.run_until_empty()
    queued_input.run_until_empty()
    return queued_input


@pytest.mark.parametrize("count", [1, 2, 10])
def test_each_f1_between_two_frames_toggles_the_keys_window(input_queue, count):
    gui, toggle_count, was_shown = input_queue.gui, 0, input_queue.gui.ui.shows_keys
    for _ in range(count):
        input_queue.down(K.f1)
        input_queue.up(K.f1)
    while not input_queue.frame() or toggle_count == 0:
        toggle_count, was_shown = toggle_count + (gui.ui.shows_keys != was_shown), gui.ui.shows_keys
    toggle_count += gui.ui.shows_keys != was_shown
    assert toggle_count == count
    gui.ui.shows_keys = False
    gui.frame(2)


def test_modifier_pressed_after_a_key_does_not_apply_to_it(input_queue):
    """S and then Ctrl in one frame do not run the action of Ctrl+S."""
    gui = input_queue.gui
    name = next(a.name for a in gui.screen.commands if a.key == "Ctrl+S")
    for act in (input_queue.down, input_queue.up):
        act(K.s)
        act(K.left_ctrl)
    run_actions = []
    is_drawn = False
    while not is_drawn:
        is_drawn = input_queue.frame()
        run_actions += [a.name for a in pressed(gui.screen.commands)]
    assert name not in run_actions and not gui.ui.dialogs.is_open


def test_key_uses_the_modifiers_of_its_own_event(input_queue):
    """GLFW may omit the press of Ctrl, or send its release before that of the key."""
    view = input_queue.gui.session.facts.view
    for _ in range(3):
        input_queue.queue.add(Press(K.up_arrow, CTRL))
        input_queue.queue.add(Release(K.up_arrow, 0))
    input_queue.run_until_empty()
    assert input_queue.gui.session.facts.view.exposure_stops == view.exposure_stops + 3 / 4
    input_queue.gui.session.pictures.view.state = view


def test_imgui_key_knows_every_key_of_a_shortcut(gui):
    shortcuts = {chord_of(command.key)[0] for command in gui.screen.commands if command.key}
    known_keys = {imgui_key(key) for key in range(glfw.KEY_SPACE, glfw.KEY_LAST + 1)}
    assert shortcuts <= known_keys
    assert KEY_NAMES.keys() | {"?"} == set(NAMED_KEYS)
    assert {K.enter, K.keypad_enter, K.escape, K.left_alt, K.right_ctrl, K.page_up} <= known_keys


def test_cmd_of_a_mac_is_ctrl_and_ctrl_the_logo_key(monkeypatch):
    monkeypatch.setattr(sys, "platform", "darwin")
    on_mac = runpy.run_path(devices.__file__)
    mods, key = on_mac["imgui_mods"], on_mac["imgui_key"]
    assert mods(glfw.MOD_SUPER | glfw.MOD_SHIFT) == int(K.mod_ctrl) | int(K.mod_shift)
    assert mods(glfw.MOD_CONTROL) == int(K.mod_super)
    assert (key(glfw.KEY_LEFT_SUPER), key(glfw.KEY_RIGHT_CONTROL)) == (K.left_ctrl, K.right_super)
    assert key(glfw.KEY_S, "s") == K.s
    assert on_mac["_OWN_MOD"][glfw.KEY_LEFT_SUPER] == glfw.MOD_SUPER


@pytest.mark.parametrize(
    ("key_code", "printed", "key"),
    [
        (glfw.KEY_Y, "z", K.z),  # German
        (glfw.KEY_Q, "a", K.a),  # French
        (glfw.KEY_MINUS, "ß", K.minus),  # nothing that ImGui knows
        (glfw.KEY_SPACE, " ", K.space),
        (glfw.KEY_A, None, K.a),
        (glfw.KEY_KP_5, None, K.keypad5),
        (glfw.KEY_LEFT, None, K.left_arrow),
    ],
)
def test_imgui_key_follows_the_keyboard_layout(key_code, printed, key):
    assert imgui_key(key_code, printed) == key


def test_click_in_the_same_frame_as_its_movement_reaches_a_tab(input_queue):
    def at_tab(name: str) -> tuple[float, float]:
        window = imgui.internal.find_window_by_name(name)
        box = window.dc.dock_tab_item_rect
        return (box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2

    for name in ("Source", "Export", "Display"):
        input_queue.tap(K.left_shift)
        input_queue.queue.add(Motion(at_tab(name)))
        input_queue.queue.add(Button(0, is_down=True))
        input_queue.queue.add(Button(0, is_down=False))
        input_queue.run_until_empty()
        input_queue.gui.frame(2)
        assert not imgui.internal.find_window_by_name(name).hidden, name


def test_typed_text_is_handled_in_few_frames(input_queue):
    gui, text = input_queue.gui, "sssss of"
    input_queue.tap(K.p, "", K.left_ctrl)  # no command
    input_queue.queue.add(Press(K.p, CTRL | SHIFT))
    input_queue.queue.add(Release(K.p, 0))
    for letter in text:
        input_queue.tap(
            imgui.Key(int(K.a) + ord(letter) - ord("a")) if letter != " " else K.space, letter
        )
    assert input_queue.run_until_empty() <= 12
    gui.frame(2)
    assert gui.ui.palette._text == text
    gui.key(K.escape)
    gui.frame(2)


def test_keys_typed_before_the_pull_box_is_drawn_reach_it(input_queue):
    """Shift+M opens the box of the pull, which takes 18 and Enter; W then goes to the window."""
    gui = input_queue.gui
    session = gui.session
    session.time.marks.set_here()
    frame, wiped = session.editing.frame, session.facts.view.compare
    input_queue.tap(K.m, "M", K.left_shift)
    for digit in "18":
        input_queue.tap(imgui.Key(int(K._0) + int(digit)), digit)
    input_queue.tap(K.enter)
    input_queue.tap(K.w, "w")
    input_queue.run_until_empty()
    assert session.time.marks.pulls.frames == 18
    assert session.facts.view.compare is Compare.WIPE is not wiped
    assert session.editing.frame == frame and not imgui.get_io().want_text_input
    gui.begin_again()


# Overlays: v depth, c blur, p focus plane; w is the wipe.
def test_different_keys_are_handled_in_order_in_two_frames_at_most(input_queue):
    gui = input_queue.gui
    for key in (K.v, K.c, K.w, K.p):  # the overlay that was asked for last stays
        input_queue.tap(key)
    assert input_queue.run_until_empty() <= 2
    assert gui.session.facts.view.overlay == "focus plane"
    assert gui.session.facts.view.compare is Compare.WIPE
    for key in (K.p, K.c, K.w):
        input_queue.tap(key)
    assert input_queue.run_until_empty() <= 2
    assert gui.session.facts.view.overlay == "coc"
    gui.begin_again()


_SWITCHES = {K.d: "depth_of_field", K.g: "pixel_grid"}
_ACTS = st.lists(
    st.sampled_from([*_SWITCHES, K.left_bracket, K.right_bracket, "move", "wheel"]), max_size=400
)


@given(acts=_ACTS)
@example(acts=[K.d] * 4)
def test_input_queue_loses_no_distinct_event_and_draws_few_frames(window_hand, acts):
    input_queue, session = window_hand, window_hand.gui.session
    view, history = session.facts.view, session.editing.history
    notches = 0
    for number, act in enumerate(acts):
        if act == "move":
            input_queue.queue.add(Motion((600.0 + number % 7, 300.0)))
        elif act == "wheel":
            input_queue.queue.add(Wheel(0.0, 1.0))
        else:
            input_queue.tap(act)
            notches += (act == K.left_bracket) - (act == K.right_bracket)
    # A key that is tapped again can go down only in the frame after its release.
    repeats = sum(a == b for a, b in pairwise(acts) if a not in ("move", "wheel"))
    assert input_queue.run_until_empty() <= len(acts) + repeats + 3
    for key, field in _SWITCHES.items():
        is_other = acts.count(key) % 2 == 1
        assert getattr(session.facts.view, field) == (getattr(view, field) != is_other)
    session.pictures.view.state, session.editing.history = view, history


@pytest.fixture(scope="module")
def window_hand(room_window) -> QueuedInput:
    room_window.begin_again()
    queued_input = QueuedInput(room_window)
    queued_input.run_until_empty()
    queued_input.run_until_empty()
    return queued_input


def test_hundreds_of_movements_and_wheel_repeats_take_two_frames(input_queue):
    for number in range(900):
        input_queue.queue.add(Motion((300.0 + number / 3, 400.0)))
    input_queue.queue.add(Wheel(0.0, 1.0))
    for _ in range(300):
        input_queue.queue.add(Wheel(0.0, 0.0))
    assert input_queue.run_until_empty() == 2
    assert imgui.get_io().mouse_pos.x == 599.0
    input_queue.gui.begin_again()


@pytest.mark.parametrize("before", [0, 600])
def test_quit_is_handled_before_other_keys_but_after_a_save(input_queue, monkeypatch, before):
    gui, save_calls = input_queue.gui, []
    monkeypatch.setattr(gui.session.files.documents, "save", lambda: save_calls.append(1) or True)
    for number in range(before):
        input_queue.tap((K.v, K.enter, K.left_arrow)[number % 3])
    input_queue.tap(K.s, "", K.left_ctrl)
    for number in range(600):
        input_queue.tap((K.v, K.enter, K.left_arrow)[number % 3])
    input_queue.tap(K.q, "", K.left_ctrl)
    count = 0
    while not gui.ui.is_over:
        input_queue.frame()
        count += 1
        assert count <= 12 + 3 * before
    assert save_calls
    gui.ui.is_over = False
    gui.begin_again()


def test_escape_drops_waiting_input_and_releases_keys_and_buttons(input_queue):
    gui = input_queue.gui
    before = gui.session.facts.view.overlay
    input_queue.queue.add(Button(0, is_down=True))
    input_queue.frame()
    input_queue.down(K.left_shift)
    for _ in range(301):
        input_queue.tap(K.v)
        input_queue.queue.add(Motion((500.0, 400.0)))
        input_queue.queue.add(Button(0, is_down=False))
    input_queue.up(K.left_shift)
    input_queue.tap(K.escape)
    assert input_queue.run_until_empty() <= 12  # releases and the last movement are kept
    assert gui.session.facts.view.overlay is before
    assert not imgui.is_mouse_down(0) and not imgui.get_io().key_shift
    assert tuple(imgui.get_io().mouse_pos) == (500.0, 400.0)
    gui.begin_again()


def test_hurry_drops_waiting_input_except_a_save(input_queue):
    input_queue.tap(K.s, "", K.left_ctrl)
    for _ in range(40):
        input_queue.tap(K.v)
    input_queue.queue.drop_after_save()
    assert input_queue.queue.has_waiting_save
    input_queue.run_until_empty()
    assert not input_queue.queue.has_waiting_save
    input_queue.gui.key(K.escape)
    input_queue.gui.begin_again()


def test_lost_keyboard_focus_releases_the_modifiers(input_queue):
    input_queue.down(K.left_shift)
    input_queue.queue.add(Focus(False))
    input_queue.queue.add(Focus(True))
    input_queue.run_until_empty()
    assert not imgui.get_io().key_shift
