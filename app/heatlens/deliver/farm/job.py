"""The description of an export for several machines, from which each engine makes its own text.

A word of a command line is a tuple of texts, places and FRAMES. Every farm engine replaces places
and FRAMES by its own names, since paths differ between machines, and quotes texts by its own rules.
"""

import math
import subprocess
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Literal

from heatlens.core.base.errors import InputError
from heatlens.core.base.memory import wait_for_peak_bytes
from heatlens.core.base.own_command import own_command
from heatlens.core.base.stopping import temporary_folder
from heatlens.deliver.farm.events import Event, event_in
from heatlens.media.sequence.names import frames_text

_GIB = 1 << 30
_HEADROOM = 1.25  # other frames may need more memory than the measured one
_TASK_S = 60.0  # long compared with the start of a process, short enough to repeat
_DEFAULT_TASK_FRAMES = 10  # frames of a task if no frame was measured
TextForm = Callable[[str], str]


class _Frames(Enum):
    FRAMES = "frames"


FRAMES = _Frames.FRAMES  # stands for the frames of a task


@dataclass(frozen=True)
class Place:
    """A file or folder whose path may differ between machines."""

    name: str
    path: Path
    kind: Literal["FILE", "DIRECTORY"]
    flow: Literal["IN", "OUT"]


Word = tuple[str | Place | _Frames, ...]


@dataclass(frozen=True)
class Needs:
    """The resources that a task needs: memory in GiB, processors and GPUs."""

    memory_gib: int | None = None  # None if unknown
    processors: int = 2
    gpus: int = 0


@dataclass(frozen=True)
class Step:
    """Tasks that have one command line.

    words  those after `heatlens`; FRAMES stands for the frames of a task
    parts  the frames of each task; () for a single task that names none
    """

    name: str
    words: tuple[Word, ...]
    parts: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """The number of tasks in this step."""
        return len(self.parts) or 1


@dataclass(frozen=True)
class FarmJob:
    """An export of one or several shots in tasks.

    steps   the frames of each shot, in any order
    last    a task that waits for them: it makes movies of the frames, or runs a command
    inputs  every file that is read
    """

    name: str
    places: tuple[Place, ...]
    steps: tuple[Step, ...]
    last: Step | None
    needs: Needs
    inputs: tuple[Path, ...]

    @property
    def count(self) -> int:
        """The number of tasks in all steps, including the last one."""
        return sum(step.count for step in (*self.steps, *([self.last] if self.last else [])))

    def split_steps(self, most: int) -> tuple[Step, ...]:
        """Return the steps; a step of more than `most` tasks is split into several."""
        return tuple(
            replace(
                step,
                name=step.name if begin == 0 else f"{step.name} {begin // most + 1}",
                parts=parts,
            )
            for step in self.steps
            for begin in range(0, step.count, most)
            for parts in [step.parts[begin : begin + most]]
        )


@dataclass(frozen=True)
class MeasuredCost:
    """The cost of the first frames on this machine."""

    start_s: float
    frame_s: float
    memory_bytes: int

    @property
    def memory_gib(self) -> int:
        """The memory that a task should ask for."""
        return math.ceil(_HEADROOM * self.memory_bytes / _GIB)

    @property
    def frames_of_a_task(self) -> int:
        """How many frames take about a minute."""
        return max(1, int((_TASK_S - self.start_s) / max(self.frame_s, 1e-3)))


def group_frames(
    frames: Sequence[int], chunk: int | None, measured: MeasuredCost | None = None
) -> tuple[str, ...]:
    """Return `frames` in groups, in the form of `parse_frames`: 1001-1019x2.

    A group has `chunk` frames, by default as many as take about a minute. Raises InputError for
    empty groups.
    """
    if chunk is not None and chunk < 1:
        raise InputError(f"--chunk must be 1 frame or more, got {chunk}.")
    size = chunk or (_DEFAULT_TASK_FRAMES if measured is None else measured.frames_of_a_task)
    return tuple(frames_text(frames[begin : begin + size]) for begin in range(0, len(frames), size))


def path_word(places: Iterable[Place], text: str, path: Path) -> Word:
    """Return a word that joins `text` and `path`; the path is relative to its place, if any."""
    for place in sorted(places, key=lambda place: -len(place.path.parts)):
        prefix = (text, place) if text else (place,)
        if place.path == path:
            return prefix
        if place.kind == "DIRECTORY" and place.path in path.parents:
            return (*prefix, f"/{path.relative_to(place.path).as_posix()}")
    return (f"{text}{path}",)


def word_text(word: Word, place: Callable[[Place], str], frames: str, text: TextForm = str) -> str:
    """Return a word as one text, with an engine's own forms of places, frames and plain text."""
    texts = (
        text(it) if isinstance(it, str) else place(it) if isinstance(it, Place) else frames
        for it in word
    )
    return "".join(texts)


def command_words(words: Iterable[Word], frames: str = "") -> list[str]:
    """Return words as texts for a command line on this machine."""
    return [word_text(word, lambda place: str(place.path), frames) for word in words]


def topmost_folders(folders: Iterable[Path]) -> tuple[Path, ...]:
    """Return the folders that are inside none of the others."""
    distinct = dict.fromkeys(folders)
    return tuple(folder for folder in distinct if not distinct.keys() & set(folder.parents))


# A farm must know before it starts how long a task takes and how much memory it needs. Three
# frames are rendered, since the first one contains the start of the process and the builds of the
# driver. A frame is reported once the next one is rendered, and the last one as soon as it is
# written, so the time between the first two reports is that of the third frame.
def measure_first_frames(job: FarmJob, name: str, frames: Sequence[int]) -> MeasuredCost:
    """Render the first three of `frames` to a temporary folder; return their time and memory.

    `name` is that of the output files. Raises InputError with the reason if the rendering fails.
    """
    with temporary_folder() as folder:
        words = (
            *command_words(job.steps[0].words, frames_text(frames[:3])),
            f"--output={folder / name}",
        )
        command = own_command(*words, "--progress=json")
        start_s = time.monotonic()
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        ) as process:
            assert process.stdout is not None
            rows = ((time.monotonic() - start_s, event_in(row)) for row in process.stdout)
            events = [(at_s, event) for at_s, event in rows if event is not None]
            memory_bytes = wait_for_peak_bytes(process)
    return cost_of_run(events, memory_bytes)


def cost_of_run(events: Sequence[tuple[float, Event]], memory_bytes: int) -> MeasuredCost:
    """Return the cost of a run from its events and their times since its start.

    Raises InputError if the run has finished no frame, or has failed.
    """
    frame_ends_s = [at_s for at_s, event in events if event["event"] == "frame"]
    last_event = events[-1][1] if events else {}
    if not frame_ends_s or last_event["event"] != "end":
        reason = last_event.get("message", "it was killed, as systems do when memory runs out")
        raise InputError(f"The first frame, which shows what a task needs, failed: {reason}")
    if len(frame_ends_s) < 3:  # the time holds the start, which is not known by itself
        return MeasuredCost(0.0, frame_ends_s[-1] / len(frame_ends_s), memory_bytes)
    frame_s = frame_ends_s[1] - frame_ends_s[0]
    return MeasuredCost(max(frame_ends_s[0] - 2 * frame_s, 0.0), frame_s, memory_bytes)
