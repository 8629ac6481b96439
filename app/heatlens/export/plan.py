"""Plan an export: the inputs, the file and the fingerprint of each frame."""

import os
from dataclasses import dataclass
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.export.fingerprint import fingerprint_of, fingerprint_of_movie
from heatlens.export.job import ExportJob
from heatlens.export.output import check_names
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.plate.exr.exr_whole import cut_short
from heatlens.sequence.names import parse_frames
from heatlens.source.named import source_of
from heatlens.source.origin import Origin
from heatlens.source.source import Source

_NAMED_MOST = 5  # files in a sentence


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
    """All frames of a job with their inputs."""

    job: ExportJob
    source: Source
    frames: tuple[PlannedFrame, ...]

    @property
    def movie_fingerprint(self) -> str:
        """Return the fingerprint of a movie of all frames."""
        rate = self.job.shot.frames_per_second
        return fingerprint_of_movie([frame.fingerprint for frame in self.frames], rate)


def frames_of(shot: Shot, text: str | None) -> tuple[int, ...]:
    """Return the frames in `text`, such as 1001-1100x2, or if None those from in to out, else all.

    Raises InputError if the text is no frame range or the source is not found.
    """
    return source_of(shot).frames_of(shot) if text is None else parse_frames(text)


def planned(job: ExportJob) -> ExportPlan:
    """Return the plan of a job. Input files are looked up, but nothing is written.

    Raises InputError if a scene is missing, if a plate is missing and the job does not allow to
    replace it, if an output would overwrite an input, or if the lens is impossible.
    """
    source = source_of(job.shot)
    source.check(job.shot, job.frames, job.options.missing)
    check_names(job.output, job.frames)
    plan = ExportPlan(job, source, tuple(_planned(job, source, frame) for frame in job.frames))
    _check_sources_stay(plan)
    _check_whole(plan)
    return plan


def _planned(job: ExportJob, source: Source, frame: int) -> PlannedFrame:
    lens = job.shot.lens_at(frame)
    origin = source.origin(job.shot, frame, job.options.missing)
    mark = fingerprint_of(job, frame, lens, origin)
    return PlannedFrame(frame, origin, lens, job.output.path_at(frame), mark)


def _check_whole(plan: ExportPlan) -> None:
    """Raise InputError for plates without all of their pixels, before hours are spent on others."""
    found = cut_short(file.path for frame in plan.frames for file in frame.origin.files)
    if found:
        what = "is empty" if found[0].stat().st_size == 0 else "ends before its last pixels"
        others = ", ".join(path.name for path in found[1:_NAMED_MOST])
        more = f", and so with {len(found) - 1} more ({others})" if others else ""
        raise InputError(
            f"{found[0]} {what}{more}. Write or copy such files again, or export other frames with "
            "--frames."
        )


def _check_sources_stay(plan: ExportPlan) -> None:
    paths = {file.path for frame in plan.frames for file in frame.origin.files}
    read = {os.path.realpath(path) for path in paths}
    for frame in plan.frames:
        if os.path.realpath(frame.path) in read:
            raise InputError(
                f"{frame.path} is an input of the export: give another name for the output."
            )
