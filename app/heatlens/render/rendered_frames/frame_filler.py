"""Render frames one after the other in short time slices while the window is idle."""

import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path

from heatlens.core.base.background import Threads
from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.media.sequence.sequence import Stamp, StampedFile, stamp_of
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.rendered_frames.cached_pictures import RenderedPicture
from heatlens.render.source.source import Source

_WAITING = "waiting for a plate"  # name of a step in which there is nothing to render


@dataclass(frozen=True)
class PlateFile:
    """A plate in its state when the key of its frame was made.

    files    the file of the picture, then the others that it is made of
    options  how they are read
    read     reads the plate at a path
    """

    files: tuple[StampedFile, ...]
    options: PlateOptions
    read: Callable[[Path], Plate] = field(compare=False)

    @property
    def path(self) -> Path:
        """The file of the picture."""
        return self.files[0].path


@dataclass(frozen=True)
class FrameJob:
    """A frame to be rendered.

    key     the key under which its picture is kept
    shot    the shot at the size of the cached picture
    frame   the frame number
    plate   the file that it is rendered from, None for a scene
    source  reads the plates or the scene again, on another machine
    stamps  of the files of a scene
    """

    key: str
    shot: Shot
    frame: int
    plate: PlateFile | None
    source: Source | None = None
    stamps: tuple[Stamp | None, ...] = ()


class FrameFiller:
    """Works on one job at a time, and reads the plate of the next one meanwhile."""

    def __init__(self, renderer: FrameRenderer, wake: Callable[[], None] = lambda: None) -> None:
        """Keep a `renderer` that is used for nothing else.

        `wake` is called on a thread after a plate has been read.
        """
        self.renderer = renderer
        self._clock = time.perf_counter
        self._wake = wake
        self._job: FrameJob | None = None
        self._loaded: Plate | None = None  # the plate in the renderer
        self._steps: Steps[RenderedPicture] | None = None
        self._reader = Threads("frames-plate")
        self._reads: dict[PlateFile, Future[Plate]] = {}

    def work(
        self, job: FrameJob, next_job: FrameJob | None, slice_s: float
    ) -> RenderedPicture | None:
        """Continue with `job` for about `slice_s` seconds, at least one step.

        Return its picture once it is finished, else None. The plate of `next_job` is read ahead.
        A job whose key differs from that of the previous call starts from the beginning. Raises
        HeatlensError if the job cannot be rendered.
        """
        if self._job is None or job.key != self._job.key or self._steps is None:
            self.stop()
            self._job, self._steps = job, self._render_job(job)
        self._read_ahead(job, next_job)
        end = self._clock() + slice_s
        try:
            while next(self._steps) is not _WAITING and self._clock() < end:
                pass
        except StopIteration as done:
            self._steps = None
            return done.value  # type: ignore[no-any-return]
        except BaseException:
            self._steps = None
            raise
        return None

    def stop(self) -> None:
        """Abandon the unfinished job."""
        if self._steps is not None:
            self._steps.close()
        self._steps = self._job = None

    @property
    def is_reading(self) -> bool:
        """True while the plate of the job is being read, so that there is nothing to render."""
        file = None if self._job is None else self._job.plate
        return file in self._reads and not self._reads[file].done()

    def unload(self) -> None:
        """Free the memory that is needed only for rendering."""
        self.stop()
        self._reads.clear()
        self.renderer.unload()
        self._loaded = None

    def close(self) -> None:
        """Stop reading plates, without waiting for a read that has begun."""
        self.stop()
        self._reader.close()

    def _render_job(self, job: FrameJob) -> Steps[RenderedPicture]:
        """Wait for the plate of a job, render its frame and download it, in steps."""
        if job.plate is not None:
            while not self._start_reading(job.plate).done():
                yield _WAITING
            plate = self._start_reading(job.plate).result()
            if self._loaded is not plate:
                self._loaded = None
                yield from self.renderer.load_steps(plate)
                self._loaded = plate
        picture = yield from self.renderer.steps(job.shot, job.frame)
        self.renderer.ctx.finish()
        yield "finish"
        plate = self.renderer.loaded.plate
        return RenderedPicture(
            download(picture), plate.data_window, plate.display_window, plate.pixel_aspect_ratio
        )

    def _read_ahead(self, job: FrameJob, next_job: FrameJob | None) -> None:
        """Keep the plates of both jobs, and drop all others."""
        files = [
            planned_job.plate
            for planned_job in (job, next_job)
            if planned_job is not None and planned_job.plate is not None
        ]
        self._reads = {file: read for file, read in self._reads.items() if file in files}
        for file in files:
            self._start_reading(file)

    def _start_reading(self, file: PlateFile) -> "Future[Plate]":
        """Return the future of a plate; the first call starts to read it."""
        if file not in self._reads:
            self._reads[file] = self._reader.submit(_read_if_unchanged, file)
            self._reads[file].add_done_callback(lambda _: self._wake())
        return self._reads[file]


def _read_if_unchanged(file: PlateFile) -> Plate:
    """Read the plate and count its bins, on a thread. Raises InputError if a file has changed."""
    for stamped_file in file.files:
        if stamp_of(stamped_file.path) != stamped_file.stamp:
            raise InputError(f"{stamped_file.path} has changed in the meantime.")
    return file.read(file.path).count_bins()
