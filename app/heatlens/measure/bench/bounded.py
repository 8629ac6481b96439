"""Measure the time of a frame within a time limit."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import moderngl

from heatlens.measure.bench.frames import Frame, run_seconds
from heatlens.render import drained

Say = Callable[[str], None]
LIMIT_S = 20.0  # time limit for one cell of a table, with all its frames


@dataclass(frozen=True, eq=False)
class Timed:
    """The median milliseconds of a frame, and its picture, which the next frame overwrites."""

    ms: float
    picture: moderngl.Texture


def bounded(frame: Frame, runs: int, limit_s: float) -> Timed | None:
    """Return the median of `runs` frames, or None if even the warm-up exceeds `limit_s`.

    If time is short, the median is of fewer frames or of the warm-up alone.
    """
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
    """Skips methods that have been too slow once, and reports this once."""

    def __init__(self, runs: int, say: Say) -> None:
        self._runs, self._say = runs, say
        self._too_slow: set[str] = set()

    def timed(self, name: str, make_frame: Callable[[], Frame], where: str) -> Timed | None:
        """Time a frame of `name`, or return None once it has been too slow.

        `make_frame` is called only if the frame is to be rendered. `where` is named in the message.
        """
        if name in self._too_slow:
            return None
        self._say(f"{name}, {where}")
        timed = bounded(make_frame(), self._runs, LIMIT_S)
        if timed is None:
            self._say(f"{name} skipped from here on: a frame takes more than {LIMIT_S:g} s")
            self._too_slow.add(name)
        return timed


def _first(frame: Frame, end: float) -> Timed | None:
    """Render a frame step by step; stop after the first step that ends later than `end`."""
    frame.renderer.ctx.finish()
    start = time.monotonic()

    def check(_: str) -> None:
        frame.renderer.ctx.finish()
        if time.monotonic() > end:
            raise _TooSlowError

    steps = frame.steps()
    try:
        picture = drained(steps, check)
    except _TooSlowError:
        steps.close()
        return None
    return Timed(1e3 * (time.monotonic() - start), picture)


class _TooSlowError(Exception):
    """A frame has exceeded its time limit."""
