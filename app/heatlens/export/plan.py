"""Which plate each frame is made of, which file it becomes, and by what that is known again."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.errors import InputError
from heatlens.export.fingerprint import fingerprint_of, fingerprint_of_movie
from heatlens.export.job import ExportJob
from heatlens.export.output import check_names
from heatlens.image.sequence import Sequence, find_sequence, stamp_of
from heatlens.image.sequence_names import frames_text, parse_frames
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot


@dataclass(frozen=True)
class PlannedFrame:
    """A frame before it is rendered.

    plate_frame  number of the plate's file that is read for it
    is_black     nothing of that file is seen but its size
    fingerprint  of all that decides the pixels; it is kept in the file
    """

    frame: int
    plate_frame: int
    is_black: bool
    lens: Lens
    path: Path
    fingerprint: str


@dataclass(frozen=True)
class ExportPlan:
    """All frames of a job, and the sequence of plates."""

    job: ExportJob
    sequence: Sequence
    frames: tuple[PlannedFrame, ...]

    @property
    def movie_fingerprint(self) -> str:
        """Of all frames in one file."""
        rate = self.job.shot.frames_per_second
        return fingerprint_of_movie([frame.fingerprint for frame in self.frames], rate)


def frames_of(shot: Shot, text: str | None) -> tuple[int, ...]:
    """The frames in `text`, such as 1001-1100x2; None: those from in to out, else all there are.

    Raises InputError for what are no frames, and where the plate cannot be found.
    """
    if text is not None:
        return parse_frames(text)
    sequence = _sequence_of(shot)
    if shot.played is None:
        return sequence.frames
    if sequence.frame_range is None:
        return tuple(shot.played)
    return tuple(frame for frame in sequence.frames if frame in shot.played)


def planned(job: ExportJob) -> ExportPlan:
    """What will be done; files are looked at, but none is read or written.

    Raises InputError where a plate is missing and the job does not say what stands in for it, a
    frame would be written over its own plate, or the lens cannot be.
    """
    sequence = _sequence_of(job.shot)
    if job.missing == "stop":
        _check_none_missing(job, sequence)
    check_names(job.output, job.frames)
    plan = ExportPlan(job, sequence, tuple(_planned(job, sequence, f) for f in job.frames))
    _check_plates_stay(plan)
    return plan


def _sequence_of(shot: Shot) -> Sequence:
    if shot.source is None:
        raise InputError("The shot is of no plate: name its files with --plate.")
    return find_sequence(shot.source)


def _is_still(job: ExportJob, sequence: Sequence) -> bool:
    """One file, which is there at every frame."""
    return not sequence.form.padding or (sequence.is_single and job.shot.frames is None)


def _check_none_missing(job: ExportJob, sequence: Sequence) -> None:
    if _is_still(job, sequence):
        return
    missing = [frame for frame in job.frames if not sequence.has(frame)]
    if missing:
        raise InputError(
            f"{sequence.pattern} has no file for {len(missing)} of {len(job.frames)} frames: "
            f"{frames_text(missing)}. --missing hold puts the frame before in their place, "
            "--missing black nothing."
        )


def _planned(job: ExportJob, sequence: Sequence, frame: int) -> PlannedFrame:
    lens = job.shot.lens_at(frame)
    if _is_still(job, sequence):
        plate_frame, is_black = sequence.first, False
    else:
        held = sequence.shown_frame(frame, "hold")
        assert held is not None  # a sequence that was found has a file
        plate_frame, is_black = held, job.missing == "black" and held != frame
    stamp = stamp_of(sequence.path_at(plate_frame))
    mark = fingerprint_of(job, frame, lens, stamp, is_black)
    return PlannedFrame(frame, plate_frame, is_black, lens, job.output.path_at(frame), mark)


def plates_needed(plan: ExportPlan, frames: tuple[PlannedFrame, ...]) -> Sequence:
    """The sequence of the plates of `frames` alone."""
    needed = tuple(sorted({frame.plate_frame for frame in frames}))
    return replace(plan.sequence, frames=needed, present=needed)


def _check_plates_stay(plan: ExportPlan) -> None:
    plates = {os.path.realpath(plan.sequence.path_at(frame.plate_frame)) for frame in plan.frames}
    for frame in plan.frames:
        if os.path.realpath(frame.path) in plates:
            raise InputError(f"{frame.path} is a plate itself: give another name for the output.")
