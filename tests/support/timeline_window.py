"""A window with a small sequence in it, for tests of the timeline."""

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

from imgui_bundle import imgui

from heatlens.core.model.curves.frames import Ending
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import EASE_PERCENT
from heatlens.render.gpu.device import Device
from heatlens.studio.board.key_drag import KeyDrag, KeyStretch
from heatlens.studio.session.marks.focus_pulls import PULL_FRAMES
from heatlens.studio.ui.timeline.view import TimelineView
from support.gui import Gui, gui_of
from support.sequences import FIRST, LAST, sequence_files
from support.session_files import QUICK

K = imgui.Key


class Clock:
    """A clock that stands still unless a test sets `now_s`."""

    def __init__(self) -> None:
        self.now_s = 5.0

    def __call__(self) -> float:
        return self.now_s


@contextmanager
def film_window(ctx: Device, folder: Path) -> Iterator[Gui]:
    """Yield a window with the sequence open and every frame of it read."""
    pattern = sequence_files(folder, framesPerSecond=Fraction(25, 1))
    with gui_of(ctx, pattern, defocus=QUICK) as gui:
        gui.until(lambda: len(gui.session.time.timeline.runs()) == 1, "all frames")
        yield gui


def reset_timeline(gui: Gui) -> None:
    """Reset the timeline, its panel and the selection to the beginning."""
    session, time, marks = gui.session, gui.session.time.timeline, gui.session.time.marks
    time.playback.stop()
    time.playback.ending, time.playback.is_every_frame = Ending.LOOP, True
    time.missing, time.direction = "hold", 1
    session.time.keys.select(frozenset())
    session.time.keys._copied_keys = ()
    session.time.keys.rows.select(LensParameter.FOCUS_DISTANCE)
    session.time.keys.rows.shows_curve = False
    gui.frame(2)  # the timeline becomes as high as before the curve
    marks.pulls.origin = None
    marks.pulls.target = ""
    marks.pulls.ease_percent = EASE_PERCENT
    marks.pulls.set_length(PULL_FRAMES)
    session.time.scene_tracks._current_view_key = None
    drag_arguments = session.editing, session.time.keys, session.messages.notify
    gui.ui.timeline = TimelineView(KeyDrag(*drag_arguments), KeyStretch(*drag_arguments))
    session.time.recording.finish()
    session.time.recording.beats = 0
    gui.ui.opens_pull = False


def reset_window(film: Gui) -> Gui:
    """Reset the window to its start, with playback driven by a stopped clock. Return it."""
    session = film.session
    reset_timeline(film)
    session.time.timeline.playback._clock = Clock()
    if session.source.opened.text != session.given.start.source:
        film.begin_again()
        film.until(lambda: len(session.time.timeline.runs()) == 1, "all frames")
    film.io.clear_input_keys()
    film.io.add_mouse_pos_event(-1e4, -1e4)
    session.pictures.view.state = session.pictures.color.limit_to_config(session.given.start.view)
    session.messages.clear()
    session.editing.frame = FIRST
    session.editing.begin(
        session.source.opened.shot(
            session.lens.commands.start_lens.lens, session.facts.shot.defocus
        )
    )
    session.editing.auto_key = True
    film.frame(2)
    return film


def current_frame(gui) -> int:
    return gui.session.editing.frame


def ruler_position(gui, number: float) -> tuple[float, float]:
    """Return the window position of the middle of a frame's cell on the ruler."""
    x0, y0, x1, y1 = gui.rect("timeline ruler")
    return x0 + (number - FIRST + 0.5) * (x1 - x0) / (LAST - FIRST + 1), (y0 + y1) / 2


def type_into(gui, name: str, text: str) -> None:
    gui.frame(30)
    gui.click(gui.middle(name))
    gui.key(K.a, ctrl=True)
    gui.type(text)
    gui.key(K.enter)
    gui.frame(2)
