"""Run an export: skip finished frames, and read, render and write the others concurrently."""

from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import repeat
from pathlib import Path

from heatlens.base.errors import HeatlensError
from heatlens.export.finished import is_finished, is_movie_finished
from heatlens.export.frame_files import RenderedFrame, write_frame
from heatlens.export.frame_writer import FrameWriter
from heatlens.export.movie import movie_file
from heatlens.export.plan import ExportPlan, PlannedFrame
from heatlens.export.rendering import FrameRendering
from heatlens.export.replaced import check_replaced
from heatlens.export.sequence_check import Remark
from heatlens.files.atomic_file import remove_leftovers
from heatlens.files.output_check import check_space, check_writable, make_folder
from heatlens.render import FrameRenderer

Write = Callable[[RenderedFrame], None]


@dataclass(frozen=True)
class FrameDone:
    """A frame whose file is complete."""

    frame: int
    path: Path
    was_there: bool  # finished by an earlier run
    surfaces_lost: str = ""  # a sentence, if surfaces behind its picture were merged or left out
    remarks: tuple[Remark, ...] = ()  # what is unusual about its plate


def export_frames(
    plan: ExportPlan, make_renderer: Callable[[], FrameRenderer]
) -> Generator[FrameDone]:
    """Export one frame per step: first report those already finished, then do the others in order.

    `make_renderer` is called, and OpenGL used, only if something is left to render, on the thread
    that takes the steps. Closing the generator stops the export; files are never partial. If a
    frame fails, the frames before it are finished, then the error is raised: InputError for a
    damaged plate or a file that cannot be written. Files that no export wrote are replaced only if
    the job says so: before the first frame, they raise InputError.
    """
    check_replaced(plan)
    make_folder(plan.job.output.folder)
    check_writable(plan.job.output.pattern)
    remove_leftovers(plan.job.output.folder)
    left = []
    for frame, is_there in zip(plan.frames, _are_there(plan), strict=True):
        if is_there:
            yield FrameDone(frame.frame, frame.path, was_there=True)
        else:
            left.append(frame)
    if left:
        with closing(_exported(plan, tuple(left), make_renderer)) as steps:
            yield from _with_room(plan, steps, len(left))


def _with_room(plan: ExportPlan, steps: Generator[FrameDone], count: int) -> Generator[FrameDone]:
    """Yield `steps`; after the first, raise InputError if the disk is too full for the others."""
    for number, done in enumerate(steps):
        yield done
        if number == 0 and not plan.job.output.is_movie and done.path.is_file():
            more = count - 1
            need = more * done.path.stat().st_size
            check_space(done.path.parent, need, f"{more} more frames as large as the first")


def _are_there(plan: ExportPlan) -> Iterator[bool]:
    """Return for each frame whether it is finished; all frames of a movie share one answer."""
    if plan.job.options.force:
        return repeat(False, len(plan.frames))
    if plan.job.output.is_movie:
        path = plan.frames[0].path
        return repeat(is_movie_finished(path, plan.movie_fingerprint), len(plan.frames))
    return map(is_finished, plan.frames)


def _exported(
    plan: ExportPlan, frames: tuple[PlannedFrame, ...], make_renderer: Callable[[], FrameRenderer]
) -> Generator[FrameDone]:
    may_be_there = not (plan.job.options.force or plan.job.output.is_movie)
    with (
        _files(plan) as write,
        closing(FrameRendering(plan, frames, make_renderer())) as rendering,
        FrameWriter[FrameDone]() as writer,
    ):
        for frame in frames:
            if may_be_there and is_finished(frame):  # finished by another export
                yield FrameDone(frame.frame, frame.path, was_there=True)
                continue
            try:
                rendered = rendering.rendered(frame)
            except HeatlensError:
                yield from writer.drain()
                raise
            yield from writer.put(partial(_written, write, rendered))
        yield from writer.drain()


@contextmanager
def _files(plan: ExportPlan) -> Iterator[Write]:
    """Yield the function that writes a frame; a movie stays open for the block."""
    if not plan.job.output.is_movie:
        yield partial(write_frame, plan.job)
        return
    with movie_file(plan.job, plan.frames[0].path, plan.movie_fingerprint) as movie:
        yield movie.write


def _written(write: Write, frame: RenderedFrame) -> FrameDone:
    write(frame)
    lost = frame.plate.surfaces_lost
    return FrameDone(frame.planned.frame, frame.planned.path, False, lost, frame.remarks)
