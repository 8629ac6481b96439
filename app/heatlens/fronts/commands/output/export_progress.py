"""Show the progress of an export: one rewritten line for people, a line per frame for programs."""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING

from heatlens.core.base.errors import HeatlensError
from heatlens.deliver.export.plan import ExportPlan
from heatlens.fronts.commands.output.progress_line import progress_line, time_text
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.media.sequence.names import frames_text

if TYPE_CHECKING:  # other commands report failures with this file, and export nothing
    from heatlens.deliver.export.run import FrameDone

ReportFrame = Callable[["FrameDone"], None]


class Tally:
    """The progress through `count` frames, and the estimated time left."""

    def __init__(self, count: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.count = count
        self.written: list[int] = []
        self.finished_before = 0
        self.surfaces_lost = ""  # the message of the first frame that has one
        self.pace = ""  # message on the time of the quality final, of the newest frame that has one
        self._remarks: dict[str, tuple[str, list[int]]] = {}  # by key: a sentence and its frames
        self._clock = clock
        self._start_s = clock()

    def add(self, done: "FrameDone") -> None:
        """Count a frame and its remarks; time runs from the first frame that had to be rendered."""
        self.surfaces_lost = self.surfaces_lost or _surfaces_lost_text(done)
        self.pace = done.pace or self.pace
        for remark in done.remarks:
            self._remarks.setdefault(remark.key, (remark.sentence, []))[1].append(done.frame)
        if done.was_there:
            self.finished_before += 1
            if not self.written:
                self._start_s = self._clock()
        else:
            self.written.append(done.frame)

    @property
    def closing_messages(self) -> list[str]:
        """Messages for the end: each remark once, with its frames, lost surfaces, and the pace."""
        remarks = [
            f"{_frames_of_remark(frames)}: {sentence}"
            for sentence, frames in self._remarks.values()
        ]
        pace = self.pace and f"{self.pace}."
        return [*remarks, *filter(None, [self.surfaces_lost, pace])]

    @property
    def done_count(self) -> int:
        """Number of frames whose files are complete."""
        return len(self.written) + self.finished_before

    @property
    def left_s(self) -> float | None:
        """Estimated seconds left; None before the first rendered frame."""
        if not self.written:
            return None
        pace_s = (self._clock() - self._start_s) / len(self.written)
        return pace_s * (self.count - self.done_count)


def progress_of(kind: str, plan: ExportPlan) -> AbstractContextManager[ReportFrame]:
    """Return a context with a function to call for each frame; it prints a summary on success.

    `kind` is terminal, json or openjd.
    """
    tally = Tally(len(plan.frames))
    return {"terminal": _report_to_terminal, "json": _report_as_json, "openjd": _report_to_farm}[
        kind
    ](plan, tally)


@contextmanager
def _report_to_terminal(plan: ExportPlan, tally: Tally) -> Iterator[ReportFrame]:
    """Show the progress on one line; at the end, print what was written and the output."""
    with progress_line() as show:

        def report(done: "FrameDone") -> None:
            tally.add(done)
            show(f"frame {done.frame}, {progress_text(tally)}")

        show(f"frame {plan.frames[0].frame}, {progress_text(tally)}")  # it may take long
        yield report
    print_messages(*tally.closing_messages)
    verb = "was" if tally.finished_before == 1 else "were"
    finished_text = (
        f", {tally.finished_before} {verb} finished before" if tally.finished_before else ""
    )
    print_messages(f"{_frame_count_text(len(tally.written))} written{finished_text}.")
    _print_line(str(plan.job.output.pattern))


@contextmanager
def _report_as_json(plan: ExportPlan, tally: Tally) -> Iterator[ReportFrame]:
    """Print a line of JSON at the beginning, for each frame and at the end."""
    output = str(plan.job.output.pattern)
    _print_json(event="begin", output=output, frames=tally.count)

    def report(done: "FrameDone") -> None:
        """Print a finished frame as one line of JSON."""
        tally.add(done)
        state = "finished before" if done.was_there else "written"
        left_s = None if tally.left_s is None else round(tally.left_s, 1)
        optional_entries = {
            name: it for name, it in (("worker", done.maker), ("pace", done.pace)) if it
        }
        entries = {
            **optional_entries,
            "done": tally.done_count,
            "frames": tally.count,
            "seconds_left": left_s,
        }
        _print_json(event="frame", frame=done.frame, path=str(done.path), state=state, **entries)

    # Only this report prints on standard output: drivers and libraries print on standard error.
    yield report
    notes = {"told": " ".join(tally.closing_messages)} if tally.closing_messages else {}
    notes |= {"pace": tally.pace} if tally.pace else {}
    counts = {"written": len(tally.written), "finished_before": tally.finished_before}
    _print_json(event="end", output=output, **counts, **notes)


@contextmanager
def _report_to_farm(plan: ExportPlan, tally: Tally) -> Iterator[ReportFrame]:
    """Print messages of Open Job Description: the progress in percent."""

    def report(done: "FrameDone") -> None:
        tally.add(done)
        _print_line(f"openjd_status: frame {done.frame}, {tally.done_count} of {tally.count}")
        _print_line(f"openjd_progress: {100 * tally.done_count / tally.count:.1f}")

    yield report
    print_messages(*tally.closing_messages)
    _print_line(str(plan.job.output.pattern))


@contextmanager
def report_failure(kind: str) -> Iterator[None]:
    """Print the reason if the block fails, for the programs that read the progress.

    `kind` is as in `progress_of`; on a terminal, the reason is printed to stderr. A command that is
    stopped is killed and prints nothing here; only its exit code shows that.
    """
    try:
        yield
    except HeatlensError as error:
        if kind == "json":
            _print_json(event="failed", message=str(error))
        elif kind == "openjd":
            _print_line(f"openjd_fail: {error}")
        raise


def _surfaces_lost_text(done: "FrameDone") -> str:
    return f"Frame {done.frame}: {done.surfaces_lost}" if done.surfaces_lost else ""


def _frames_of_remark(frames: list[int]) -> str:
    """Return the frames of a remark as text; its sentence has the numbers of the first one."""
    first, *others = frames
    others_text = f", and likewise {frames_text(others)}" if others else ""
    return f"Frame {first}{others_text}"


def progress_text(tally: Tally) -> str:
    """Return "12 of 100 done, 1 min 20 s left; quality final: ..."."""
    left = "" if tally.left_s is None else f", {time_text(tally.left_s)} left"
    return f"{tally.done_count} of {tally.count} done{left}{tally.pace and f'; {tally.pace}'}"


def _frame_count_text(count: int) -> str:
    return "1 frame" if count == 1 else f"{count} frames"


def _print_json(**entry: object) -> None:
    _print_line(json.dumps(entry))


def _print_line(line: str) -> None:
    print_result(line)
