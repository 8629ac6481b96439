"""A reel: shots in the order in which they are cut, each a file of its own."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import (
    COUNT_MOST,
    FRAMES_PER_SECOND,
    FrameRange,
    check_frames_per_second,
)
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.shot import Shot

EDIT_SUFFIXES = (".otio", ".otioz", ".edl", ".aaf", ".xml")
SHOT_FIELD = "{shot}"  # stands for the name of the shot in the name of a file
_ROUNDING = 1e-6  # frames by which rounding may make a sum of times too small
_IN_FILE_NAMES = re.compile(r"[^\w.+-]+")


@dataclass(frozen=True)
class EditOptions:
    """How to read an edit.

    folders  where to look for media that are not where the edit says, or that it names only
    rate     frames per second of an EDL, which does not tell them; None for 24
    """

    folders: tuple[Path, ...] = ()
    rate: float | None = None


@dataclass(frozen=True)
class Retime:
    """How a cut plays a shot that it does not show frame by frame.

    start  the frame of the source that is shown first, as a time in frames
    speed  frames of the source for each frame of the cut: 0 holds one, below 0 plays backwards
    count  frames of the cut
    step   frames of the source from one that exists to the next
    """

    start: float
    speed: float
    count: int
    step: int = 1

    def __post_init__(self) -> None:
        if not (math.isfinite(self.start) and math.isfinite(self.speed)):
            raise InputError(
                f"A change of speed (retime) needs a start and a speed that are numbers, got "
                f"{self.start:g} and {self.speed:g}."
            )
        check_cut_length(self.count, "A shot")
        if self.count < 1 or self.step < 1:
            raise InputError(
                "A change of speed (retime) has a count of frames and a step, both 1 or more, got "
                f"{self.count} and {self.step}."
            )

    def source_frames(self, first_frame: int) -> tuple[int, ...]:
        """Return the frame of the source for each frame of the cut.

        `first_frame` is a frame of the source that exists; others exist every `step` frames.
        """
        times = (self.start + index * self.speed for index in range(self.count))
        frames = (math.floor(time + _ROUNDING) for time in times)
        return tuple(
            first_frame + (frame - first_frame) // self.step * self.step for frame in frames
        )


@dataclass(frozen=True)
class ReelShot:
    """A shot of a reel.

    name     what the reel calls it; part of the names of its files
    source   a shot file, or what the source of a shot can be: plates, a scene, a movie; "" if the
             media of the edit are missing
    frames   those of the cut; None for those from in to out, or all
    notes    sentences on what the edit says and a shot cannot hold, and on what is missing
    marks    focus marks that the edit holds, each as NAME=DISTANCE
    grade    of the edit; None if it has none
    retime   how the cut plays the frames; None for each of them once, in order
    """

    name: str
    source: str
    frames: FrameRange | None = None
    notes: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()
    grade: Grade | None = None
    retime: Retime | None = None

    def __post_init__(self) -> None:
        if self.retime is not None and self.frames is None:
            raise InputError(
                f"The shot {self.name} changes its speed (retime), so it needs its frames: give "
                "frames, as in 1001-1024."
            )
        if not self.name or _IN_FILE_NAMES.search(self.name):
            raise InputError(
                "The name of a shot in a reel has letters, digits and _ . + - alone, not "
                f"{self.name!r}."
            )

    @property
    def source_frames(self) -> tuple[int, ...]:
        """The frame of the source for each frame of the cut; () if the source decides."""
        if self.frames is None:
            return ()
        return self.retime.source_frames(self.frames.first) if self.retime else tuple(self.frames)

    @property
    def count(self) -> int:
        """The frames of the cut; 0 if the source decides."""
        return 0 if self.frames is None else (self.retime or self.frames).count

    @property
    def exported_frames(self) -> str | None:
        """The frames that are made as files, as `--frames` takes them; None if all are."""
        step = "" if self.retime is None or self.retime.step == 1 else f"x{self.retime.step}"
        return None if self.frames is None else f"{self.frames}{step}"

    def cut_shot(self, shot: Shot) -> Shot:
        """Return `shot` with the frames of the cut, and with the cut's grade if it has none."""
        return replace(shot, in_out=self.frames or shot.in_out, grade=shot.grade or self.grade)


@dataclass(frozen=True)
class Reel:
    """Shots in order; no two have the same name.

    start_timecode  of the first frame of the cut; None if it is not known
    gaps            empty frames before shots, by the number of the shot from 0; those after the
                    last one have the number of shots
    """

    name: str
    shots: tuple[ReelShot, ...]
    frames_per_second: float = FRAMES_PER_SECOND
    start_timecode: str | None = None
    gaps: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        check_frames_per_second(self.frames_per_second)
        if not self.shots:
            raise InputError(f"The reel {self.name} has no shot: give it at least one.")
        names: set[str] = set()
        for shot in self.shots:
            if shot.name in names:
                raise InputError(f"Two shots of the reel are called {shot.name}: rename one.")
            names.add(shot.name)
        for number, frames in self.gaps:
            if frames < 1 or not 0 <= number <= len(self.shots):
                raise InputError(f"A gap of a reel has at least one frame, got {frames}.")
        length = sum(shot.count for shot in self.shots) + sum(count for _, count in self.gaps)
        check_cut_length(length, f"The reel {self.name}")

    def with_shots(self, shots: Iterable[ReelShot]) -> "Reel":
        """Return the reel with other shots, or with its own in another order.

        Empty frames before a shot stay before it, and those after the last one at the end. A new
        shot whose name is taken gets a number. Raises InputError if no shot is left.
        """
        new_shots, gaps = with_unique_names(tuple(shots)), dict(self.gaps)
        gap_before = {shot.name: gaps.get(number, 0) for number, shot in enumerate(self.shots)}
        lengths = [gap_before.get(shot.name, 0) for shot in new_shots]
        lengths.append(gaps.get(len(self.shots), 0))
        new_gaps = tuple((number, length) for number, length in enumerate(lengths) if length)
        return replace(self, shots=new_shots, gaps=new_gaps)

    @property
    def missing_shots(self) -> tuple[ReelShot, ...]:
        """The shots whose media are missing."""
        return tuple(shot for shot in self.shots if not shot.source)


def check_cut_length(frames: float, subject: str) -> None:
    """Raise InputError if a cut would have more frames than fit in memory, before they are made."""
    if not frames <= COUNT_MOST:
        raise InputError(
            f"{subject} has {frames:,.0f} frames with its gaps; a cut has at most {COUNT_MOST:,}."
        )


def with_unique_names(shots: tuple[ReelShot, ...]) -> tuple[ReelShot, ...]:
    """Return the shots with a number after names that were used before: sh010, sh010_2."""
    used_names: set[str] = set()
    renamed_shots = []
    for shot in shots:
        name, number = shot.name, 1
        while name in used_names:
            number += 1
            name = f"{shot.name}_{number}"
        used_names.add(name)
        renamed_shots.append(replace(shot, name=name))
    return tuple(renamed_shots)


def shot_name(text: str) -> str:
    """Return a name for a shot that files can have: of letters, digits and . + - _ alone."""
    return _IN_FILE_NAMES.sub("_", text.strip()).strip("._") or "shot"


@dataclass(frozen=True)
class CutFocus:
    """The focus of a shot where the cut begins and ends, in m; None if it is not known."""

    first_m: float | None = None
    last_m: float | None = None
