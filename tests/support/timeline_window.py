"""A window with a small sequence in it, for tests of the timeline."""

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import moderngl
from imgui_bundle import imgui

from heatlens.ui.timeline.timeline import Timeline
from support.gui import Gui, gui_of
from support.sequences import FIRST, LAST, sequence_files
from support.window_plates import QUICK

K = imgui.Key


class Clock:
    """Stands still unless it is moved."""

    def __init__(self) -> None:
        self.now_s = 5.0

    def __call__(self) -> float:
        return self.now_s


@contextmanager
def film_window(ctx: moderngl.Context, folder: Path) -> Iterator[Gui]:
    """The sequence open, every frame of it read."""
    pattern = sequence_files(folder, framesPerSecond=Fraction(25, 1))
    with gui_of(ctx, pattern, defocus=QUICK) as gui:
        gui.until(lambda: len(gui.app.timeline.runs()) == 1, "all frames")
        yield gui


def fresh(film: Gui) -> Gui:
    """The window as it was in the beginning, its film driven by a clock that stands."""
    app = film.app
    app.timeline = Timeline(app)
    app.timeline.playback._clock = Clock()
    if app.source.opened.text != app.start.source:
        film.begin_again()
        film.until(lambda: len(app.timeline.runs()) == 1, "all frames")
    film.io.clear_input_keys()
    film.io.add_mouse_pos_event(-1e4, -1e4)
    app.view, app.message, app.editing.frame = app.color.with_names(app.start.view), "", FIRST
    app.editing.begin(app.source.opened.shot(app.begun.lens, app.shot.defocus))
    app.editing.auto_key = True
    film.frame(2)
    return film


def frame(gui) -> int:
    return gui.app.editing.frame


def at_frame(gui, number: float) -> tuple[float, float]:
    """The middle of a frame's cell on the ruler."""
    x0, y0, x1, y1 = gui.rect("timeline ruler")
    return x0 + (number - FIRST + 0.5) * (x1 - x0) / (LAST - FIRST + 1), (y0 + y1) / 2


def typed(gui, name: str, text: str) -> None:
    gui.frame(30)
    gui.click(gui.middle(name))
    gui.key(K.a, ctrl=True)
    gui.type(text)
    gui.key(K.enter)
    gui.frame(2)
