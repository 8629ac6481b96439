"""Run an export: skip finished frames, and read, render and write the others concurrently."""

from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import repeat
from pathlib import Path
from typing import Generic, TypeVar

from heatlens.core.base.closing import Closing
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.log import log_time
from heatlens.deliver.export.finished import check_may_replace, is_finished, is_movie_finished
from heatlens.deliver.export.frame_files import RenderedFrame, write_frame
from heatlens.deliver.export.kept_frames import (
    KeptFrameRendering,
    is_movie_joined,
    remove_kept_frames,
    write_kept_frame,
)
from heatlens.deliver.export.movie import movie_file
from heatlens.deliver.export.movie_sound import find_sound
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame
from heatlens.deliver.export.rendering import FrameRendering
from heatlens.deliver.export.sequence_check import Remark
from heatlens.media.files.atomic_file import (
    check_space,
    check_writable,
    make_folder,
    remove_leftovers,
)
from heatlens.render.frame_renderer import FrameRenderer

Written = TypeVar("Written")

_MOST_WAITING = 2  # rendered frames that may wait in memory, besides the one being written


# One thread is enough: OpenEXR lets go of Python's lock while it writes, so that a frame is written
# while the next one is rendered, and a movie needs its frames in order. Few frames may wait,
# because each holds its pixels in memory.
class FrameWriter(Closing, Generic[Written]):
    """Runs functions on a thread in order, one at a time, and returns their results in order.

    If its context is left by an exception, pending functions are dropped and a running one is
    awaited.
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="frame-writer")
        self._pending: deque[Future[Written]] = deque()

    def put(self, write: Callable[[], Written]) -> Iterator[Written]:
        """Queue `write`; yield finished results, and wait if too many are pending.

        Raises the errors of writing.
        """
        self._pending.append(self._thread.submit(write))
        while self._pending and (len(self._pending) > _MOST_WAITING or self._pending[0].done()):
            yield self._pending.popleft().result()

    def drain(self) -> Iterator[Written]:
        """Wait for all pending functions, and yield their results."""
        while self._pending:
            yield self._pending.popleft().result()

    def close(self) -> None:
        """Drop pending functions, and wait for a running one."""
        self._thread.shutdown(wait=True, cancel_futures=True)


Write = Callable[[RenderedFrame], None]


@dataclass(frozen=True)
class FrameDone:
    """A frame whose file is complete."""

    frame: int
    path: Path
    was_there: bool  # True if an earlier run finished it
    surfaces_lost: str = ""  # a message, if surfaces behind its picture were merged or left out
    remarks: tuple[Remark, ...] = ()  # remarks on its plate
    maker: str = ""  # address of the worker of a cluster
    pace: str = ""  # message on the render time of the quality final, where it was measured


def export_frames(
    plan: ExportPlan, make_renderer: Callable[[], FrameRenderer]
) -> Generator[FrameDone]:
    """Export one frame per step: first report those already finished, then do the others in order.

    `make_renderer` is called, and the GPU used, only if something is left to render, on the thread
    that takes the steps. Closing the generator stops the export; files are never partial. If a
    frame fails, the frames before it are finished, then the error is raised: InputError for a
    damaged plate or a file that cannot be written. Files that no export wrote are replaced only if
    the job says so: before the first frame, they raise InputError.
    """
    check_may_replace(plan)
    if is_movie_joined(plan):
        yield from (FrameDone(frame.frame, frame.path, was_there=True) for frame in plan.frames)
        return
    make_folder(plan.job.output.folder, plan.is_part)  # the task of a farm may be the first
    make_folder(plan.folder)
    check_writable(plan.frames[0].path)
    remove_leftovers(plan.folder)
    missing_frames = []
    for frame, is_done in zip(plan.frames, _find_finished(plan), strict=True):
        if is_done:
            yield FrameDone(frame.frame, frame.path, was_there=True)
        else:
            missing_frames.append(frame)
    if missing_frames:
        with closing(_export_missing(plan, tuple(missing_frames), make_renderer)) as steps:
            yield from _check_space_after_first(plan, steps, len(missing_frames))


def _check_space_after_first(
    plan: ExportPlan, steps: Generator[FrameDone], count: int
) -> Generator[FrameDone]:
    """Yield `steps`; after the first, raise InputError if the disk is too full for the others."""
    for number, done in enumerate(steps):
        yield done
        if number == 0 and not plan.makes_movie and done.path.is_file():
            remaining = count - 1
            needed_bytes = remaining * done.path.stat().st_size
            check_space(
                done.path.parent, needed_bytes, f"{remaining} more frames as large as the first"
            )


def _find_finished(plan: ExportPlan) -> Iterator[bool]:
    """Return whether each frame is finished; all frames of a movie share one answer."""
    if plan.job.options.force:
        return repeat(False, len(plan.frames))
    if plan.makes_movie:
        path = plan.frames[0].path
        return repeat(is_movie_finished(path, plan.movie_fingerprint), len(plan.frames))
    return map(is_finished, plan.frames)


def _export_missing(
    plan: ExportPlan, frames: tuple[PlannedFrame, ...], make_renderer: Callable[[], FrameRenderer]
) -> Generator[FrameDone]:
    """Render and write `frames`, and yield each one when its file is complete."""
    may_be_there = not (plan.job.options.force or plan.makes_movie)
    with (
        _open_output(plan) as write,
        closing(_open_rendering(plan, frames, make_renderer)) as rendering,
        FrameWriter[FrameDone]() as writer,
    ):
        for frame in frames:
            if may_be_there and is_finished(frame):  # finished by another export
                yield FrameDone(frame.frame, frame.path, was_there=True)
                continue
            try:
                with log_time(f"frame {frame.frame} read and rendered"):
                    rendered = rendering.render(frame)
            except HeatlensError:
                yield from writer.drain()
                raise
            yield from writer.put(partial(_write_and_report, write, rendered))
        yield from writer.drain()


def _open_rendering(
    plan: ExportPlan, frames: tuple[PlannedFrame, ...], make_renderer: Callable[[], FrameRenderer]
) -> FrameRendering | KeptFrameRendering:
    """Return the rendering of `frames`; that of a movie reads kept files where there are some."""
    if plan.makes_movie:
        return KeptFrameRendering(plan, frames, make_renderer)
    return FrameRendering(plan, frames, make_renderer())


@contextmanager
def _open_output(plan: ExportPlan) -> Iterator[Write]:
    """Yield the function that writes a frame; a movie stays open for the block."""
    if not plan.makes_movie:
        yield write_kept_frame if plan.job.output.is_movie else partial(write_frame, plan.job)
        return
    sound_frames, _ = find_sound(plan, plan.job.shot.frames_per_second)
    with movie_file(plan.job, plan.frames[0].path, plan.movie_fingerprint, sound_frames) as movie:
        yield movie.write
    remove_kept_frames(plan)


def _write_and_report(write: Write, frame: RenderedFrame) -> FrameDone:
    """Write a frame, and return what is reported of it."""
    with log_time(f"frame {frame.planned.frame} written"):
        write(frame)
    surfaces_lost = frame.plate.surfaces_lost
    number, path = frame.planned.frame, frame.planned.path
    return FrameDone(
        number,
        path,
        was_there=frame.is_kept,
        surfaces_lost=surfaces_lost,
        remarks=frame.remarks,
        pace=frame.pace,
    )
