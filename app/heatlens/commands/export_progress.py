"""How far an export is: a line that is rewritten for people, a line a frame for programs."""

import io
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import TextIO

from heatlens.commands.say import say, shows_progress, tell
from heatlens.errors import HeatlensError
from heatlens.export.plan import ExportPlan
from heatlens.export.run import FrameDone

Tell = Callable[[FrameDone], None]
_WIPE = "\r\x1b[K"


class Tally:
    """The progress through `count` frames, and the time left at this pace."""

    def __init__(self, count: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.count = count
        self.written: list[int] = []
        self.kept = 0
        self._clock = clock
        self._start_s = clock()

    def add(self, done: FrameDone) -> None:
        """Count one more frame. Time counts from the first that had to be rendered."""
        if done.was_there:
            self.kept += 1
            if not self.written:
                self._start_s = self._clock()
        else:
            self.written.append(done.frame)

    @property
    def done(self) -> int:
        """Frames that are in their files."""
        return len(self.written) + self.kept

    @property
    def left_s(self) -> float | None:
        """Seconds to the end; None before there is a pace."""
        if not self.written:
            return None
        pace_s = (self._clock() - self._start_s) / len(self.written)
        return pace_s * (self.count - self.done)


def progress_of(kind: str, plan: ExportPlan) -> AbstractContextManager[Tell]:
    """Return what to call for each frame; after a good end it prints what was exported.

    `kind` is terminal, json or openjd.
    """
    tally = Tally(len(plan.frames))
    return {"terminal": _for_people, "json": _for_programs, "openjd": _for_farm}[kind](plan, tally)


@contextmanager
def _for_people(plan: ExportPlan, tally: Tally) -> Iterator[Tell]:
    with _terminal() as out:

        def show(frame: int) -> None:
            out.write(f"{_WIPE}heatlens: frame {frame}, {progress_text(tally)}")
            out.flush()

        def tell(done: FrameDone) -> None:
            tally.add(done)
            show(done.frame)

        show(plan.frames[0].frame)  # the first one may take long
        yield tell
    kept = f", {tally.kept} were finished before" if tally.kept else ""
    say(f"{_frames(len(tally.written))} written{kept}.")
    _print(str(plan.job.output.pattern))


@contextmanager
def _for_programs(plan: ExportPlan, tally: Tally) -> Iterator[Tell]:
    """Print JSON, a line for the beginning, each frame and the end."""
    output = str(plan.job.output.pattern)
    _say(event="begin", output=output, frames=tally.count)

    def tell(done: FrameDone) -> None:
        tally.add(done)
        state = "finished before" if done.was_there else "written"
        left_s = None if tally.left_s is None else round(tally.left_s, 1)
        of = {"done": tally.done, "frames": tally.count, "seconds_left": left_s}
        _say(event="frame", frame=done.frame, path=str(done.path), state=state, **of)

    yield tell
    _say(event="end", output=output, written=len(tally.written), finished_before=tally.kept)


@contextmanager
def _for_farm(plan: ExportPlan, tally: Tally) -> Iterator[Tell]:
    """Open Job Description: progress in per cent, and the reason of a failure."""

    def tell(done: FrameDone) -> None:
        tally.add(done)
        _print(f"openjd_status: frame {done.frame}, {tally.done} of {tally.count}")
        _print(f"openjd_progress: {100 * tally.done / tally.count:.1f}")

    try:
        yield tell
    except HeatlensError as error:
        _print(f"openjd_fail: {error}")
        raise
    _print(str(plan.job.output.pattern))


def progress_text(tally: Tally) -> str:
    """Return "12 of 100 done, 1 min 20 s left"."""
    left = "" if tally.left_s is None else f", {time_text(tally.left_s)} left"
    return f"{tally.done} of {tally.count} done{left}"


def time_text(seconds: float) -> str:
    """Return seconds in words, with as much precision as an estimate has."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"


def _frames(count: int) -> str:
    return "1 frame" if count == 1 else f"{count} frames"


@contextmanager
def _terminal() -> Iterator[TextIO]:
    """Yield stderr, and clear the line at the end; yield nothing visible where it is no terminal.

    It has a descriptor of its own: while files are read on other threads, Python's stderr is
    replaced at times, to keep the EXR library's messages off it.
    """
    if not shows_progress(sys.stderr):
        yield io.StringIO()
        return
    with open(os.dup(sys.stderr.fileno()), "w") as out:
        try:
            yield out
        finally:
            out.write(_WIPE)


def _say(**entry: object) -> None:
    _print(json.dumps(entry))


def _print(line: str) -> None:
    tell(line)
