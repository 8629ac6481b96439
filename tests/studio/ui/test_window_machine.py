"""Random user input: no exception, no OpenGL error, and undo leads back to the first shot."""

import math

import numpy as np
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test
from imgui_bundle import imgui

from heatlens.studio.ui.shortcuts import CTRL, SHIFT, chord_of
from support.commands import listed_commands
from support.gui import Gui, gui_of
from support.plates import room
from support.session_files import HEIGHT, QUICK, WIDTH, write_plate

K = imgui.Key
# Dialogs have a test of their own, as they write files.
TESTED_ACTIONS = [
    action
    for action in listed_commands()
    if action.name != "Quit" and action.name != "Copy picture" and not action.name.endswith("...")
]
DRAGGED_CONTROLS = ("focus bar", "f-stop", "focal length", "exposure", "gamma")
FIELDS = ("distance", "f-stop field", "T-stop")
TEXTS = ("2.24", "6'3\"", "inf", "0.01", "two", "", "f/1.4", "1e9", "-1", "T2", "∞")
PICTURE_POINTS = st.tuples(st.floats(-0.3, 1.3), st.floats(-0.3, 1.3))
WINDOW_POINTS = st.tuples(st.floats(0.001, 0.999), st.floats(0.05, 0.999))  # below the menus


class RandomUser(RuleBasedStateMachine):
    """A user who clicks, drags, types and runs actions at random."""

    def __init__(self, gui: Gui) -> None:
        super().__init__()
        self.gui = gui
        gui.begin_again()
        self.first = gui.session.facts.shot

    def at(self, point: tuple[float, float]) -> tuple[float, float]:
        """Return the window position of a point given as fractions of the picture's sides."""
        return self.gui.at_picture(point[0] * WIDTH, point[1] * HEIGHT)

    def anywhere(self, point: tuple[float, float]) -> tuple[float, float]:
        return point[0] * self.gui.size[0], point[1] * self.gui.size[1]

    @rule(action=st.sampled_from(TESTED_ACTIONS))
    def does(self, action):
        self.gui.do(action.name)

    @rule(action=st.sampled_from([action for action in TESTED_ACTIONS if action.key]))
    def presses_a_key(self, action):
        key, mods = chord_of(action.key)
        self.gui.key(key, bool(mods & CTRL), bool(mods & SHIFT))

    @rule(point=PICTURE_POINTS, button=st.integers(0, 2))
    def clicks_at_the_picture(self, point, button):
        self.gui.click(self.at(point), button)

    @rule(start=PICTURE_POINTS, end=PICTURE_POINTS, button=st.integers(0, 2))
    def drags_over_the_picture(self, start, end, button):
        self.gui.drag(self.at(start), self.at(end), button, steps=2)

    @rule(point=WINDOW_POINTS)
    def clicks_anywhere(self, point):
        self.gui.click(self.anywhere(point))

    @rule(start=WINDOW_POINTS, end=WINDOW_POINTS)
    def drags_anything(self, start, end):
        self.gui.drag(self.anywhere(start), self.anywhere(end), steps=2)

    @rule(point=WINDOW_POINTS)
    def takes_hold_and_does_not_let_go(self, point):
        self.gui.press(self.anywhere(point))

    @rule(point=WINDOW_POINTS)
    def lets_go(self, point):
        self.gui.move(self.anywhere(point))
        self.gui.release()

    @rule(point=WINDOW_POINTS, notches=st.integers(-5, 5))
    def turns_the_wheel(self, point, notches):
        self.gui.wheel(self.anywhere(point), notches)

    @rule(name=st.sampled_from(DRAGGED_CONTROLS), by=st.integers(-200, 200))
    def drags_a_control(self, name, by):
        x, y = self.gui.middle(name)
        self.gui.drag((x, y), (x + by, y), steps=2)

    @rule(
        name=st.sampled_from(FIELDS),
        text=st.sampled_from(TEXTS),
        end=st.sampled_from(["enter", "escape", "tab"]),
    )
    def types_in_a_field(self, name, text, end):
        self.gui.later()
        self.gui.click(self.gui.middle(name))
        self.gui.type(text)
        self.gui.key(getattr(K, end))

    @rule(
        words=st.sampled_from(["focus", "lay", "zzz", "", "fit"]),
        key=st.sampled_from([K.enter, K.escape, K.down_arrow]),
    )
    def finds_a_command(self, words, key):
        self.gui.ui.palette.open()
        self.gui.frame(3)
        self.gui.type(words)
        self.gui.key(key)
        self.gui.key(K.escape)

    @rule(down=st.booleans())
    def holds_alt(self, down):
        self.gui.io.add_key_event(K.mod_alt, down)
        self.gui.hold(K.left_alt, down)

    @rule()
    def rests(self):
        self.gui.rest()

    @rule()
    def waits_for_the_whole_picture(self):
        self.gui.release()
        # Two pictures that play are never both at rest.
        self.gui.session.time.timeline.playback.stop()
        self.gui.settled()

    @invariant()
    def the_picture_is_of_the_shot(self):
        session = self.gui.session
        if (
            not session.time.timeline.playback.direction
        ):  # a hand on a focus that plays is ever ahead
            is_there = session.source.is_settled_at
            self.gui.until(lambda: is_there(session.editing.frame), "the plate of the frame")
            self.gui.frame()  # a click is answered in the frame after
            assert session.pictures.live.output.shot == session.facts.shot
        assert self.gui.ui.is_over is False

    @invariant()
    def the_view_is_one_that_can_be_looked_at(self):
        view = self.gui.session.facts.view
        assert view.zoom is None or 1 / 64 <= view.zoom <= 256
        assert view.center_px is None or all(math.isfinite(c) for c in view.center_px)
        assert 0 <= view.wipe <= 1 and 0.5 <= view.difference_gain <= 64
        assert "Traceback" not in self.gui.session.messages.text

    def teardown(self):
        gui = self.gui
        for button in range(3):
            gui.release(button)
        self.arrived()
        gui.rest()
        self.goes(gui.session.editing.redo)
        last = gui.session.facts.shot
        self.goes(gui.session.editing.undo)
        assert gui.session.facts.shot == self.first
        self.goes(gui.session.editing.redo)
        assert gui.session.facts.shot == last

    def goes(self, step) -> None:
        """Call `step` (undo or redo) until the shot does not change any more."""
        before = None
        while self.gui.session.facts.shot != before:
            before = self.gui.session.facts.shot
            step()
            self.arrived()
        history = self.gui.session.editing.history
        assert not (history.past if step == self.gui.session.editing.undo else history.future)

    def arrived(self) -> None:
        """Wait until the plate is read with the options of the shot."""
        self.gui.frame()
        self.gui.until(lambda: not self.gui.session.source.opener.opening, "the plate")
        self.gui.frame()


def run_random_user(gui: Gui) -> None:
    run_state_machine_as_test(
        lambda: RandomUser(gui),
        settings=settings(
            max_examples=5,
            stateful_step_count=40,
            deadline=None,
            phases=[Phase.generate],  # a failure is told step by step; shrinking it takes minutes
            suppress_health_check=list(HealthCheck),
        ),
    )


def test_random_input_on_one_frame_causes_no_error(gui):
    run_random_user(gui)


def test_random_input_on_a_sequence_causes_no_error(ctx, tmp_path):
    color, depth = room(WIDTH, HEIGHT)
    for frame in (1, 2, 3, 5):
        write_plate(tmp_path / f"room.{frame:04}.exr", color * np.float32(frame), Z=depth)
    with gui_of(ctx, tmp_path / "room.####.exr", defocus=QUICK) as gui:
        run_random_user(gui)
