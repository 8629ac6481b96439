"""The render job of each frame of the open shot, with the key under which it is kept."""

import math
import os
import time
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass
from functools import cached_property

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view_geometry import fit_zoom
from heatlens.media.sequence.sequence import MissingPolicy, Sequence, StampedFile, stamp_files
from heatlens.render.defocus.line_solver import SolverName
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.rendered_frames.frame_filler import FrameJob, PlateFile
from heatlens.render.rendered_frames.frame_key import (
    KeySource,
    PlayOrder,
    SceneSight,
    frame_key,
    maker_of,
    runs_of,
    shot_key,
)
from heatlens.render.rendered_frames.stamp_book import LookUp, StampBook
from heatlens.render.source.opened import Opened
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline

_SCALE_STEPS = 16  # scales are multiples of 1/16, so that a slightly larger window changes nothing
_CHECK_EVERY_S = 2.0  # time between two checks of the files


@dataclass(frozen=True)
class PictureInputs:
    """What decides the pictures of all frames, apart from the frame number.

    opened   the open source
    files    the files of its frames, as they were last looked up
    missing  the substitute for a frame without a file
    program  the program that renders the frames; empty for this one
    lens, curves, defocus, framing  those parts of the shot
    scale    the scale of the pictures
    """

    opened: Opened | None
    files: LookUp
    missing: MissingPolicy
    program: tuple[str, ...]
    lens: Lens
    curves: LensCurves
    defocus: DefocusSettings
    framing: Framing | None
    scale: float


@dataclass(frozen=True)
class FramesRequest:
    """Everything that decides which frames are still to be rendered.

    inputs         what decides their pictures
    order          the frames, in rendering order
    job_count      how many frames have their jobs; with the same `inputs` it only grows
    store_version  the version of the store
    """

    inputs: PictureInputs | None
    order: PlayOrder
    job_count: int
    store_version: int


@dataclass(frozen=True)
class Progress:
    """How many of the requested frames are rendered, as far as their keys are known.

    request          the request that was counted; None without one
    jobs             the jobs of all requested frames, in rendering order
    missing_jobs     the jobs of frames that are not rendered
    rendered_frames  the numbers of the frames that are rendered
    keys             the keys of all jobs
    """

    request: FramesRequest | None = None
    jobs: tuple[FrameJob, ...] = ()
    missing_jobs: tuple[FrameJob, ...] = ()
    rendered_frames: frozenset[int] = frozenset()
    keys: frozenset[str] = frozenset()

    @cached_property
    def runs(self) -> tuple[FrameRange, ...]:
        """The rendered frames as ranges, in order."""
        return runs_of(self.rendered_frames)


def progress_of(
    request: FramesRequest, jobs: tuple[FrameJob, ...], stored_keys: Container[str]
) -> Progress:
    """Return the progress of these jobs; `stored_keys` are the keys of stored pictures."""
    missing_jobs = tuple(job for job in jobs if job.key not in stored_keys)
    rendered_frames = frozenset(job.frame for job in jobs if job.key in stored_keys)
    return Progress(
        request, jobs, missing_jobs, rendered_frames, frozenset(job.key for job in jobs)
    )


class AheadJobs(Commands):
    """The job of each frame, made on request and valid until shot, files or size change."""

    def __init__(self, shared: Shared, timeline: Timeline, view: PictureView) -> None:
        super().__init__(shared)
        self._renderer = self._source.picture.renderer
        self._timeline = timeline
        self._view = view
        self._clock = time.perf_counter
        self._stamps = StampBook(self._wake)
        self.inputs: PictureInputs | None = None  # what the jobs below were made for
        self._jobs: dict[int, FrameJob | None] = {}
        self._shot, self._shot_key = self._editing.shot, ""
        self._machine_key: tuple[str, ...] = ()
        self.program: tuple[str, ...] = ()  # the program that renders; empty for this one
        self._sequence: Sequence | None = None  # as it was at the last call of `update`
        self._next_check_s = -math.inf

    def update(self, frames: Iterable[int]) -> None:
        """Forget jobs that are out of date, and prepare the keys of `frames`, which come next."""
        self._check_files(frames)
        shot = self._editing.shot
        source = self._source.opened, self._stamps.latest, self._timeline.missing, self.program
        inputs = PictureInputs(
            *source, shot.lens, shot.curves, shot.defocus, shot.framing, self._scale
        )
        if inputs != self.inputs:
            self.inputs, self._jobs = inputs, {}
            self._prepare_keys(shot)

    def _check_files(self, frames: Iterable[int]) -> None:
        """Look up the files of these frames at intervals, and at once for another source."""
        opened, missing = self._source.opened, self._timeline.missing
        inputs = self.inputs
        if inputs is None or (opened, missing) != (inputs.opened, inputs.missing):
            self._sequence = None
            self._stamps.forget()
            self._next_check_s = -math.inf
        if opened is None or opened.cache is None:
            return
        self._forget_replaced_files(opened.cache.sequence)
        if self._clock() >= self._next_check_s:
            self._next_check_s = self._clock() + _CHECK_EVERY_S
            self._stamps.start_look_up(frames, lambda frame: opened.files_at(frame, missing))

    def _forget_replaced_files(self, sequence: Sequence) -> None:
        """Forget the files of frames that appeared or disappeared, and of those that they replace.

        The replaced frames have no file of their own.
        """
        old_sequence, self._sequence = self._sequence, sequence
        if (
            old_sequence is not None
            and old_sequence is not sequence
            and old_sequence.present != sequence.present
        ):
            self._stamps.keep_only(set(old_sequence.present) & set(sequence.present))
            self._next_check_s = -math.inf

    def _prepare_keys(self, shot: Shot) -> None:
        """Compute the shot to render and the part of the keys that all frames share."""
        self._machine_key = self._machine_key or maker_of(self._renderer)
        opened = self._source.opened
        self._shot = self._source.feed.scale_shot(shot, self._scale)
        is_read = opened is not None and opened.cache is not None
        options = opened.options if opened is not None and is_read else shot.plate_options
        self._shot_key = shot_key(self.program or self._machine_key, options, self._shot.defocus)

    @property
    def driver(self) -> tuple[str, str, SolverName]:
        """The graphics driver, its version, and the solver with which frames are rendered here."""
        device = self._renderer.ctx
        return device.name, device.version, self._renderer.solver.name

    @property
    def _scale(self) -> float:
        """The scale of cached pictures: about the size of a whole picture on the screen."""
        zoom = fit_zoom(self._view.viewport, self._source.picture_shape(self._editing.shot))
        return min(max(math.ceil(zoom * _SCALE_STEPS - 0.25), 1), _SCALE_STEPS) / _SCALE_STEPS

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures in pixels."""
        source = self._source
        if source.plate is None:
            return 1, 1
        window, _ = source.feed.windows(self._shot)
        return proxy_size((window.width, window.height), self._shot.defocus.proxy)

    def make(self, frames: Iterable[int], seconds: float) -> bool:
        """Make the jobs of these frames, as many as fit into `seconds`; return False if not all."""
        end_s = self._clock() + seconds
        for frame in frames:
            if frame not in self._jobs:
                try:
                    self._jobs[frame] = self._make_job(frame)
                except _NotYetError:
                    pass
                if self._clock() > end_s:
                    return False
        return True

    def ready_jobs(self, frames: Iterable[int]) -> tuple[FrameJob, ...]:
        """Return the jobs of these frames that are made already."""
        jobs = (self._jobs.get(frame) for frame in frames)
        return tuple(job for job in jobs if job is not None)

    @property
    def count(self) -> int:
        """How many frames have been tried, including those without a job."""
        return len(self._jobs)

    def job_of(self, frame: int) -> FrameJob | None:
        """Return the job of a frame; None if there is none or it is not made yet."""
        if frame not in self._jobs:
            self.make((frame,), 1.0)
        return self._jobs.get(frame)

    def _make_job(self, frame: int) -> FrameJob | None:
        """Return the job of a frame; None if it has no valid lens or no file."""
        opened, files = self._source.opened, self._files(frame)
        try:
            lens = self._shot.lens_at(frame)
            view = self._scene_view(frame)
        except HeatlensError:
            return None  # no valid lens, which is reported where the frame is shown
        if opened is None or not (files or opened.stamps or view):
            return None  # no file, which is reported where the frame is shown
        name = os.path.abspath(files[0].path) if files else opened.text
        source = KeySource(name, (*opened.stamps, *(file.stamp for file in files)))
        plate = PlateFile(files, opened.settled_options, opened.read) if files else None
        key, again = frame_key(self._shot_key, source, lens, view), opened.render_source
        return FrameJob(key, self._shot, frame, plate, again, opened.stamps)

    def whole_picture_job(self, shot: Shot, frame: int) -> Callable[[], FrameJob] | None:
        """Return a function that makes the job of a whole picture, and may wait for a disk.

        Return None if the source cannot be rendered again. Raises InputError.
        """
        opened, missing = self._source.opened, self._timeline.missing
        if opened is None or opened.render_source is None:
            return None

        def make() -> FrameJob:
            """Return the job. Raises InputError if the frame has no file."""
            frame_files = stamp_files(opened.files_at(frame, missing))
            if not (frame_files or opened.stamps or self._renderer.has_many_views):
                raise InputError(f"Frame {frame} has no file.")
            plate = (
                PlateFile(frame_files, opened.settled_options, opened.read) if frame_files else None
            )
            return FrameJob("", shot, frame, plate, opened.render_source, opened.stamps)

        return make

    def _files(self, frame: int) -> tuple[StampedFile, ...]:
        """Return the files that belong to this frame alone; those of a scene belong to every frame.

        Raises _NotYetError before they are looked up.
        """
        opened, missing = self._source.opened, self._timeline.missing
        if opened is None or opened.cache is None:
            return ()
        files = self._stamps.files(frame)
        if files is None and not self._stamps.is_empty:  # another frame may have the same files
            files = self._stamps.stamped_files(opened.files_at(frame, missing))
        if files is None:
            raise _NotYetError
        return files

    def _scene_view(self, frame: int) -> SceneSight | None:
        """Return the camera's view of the scene; None for plates."""
        renderer, size = self._renderer, (self._shot.framing or Framing()).size
        pose = renderer.pose_at(self._shot, frame)
        if pose is None or renderer.scene is None:
            return None
        return SceneSight(pose, float(frame) if renderer.scene.is_moving else None, size)

    def close(self) -> None:
        """Stop checking files."""
        self._stamps.close()


class _NotYetError(Exception):
    """The file of a frame has not been checked yet."""
