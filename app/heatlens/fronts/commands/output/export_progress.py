"""Show the progress of an export: one rewritten line for people, a line per frame for programs."""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from heatlens.core.base.errors import HeatlensError
from heatlens.deliver.export.plan import ExportPlan
from heatlens.deliver.export.run import FrameDone
from heatlens.fronts.commands.output.progress_line import progress_line, time_text
from heatlens.fronts.commands.output.say import say, tell
from heatlens.media.sequence.names import frames_text

Tell = Callable[[FrameDone], None]


class Tally:
    """The progress through `count` frames, and the estimated time left."""

    def __init__(self, count: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.count = count
        self.written: list[int] = []
        self.kept = 0
        self.surfaces_lost = ""  # a sentence, of the first frame that has one
        self.pace = ""  # words on the time of the quality final, of the newest frame that has some
        self._remarks: dict[
            str, tuple[str, list[int]]
        ] = {}  # a sentence with its frames, by its key
        self._clock = clock
        self._start_s = clock()

    def add(self, done: FrameDone) -> None:
        """Count a frame. Time is measured from the first frame that had to be rendered."""
        self.surfaces_lost = self.surfaces_lost or _lost_words(done)
        self.pace = done.pace or self.pace
        for remark in done.remarks:
            self._remarks.setdefault(remark.key, (remark.sentence, []))[1].append(done.frame)
        if done.was_there:
            self.kept += 1
            if not self.written:
                self._start_s = self._clock()
        else:
            self.written.append(done.frame)

    @property
    def told(self) -> list[str]:
        """Sentences for the end: each remark once, with its frames, lost surfaces, and the pace."""
        remarks = [f"{_frame_words(at)}: {words}" for words, at in self._remarks.values()]
        pace = self.pace and f"{self.pace}."
        return [*remarks, *filter(None, [self.surfaces_lost, pace])]

    @property
    def done(self) -> int:
        """Number of frames whose files are complete."""
        return len(self.written) + self.kept

    @property
    def left_s(self) -> float | None:
        """Estimated seconds left; None before the first rendered frame."""
        if not self.written:
            return None
        pace_s = (self._clock() - self._start_s) / len(self.written)
        return pace_s * (self.count - self.done)


def progress_of(kind: str, plan: ExportPlan) -> AbstractContextManager[Tell]:
    """Return a context with a function to call for each frame; it prints a summary on success.

    `kind` is terminal, json or openjd.
    """
    tally = Tally(len(plan.frames))
    return {"terminal": _for_people, "json": _for_programs, "openjd": _for_farm}[kind](plan, tally)


@contextmanager
def _for_people(plan: ExportPlan, tally: Tally) -> Iterator[Tell]:
    with progress_line() as show:

        def tell(done: FrameDone) -> None:
            tally.add(done)
            show(f"frame {done.frame}, {progress_text(tally)}")

        show(f"frame {plan.frames[0].frame}, {progress_text(tally)}")  # it may take long
        yield tell
    say(*tally.told)
    were = "was" if tally.kept == 1 else "were"
    kept = f", {tally.kept} {were} finished before" if tally.kept else ""
    say(f"{_frames(len(tally.written))} written{kept}.")
    _print(str(plan.job.output.pattern))


@contextmanager
def _for_programs(plan: ExportPlan, tally: Tally) -> Iterator[Tell]:
    """Print a line of JSON at the beginning, for each frame and at the end."""
    output = str(plan.job.output.pattern)
    _say(event="begin", output=output, frames=tally.count)

    def tell(done: FrameDone) -> None:
        tally.add(done)
        state = "finished before" if done.was_there else "written"
        left_s = None if tally.left_s is None else round(tally.left_s, 1)
        more = {name: it for name, it in (("worker", done.maker), ("pace", done.pace)) if it}
        of = {**more, "done": tally.done, "frames": tally.count, "seconds_left": left_s}
        _say(event="frame", frame=done.frame, path=str(done.path), state=state, **of)

    # Drivers and libraries print on standard error, since a stray line among these was a fault.
    yield tell
    notes = {"told": " ".join(tally.told)} if tally.told else {}
    notes |= {"pace": tally.pace} if tally.pace else {}
    counts = {"written": len(tally.written), "finished_before": tally.kept}
    _say(event="end", output=output, **counts, **notes)


@contextmanager
def _for_farm(plan: ExportPlan, tally: Tally) -> Iterator[Tell]:
    """Print messages of Open Job Description: the progress in percent."""

    def tell(done: FrameDone) -> None:
        tally.add(done)
        _print(f"openjd_status: frame {done.frame}, {tally.done} of {tally.count}")
        _print(f"openjd_progress: {100 * tally.done / tally.count:.1f}")

    yield tell
    say(*tally.told)
    _print(str(plan.job.output.pattern))


@contextmanager
def failure_reported(kind: str) -> Iterator[None]:
    """Print the reason if the block fails, for the programs that read the progress.

    `kind` is that of `progress_of`; people read the reason on stderr. A command that is stopped is
    killed and prints nothing here: its exit code tells.
    """
    try:
        yield
    except HeatlensError as error:
        if kind == "json":
            _say(event="failed", message=str(error))
        elif kind == "openjd":
            _print(f"openjd_fail: {error}")
        raise


def _lost_words(done: FrameDone) -> str:
    return f"Frame {done.frame}: {done.surfaces_lost}" if done.surfaces_lost else ""


def _frame_words(frames: list[int]) -> str:
    """Return the frames that a sentence is about, the first of which gave its numbers."""
    first, *others = frames
    also = f", and likewise {frames_text(others)}" if others else ""
    return f"Frame {first}{also}"


def progress_text(tally: Tally) -> str:
    """Return "12 of 100 done, 1 min 20 s left; quality final: ..."."""
    left = "" if tally.left_s is None else f", {time_text(tally.left_s)} left"
    return f"{tally.done} of {tally.count} done{left}{tally.pace and f'; {tally.pace}'}"


def _frames(count: int) -> str:
    return "1 frame" if count == 1 else f"{count} frames"


def _say(**entry: object) -> None:
    _print(json.dumps(entry))


def _print(line: str) -> None:
    tell(line)
