"""Show the progress of a picture on a terminal, in one line that is rewritten and then cleared."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TextIO

from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.output.progress_line import progress_line, time_text
from heatlens.fronts.commands.output.say import shows_progress
from heatlens.render.frame_renderer import FrameRenderer

_SILENT_START_S = 1.0  # no progress is shown for faster pictures
_UPDATE_INTERVAL_S = 0.25  # interval between updates, because each one waits for the GPU
_VIEW_STEPS = ("view", "rays")  # steps that draw a whole picture from one point of the lens

# The work before the first and after the last layer, counted in layers, and the share of a
# layer that is finished when each of its passes begins. These are means of `heatlens render
# --stats` on plates of 320 to 2048 pixels. They differ by a factor of two from plate to plate, and
# so does the estimate of the time left.
_LAYERS_BEFORE, _LAYERS_AFTER = 1.5, 0.3
_DONE_SHARES = {"layer split": 0.0, "hidden fill": 0.15, "coc fill": 0.35, "blur": 0.5}
_DONE_SHARES |= {"composite": 1.0, "highlights drawn": 1.0}
_DRAWING_STEPS = ("pinhole", "behind")  # steps that draw a scene, which come before all others
_FINDING_STEPS = ("coc", "highlights found", "highlights listed", "fragments")


@dataclass
class LayerCount:
    """The progress through the layers of a picture.

    rounds  how often all layers are processed: twice if alpha is blurred as well
    """

    rounds: int = 1
    layers: int = 0  # number of layers; 0 before the first one begins
    done_layers: int = 0  # finished layers of this round
    _round: int = 0

    def begin_layer(self, done: int, layers: int) -> None:
        """Record that `done` layers of this round are finished; with 0, a new round begins."""
        self._round += done == 0
        self.done_layers, self.layers = done, layers

    def finished_share(self, name: str) -> float | None:
        """Return the finished share, 0 to 1, at the pass `name`; None before the first layer."""
        if not self.layers:
            return None
        total_work = _LAYERS_BEFORE + self.layers + _LAYERS_AFTER
        done_work = _LAYERS_BEFORE + self.done_layers + _DONE_SHARES.get(name, 0.0)
        return (self._round - 1 + done_work / total_work) / max(self.rounds, self._round)

    @property
    def text(self) -> str:
        """The current layer as text: layer 2 of 6."""
        layer_text = f"layer {self.done_layers + 1} of {self.layers}"
        return (
            layer_text
            if self.rounds == 1
            else f"{layer_text}, {'alpha' if self._round == 1 else 'colour'}"
        )


@dataclass
class PictureCount:
    """The progress of a picture: first through drawing the scene, then through the layers.

    drawings   number of steps for drawing the scene; 0 for a plate
    """

    drawings: int
    layers: LayerCount = field(default_factory=LayerCount)
    drawn_steps: int = 0
    drawn_s: float = 0.0  # when the last of those steps was done, in seconds from the start

    def count_step(self, name: str, seconds: float) -> None:
        """Count the step `name` if it draws; it was finished `seconds` after the start."""
        if name in _DRAWING_STEPS:
            self.drawn_steps, self.drawn_s = self.drawn_steps + 1, seconds

    def text(self, name: str, seconds: float) -> str:
        """Return the current work after the step `name` as text, with the time left if known."""
        if name in _DRAWING_STEPS and self.drawn_steps <= self.drawings:
            left_s = seconds / self.drawn_steps * (self.drawings - self.drawn_steps)
            return f"drawing the scene, about {time_text(left_s)} left"
        share = self.layers.finished_share(name)
        if share is None:
            step_text = "finding the layers" if name in _FINDING_STEPS else name
            return f"{step_text}, {time_text(seconds)} so far"
        left_s = (seconds - self.drawn_s) * (1 / share - 1)
        return f"{self.layers.text}, about {time_text(left_s)} left"


@contextmanager
def picture_progress(
    renderer: FrameRenderer, shot: Shot, stream: TextIO | None = None
) -> Iterator[Callable[[str], None]]:
    """Yield a function for the name of each step of a picture; it prints progress and time left.

    Nothing is printed if `stream` (default stderr) is not a terminal.
    """
    if shot.defocus.method.needs_scene:
        with view_progress(shot, stream) as report_view:
            yield report_view
        return
    if not shows_progress(stream or sys.stderr):  # showing progress waits for the GPU at each layer
        yield lambda _: None
        return
    count, start = PictureCount(_count_drawing_steps(renderer, shot)), time.perf_counter()
    with _timed_line(stream) as write:

        def report_step(name: str) -> None:
            count.count_step(name, time.perf_counter() - start)
            write(lambda seconds: count.text(name, seconds), renderer.ctx.finish)

        def begin_layer(done: int, layers: int) -> None:
            """Record that `done` layers of this round are finished; with 0, a new round begins."""
            count.layers.rounds = 2 if renderer.loaded.plate.has_alpha else 1
            count.layers.begin_layer(done, layers)
            report_step("layer split")

        renderer.set_layer_callback(begin_layer)
        try:
            yield report_step
        finally:
            renderer.set_layer_callback(None)


def _count_drawing_steps(renderer: FrameRenderer, shot: Shot) -> int:
    """Return the number of steps for drawing the scene; 0 for a plate."""
    if renderer.scene is None:
        return 0
    from heatlens.render.scene_gpu.pinhole_draw import drawing_steps  # not needed for plates

    size = (shot.framing or Framing()).size
    return drawing_steps(renderer.ctx, renderer.scene.triangle_count, size)


@contextmanager
def view_progress(shot: Shot, stream: TextIO | None = None) -> Iterator[Callable[[str], None]]:
    """Yield a function for each step of a picture; it prints how many views of a scene are done."""
    done_views = 0
    with _timed_line(stream) as write:

        def report_step(name: str) -> None:
            """Print the views that are done, and the time that the others will take."""
            nonlocal done_views
            done_views += name in _VIEW_STEPS
            views = max(shot.defocus.views, done_views)
            if done_views:
                write(
                    lambda seconds: (
                        f"view {done_views} of {views}, "
                        f"{time_text(seconds / done_views * (views - done_views))} left"
                    )
                )
            else:
                write(lambda seconds: f"drawing the scene, {time_text(seconds)} so far")

        yield report_step


WriteLine = Callable[..., None]


@contextmanager
def _timed_line(stream: TextIO | None) -> Iterator[WriteLine]:
    """Yield a function that overwrites one line, and clear the line at the end.

    Its arguments are a function that makes the text from the elapsed seconds, and one that waits
    for the GPU first. It shows nothing in the first second, and limits the rate of updates later.
    """
    start = time.perf_counter()
    last = start + _SILENT_START_S - _UPDATE_INTERVAL_S
    with progress_line(stream) as show:

        def write(text: Callable[[float], str], wait: Callable[[], None] = lambda: None) -> None:
            """Show a text, made of the seconds so far, unless one was shown just before."""
            nonlocal last
            if time.perf_counter() - last < _UPDATE_INTERVAL_S:
                return
            wait()
            last = time.perf_counter()
            show(text(last - start))

        yield write
