"""A frame's time where it must not take too long."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import moderngl

from heatlens.measure.bench.frames import Frame, run_seconds

Say = Callable[[str], None]
LIMIT_S = 20.0  # what one cell of a table may take, all its frames together


@dataclass(frozen=True, eq=False)
class Timed:
    """Median milliseconds of a frame, and its picture, which the next frame overwrites."""

    ms: float
    picture: moderngl.Texture


def bounded(frame: Frame, runs: int, limit_s: float) -> Timed | None:
    """Median of `runs` frames, of fewer or of the warm-up alone where time is short, or None."""
    end = time.monotonic() + limit_s
    first = _first(frame, end)
    if first is None:
        return None
    pictures: list[moderngl.Texture] = [first.picture]
    seconds: list[float] = []
    while len(seconds) < runs and time.monotonic() + 1e-3 * first.ms < end:
        seconds.append(run_seconds(frame.renderer.ctx, lambda: pictures.append(frame.render())))
    middle = sorted(seconds)[len(seconds) // 2] if seconds else 1e-3 * first.ms
    return Timed(1e3 * middle, pictures[-1])


class Patience:
    """Gives up on whoever was too slow once, and says so once."""

    def __init__(self, runs: int, say: Say) -> None:
        self._runs, self._say = runs, say
        self._too_slow: set[str] = set()

    def timed(self, name: str, make_frame: Callable[[], Frame], where: str) -> Timed | None:
        """A frame of `name`, made only if it is to be rendered; `where` is said beside it."""
        if name in self._too_slow:
            return None
        self._say(f"{name}, {where}")
        timed = bounded(make_frame(), self._runs, LIMIT_S)
        if timed is None:
            self._say(f"{name} skipped from here on: a frame takes more than {LIMIT_S:g} s")
            self._too_slow.add(name)
        return timed


def _first(frame: Frame, end: float) -> Timed | None:
    """A frame step by step, given up after the step in which `end` passes."""
    frame.renderer.ctx.finish()
    start = time.monotonic()
    steps = frame.steps()
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return Timed(1e3 * (time.monotonic() - start), done.value)
        frame.renderer.ctx.finish()
        if time.monotonic() > end:
            steps.close()
            return None
