"""What each frame is made of, which file it becomes, and by what that is known again."""

import os
from dataclasses import dataclass

from heatlens.errors import InputError
from heatlens.export.fingerprint import fingerprint_of, fingerprint_of_movie
from heatlens.export.frame_source import FrameSource, PlannedFrame
from heatlens.export.job import ExportJob, check_source
from heatlens.export.output import check_names
from heatlens.export.plate_frames import PlateFrames
from heatlens.export.scene_frames import SceneFrames
from heatlens.model.shot import Shot
from heatlens.scene.scene_source import is_scene_source
from heatlens.sequence.names import parse_frames
from heatlens.sequence.sequence import find_sequence


@dataclass(frozen=True)
class ExportPlan:
    """All frames of a job, and what they are made of."""

    job: ExportJob
    source: FrameSource
    frames: tuple[PlannedFrame, ...]

    @property
    def movie_fingerprint(self) -> str:
        """Of all frames in one file."""
        rate = self.job.shot.frames_per_second
        return fingerprint_of_movie([frame.fingerprint for frame in self.frames], rate)


def frames_of(shot: Shot, text: str | None) -> tuple[int, ...]:
    """The frames in `text`, such as 1001-1100x2; None: those from in to out, else all there are.

    Raises InputError for what are no frames, and where plate or scene cannot be found.
    """
    return _source_of(shot).frames_of(shot) if text is None else parse_frames(text)


def planned(job: ExportJob) -> ExportPlan:
    """What will be done; files are looked at, but none is written.

    Raises InputError where a plate is missing and the job does not say what stands in for it, a
    scene is missing, a frame would be written over what it is made of, or the lens cannot be.
    """
    source = _source_of(job.shot)
    source.check(job.shot, job.frames, job.missing)
    check_names(job.output, job.frames)
    plan = ExportPlan(job, source, tuple(_planned(job, source, frame) for frame in job.frames))
    _check_sources_stay(plan)
    return plan


def _source_of(shot: Shot) -> FrameSource:
    text = check_source(shot)
    return SceneFrames(text) if is_scene_source(text) else PlateFrames(find_sequence(text))


def _planned(job: ExportJob, source: FrameSource, frame: int) -> PlannedFrame:
    lens = job.shot.lens_at(frame)
    origin = source.origin(job.shot, frame, job.missing)
    mark = fingerprint_of(job, frame, lens, origin)
    return PlannedFrame(frame, origin, lens, job.output.path_at(frame), mark)


def _check_sources_stay(plan: ExportPlan) -> None:
    paths = [*(frame.origin.path for frame in plan.frames), *plan.source.beside]
    read = {os.path.realpath(path) for path in paths if path}
    for frame in plan.frames:
        if os.path.realpath(frame.path) in read:
            raise InputError(
                f"{frame.path} is what the export is made of: give another name for the output."
            )
