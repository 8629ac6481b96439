"""The plan of an export: what each frame is made of, its file, and its fingerprint."""

import os
from dataclasses import dataclass
from pathlib import Path

from heatlens.errors import InputError
from heatlens.export.fingerprint import fingerprint_of, fingerprint_of_movie
from heatlens.export.job import ExportJob
from heatlens.export.output import check_names
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.sequence.names import parse_frames
from heatlens.source.named import source_of
from heatlens.source.origin import Origin
from heatlens.source.source import Source


@dataclass(frozen=True)
class PlannedFrame:
    """A frame before it is rendered.

    fingerprint  identifies everything that decides the pixels; it is kept in the file
    """

    frame: int
    origin: Origin
    lens: Lens
    path: Path
    fingerprint: str


@dataclass(frozen=True)
class ExportPlan:
    """All frames of a job, and what they are made of."""

    job: ExportJob
    source: Source
    frames: tuple[PlannedFrame, ...]

    @property
    def movie_fingerprint(self) -> str:
        """Return the fingerprint of all frames in one file."""
        rate = self.job.shot.frames_per_second
        return fingerprint_of_movie([frame.fingerprint for frame in self.frames], rate)


def frames_of(shot: Shot, text: str | None) -> tuple[int, ...]:
    """Return the frames in `text`, such as 1001-1100x2; None: from in to out, else all there are.

    Raises InputError for a text that is not a frame range, and where the source is not found.
    """
    return source_of(shot).frames_of(shot) if text is None else parse_frames(text)


def planned(job: ExportJob) -> ExportPlan:
    """Return what will be done. Files are looked up, and none is written.

    Raises InputError where a plate is missing and the job does not say what stands in for it, where
    a scene is missing, where a frame would replace a file that it is made of, and where the values
    make no lens.
    """
    source = source_of(job.shot)
    source.check(job.shot, job.frames, job.missing)
    check_names(job.output, job.frames)
    plan = ExportPlan(job, source, tuple(_planned(job, source, frame) for frame in job.frames))
    _check_sources_stay(plan)
    return plan


def _planned(job: ExportJob, source: Source, frame: int) -> PlannedFrame:
    lens = job.shot.lens_at(frame)
    origin = source.origin(job.shot, frame, job.missing)
    mark = fingerprint_of(job, frame, lens, origin)
    return PlannedFrame(frame, origin, lens, job.output.path_at(frame), mark)


def _check_sources_stay(plan: ExportPlan) -> None:
    paths = {file.path for frame in plan.frames for file in frame.origin.files}
    read = {os.path.realpath(path) for path in paths}
    for frame in plan.frames:
        if os.path.realpath(frame.path) in read:
            raise InputError(
                f"{frame.path} is a file that the export is made of. "
                "Give another name for the output."
            )
