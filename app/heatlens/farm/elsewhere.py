"""Export frames that other processes or machines render."""

from collections.abc import Callable, Generator, Iterator
from contextlib import closing

from heatlens.export.finished import check_replaced, is_finished
from heatlens.export.kept_frames import is_joined
from heatlens.export.plan import ExportPlan, PlannedFrame, planned
from heatlens.export.run import FrameDone, export_frames
from heatlens.files.atomic_file import check_writable, make_folder
from heatlens.render import FrameRenderer

Make = Callable[[tuple[PlannedFrame, ...]], Iterator[FrameDone]]


def made_elsewhere(
    plan: ExportPlan, make: Make, make_renderer: Callable[[], FrameRenderer]
) -> Generator[FrameDone]:
    """Export one frame a step, in the order in which `make` has finished them.

    Frames that are finished already are not given to it. Those of a movie become lossless files,
    which this process joins. Raises InputError as `export_frames` does.
    """
    check_replaced(plan)
    parts = planned(plan.job, plan.job.frames) if plan.makes_movie else plan
    all_there = is_joined(parts)
    make_folder(plan.job.output.folder)
    check_writable(plan.job.output.pattern)
    left = []
    for frame in parts.frames:
        if all_there or (not plan.job.options.force and is_finished(frame)):
            yield FrameDone(frame.frame, frame.path, was_there=True)
        else:
            left.append(frame)
    if left:
        make_folder(parts.folder)
        yield from make(tuple(left))
    if plan.makes_movie and not all_there:
        with closing(export_frames(plan, make_renderer)) as steps:
            for _ in steps:
                pass
