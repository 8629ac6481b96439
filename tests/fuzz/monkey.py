"""Play at random with the whole interface: keys, words, clicks, drags and wheels, without a window.

    python tests/fuzz/monkey.py --actions 3000 --seed 7

It plays with a small sequence, or with the demo (`--source demo`), and says which random
numbers it has, so that what it finds can be found again. It ends at the first fault, and prints
how much memory the process holds as it goes. A long play does the same things again and again:
programs, textures and fonts are made when they are needed first, so memory grows in steps. Which
pictures are finished depends on the speed of the machine, so later plays still need a new program
now and then, and one takes up to 5 MB with Mesa's software driver. Memory that is larger by more
than a twentieth at the end of a play that needed no new program is a fault.
Rendered frames do not count: they are kept on purpose, up to a limit that a user chooses, and how
many there are after so many actions depends on the speed of the machine.
"""

import argparse
import gc
import random
import sys
import tempfile
from pathlib import Path
from statistics import median

from imgui_bundle import imgui

from heatlens.render.gpu.linked_program import LinkedProgram

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from heatlens.core.base.faults import FaultError
from heatlens.core.base.memory import share_one_heap
from support.gui import Gui, gui_of
from support.sequences import sequence_files
from support.session_files import QUICK

K = imgui.Key
_KEYS = (
    *(imgui.Key(int(K.a) + n) for n in range(26)),
    *(imgui.Key(int(K._0) + n) for n in range(10)),
    *(K.space, K.enter, K.escape, K.tab, K.delete, K.backspace, K.home, K.end),
    *(K.left_arrow, K.right_arrow, K.up_arrow, K.down_arrow, K.page_up, K.page_down),
    *(K.left_bracket, K.right_bracket, K.equal, K.minus, K.comma, K.period, K.slash),
    *(K.f1, K.f10, K.f11, K.f12),
)
_WORDS = (
    "3.5",
    "inf",
    "1001",
    "abc",
    "-4",
    "",
    "2,8",
    "10:00:00:00",
    "é",
    "1e400",
    "f/1.4",
    "6'3\"",
)
# What leaves the window, writes where the user's files lie, or starts processes of its own.
_SKIPPED_ACTIONS = ("Quit", "Copy picture", "Open the demo", "Clear rendered frames")


class Monkey:
    """A player that does one random action at a time in a window."""

    def __init__(self, gui: Gui, seed: int) -> None:
        self.gui = gui
        self.seed = seed
        self.rng = random.Random(seed)
        self.source = gui.session.given.start.source
        self.recent_actions: list[str] = []

    def act(self, number: int) -> None:
        """Do a random action and record it. The same `number` repeats the same action.

        Each action has its own random numbers, because how many of them an action takes depends
        on the current state of the window.
        """
        self.rng = random.Random(f"{self.seed} {number}")
        action_kinds = (
            self._key,
            self._click,
            self._drag,
            self._wheel,
            self._type,
            self._action,
            self._wait,
        )
        action_kind = self.rng.choices(action_kinds, (6, 5, 4, 3, 2, 3, 1))[0]
        self.recent_actions = [*self.recent_actions[-20:], action_kind.__name__]
        action_kind()
        self._undo_quit()

    def _undo_quit(self) -> None:
        """Undo what would end the play: a quit, an export, a file dialog, another source."""
        gui = self.gui
        gui.ui.is_over = gui.ui.asks_to_quit = False
        if gui.ui.dialogs.is_open and self.rng.random() < 0.5:
            gui.key(K.escape)
        if gui.session.files.exports.run.is_busy:
            gui.session.files.exports.run.cancel()
        opening, opened_source = gui.session.source.opener.opening, gui.session.source.opened
        current_source = opening or (
            opened_source.text if opened_source is not None else self.source
        )
        if current_source != self.source:  # the demo takes minutes for a picture without a GPU
            gui.session.files.commands.open(self.source)

    def _random_position(self) -> tuple[float, float]:
        """Return a random position in the window, mostly on a control."""
        gui, rng = self.gui, self.rng
        width, height = gui.size
        if gui.drawn and rng.random() < 0.8:
            name = rng.choice(sorted(gui.drawn))
            if name not in _BARRED:
                x0, y0, x1, y1 = gui.rect(name)
                self.recent_actions[-1] += f" {name}"
                return rng.uniform(x0, x1), rng.uniform(y0, y1)
        return rng.uniform(0, width), rng.uniform(0, height)

    def _key(self) -> None:
        key = self.rng.choice(_KEYS)
        ctrl, shift = self.rng.random() < 0.25, self.rng.random() < 0.25
        if ctrl and key in (K.q, K.e, K.c):  # leaves, exports, needs a clipboard
            ctrl = False
        self.recent_actions[-1] += f" {key.name} {ctrl} {shift}"
        self.gui.key(key, ctrl, shift)

    def _click(self) -> None:
        position, button = self._random_position(), self.rng.choice((0, 0, 0, 1, 2))
        if self.rng.random() < 0.1:
            self.gui.hold(K.mod_ctrl)
            self.gui.hold(K.mod_shift)
        self.gui.click(position, button)
        self.gui.hold(K.mod_ctrl, down=False)
        self.gui.hold(K.mod_shift, down=False)

    def _drag(self) -> None:
        self.gui.drag(
            self._random_position(),
            self._random_position(),
            self.rng.choice((0, 0, 0, 1, 2)),
            steps=3,
        )

    def _wheel(self) -> None:
        self.gui.wheel(self._random_position(), self.rng.choice((-3.0, -1.0, 1.0, 3.0)))

    def _type(self) -> None:
        self.gui.type(self.rng.choice(_WORDS))
        if self.rng.random() < 0.7:
            self.gui.key(K.enter)

    def _action(self) -> None:
        action = self.rng.choice(self.gui.screen.commands)
        if action.name not in _SKIPPED_ACTIONS:
            self.recent_actions[-1] += f" {action.name}"
            self.gui.screen._board.do(action)
            self.gui.frame(2)

    def _wait(self) -> None:
        for _ in range(self.rng.randrange(10)):
            self.gui.session.work()
            self.gui.frame()
        self.gui.later()


_SIZE = 960, 600
_BARRED = ("Export", "Write camera", "open in browser", "window close")
_ACTIONS_PER_SAMPLE = 250  # actions between two measurements of the memory
_LONG = 1000  # actions from which on a play is repeated, and its memory compared
_GROWTH_MOST = 0.05  # growth of memory that is tolerated
_PLAYS = 8  # after so many all programs are made


def rss_mb() -> float:
    """Return how much memory this process holds, in millions of bytes."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) * 1024 / 1e6
    return 0.0


def memory_mb_without_frames(gui: Gui) -> float:
    """Return the memory of this process in MB, without the rendered frames that it keeps."""
    return rss_mb() - gui.session.time.frames_ahead.store.memory.bytes_in_use / 1e6


def play(gui: Gui, actions: int, seed: int, report=print) -> list[float]:
    """Let a monkey do `actions` actions. Return `memory_mb_without_frames` after each 250.

    Raises AssertionError where a fault is said or raised.
    """
    monkey, faults_said, memory_mb = Monkey(gui, seed), [], []
    show_original_error = gui.session.show_error

    def show_error(error):
        if isinstance(error, FaultError):
            faults_said.append(error)
        show_original_error(error)

    gui.session.show_error = show_error
    gui.session.time.scheduler._show_error = show_error
    report(f"seed {seed}, 0 actions: {rss_mb():.0f} MB")
    for number in range(1, actions + 1):
        try:
            monkey.act(number)
        except Exception as error:
            raise AssertionError(
                f"action {number} of seed {seed}: {monkey.recent_actions}"
            ) from error
        assert not faults_said, (
            f"action {number} of seed {seed}: {faults_said[0]} after {monkey.recent_actions}"
        )
        if number % _ACTIONS_PER_SAMPLE == 0:
            memory_mb.append(memory_mb_without_frames(gui))
            report(f"{number} actions: {memory_mb[-1]:.0f} MB")
    return memory_mb


def growth(first_mb: list[float], second_mb: list[float]) -> float:
    """Return the relative growth of the memory at the end from the first to the second play."""
    half = len(first_mb) // 2
    return median(second_mb[-half:]) / median(first_mb[-half:]) - 1.0


def main() -> None:
    """Play as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--actions", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=random.randrange(10**6))
    parser.add_argument("--source", default="")
    args = parser.parse_args()
    from heatlens.render.gpu.context import headless_context

    share_one_heap()
    with tempfile.TemporaryDirectory() as folder:
        source = args.source or sequence_files(Path(folder))
        with gui_of(headless_context(), source, defocus=QUICK, size=_SIZE) as gui:
            if args.actions < _LONG:
                play(gui, args.actions, args.seed)
                return
            first_mb, second_mb = play_until_no_new_program(gui, args.actions // 3, args.seed)
    grown = growth(first_mb, second_mb)
    print(f"growth in the last play: {grown:+.1%}")
    assert grown <= _GROWTH_MOST, "memory grows"


def play_until_no_new_program(gui: Gui, actions: int, seed: int) -> list[list[float]]:
    """Repeat a play until it needs no new program. Return the memory in the last two plays."""
    memory_mb, programs = [play(gui, actions, seed)], 0
    while programs_alive() > programs or len(memory_mb) < 3:
        programs = programs_alive()
        memory_mb.append(play(gui, actions, seed))
        assert len(memory_mb) <= _PLAYS, f"each of {_PLAYS} plays needed a new program"
    return memory_mb[-2:]


def programs_alive() -> int:
    """Return how many shader programs this process holds."""
    gc.collect()
    return sum(isinstance(thing, LinkedProgram) for thing in gc.get_objects())


if __name__ == "__main__":
    main()
