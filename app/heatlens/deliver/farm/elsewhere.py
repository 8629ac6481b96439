"""Export frames that other processes or machines render."""

import os
import time
from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import closing
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.deliver.export.finished import check_replaced, is_finished
from heatlens.deliver.export.kept_frames import is_joined
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame, planned
from heatlens.deliver.export.run import FrameDone, export_frames
from heatlens.media.files.atomic_file import check_writable, make_folder
from heatlens.media.sequence.names import frames_text
from heatlens.render.frame_renderer import FrameRenderer

_LATE_S, _LOOK_S = 10.0, 0.25  # files of other machines may be seen late on a network disk
Make = Callable[[tuple[PlannedFrame, ...]], Iterator[FrameDone]]


def made_elsewhere(
    plan: ExportPlan, make: Make, make_renderer: Callable[[], FrameRenderer], advice: str = ""
) -> Generator[FrameDone]:
    """Export one frame a step, in the order in which `make` has finished them.

    Frames that are finished already are not given to it. Those of a movie become lossless files,
    which this process joins. Only what this process sees is finished, whatever `make` says. Raises
    InputError as `export_frames` does, and with `advice` for frames that are not here.
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
        with closing(_seen(tuple(left), make, advice)) as seen:
            yield from seen
    if plan.makes_movie and not all_there:
        with closing(export_frames(plan, make_renderer)) as steps:
            for _ in steps:
                pass


# What a worker says is not enough: workers with disks of their own write files that this machine
# never sees. A frame counts once its finished file is seen here. On a network disk that may be some
# seconds after the worker has closed it.
def _seen(left: tuple[PlannedFrame, ...], make: Make, advice: str) -> Generator[FrameDone]:
    """Yield the frames that are told and seen to be finished; the others may come late."""
    waiting, reported = {frame.frame: frame for frame in left}, {}
    for done in make(left):
        if done.frame in waiting:
            reported[done.frame] = done
            if is_finished(waiting[done.frame]):
                del waiting[done.frame]
                yield done
    end = time.monotonic() + _LATE_S
    while reported.keys() & waiting.keys():
        os.listdir(left[0].path.parent)  # a network disk then asks its server what is there
        for number in [it for it in reported if it in waiting and is_finished(waiting[it])]:
            del waiting[number]
            yield reported[number]
        if time.monotonic() > end:
            break
        time.sleep(_LOOK_S)
    if waiting:
        raise InputError(_missing(waiting, reported, len(left), left[0].path.parent, advice))


def _missing(
    waiting: Collection[int], written: Collection[int], count: int, folder: Path, advice: str
) -> str:
    reported = "reported as written" if all(it in written for it in waiting) else "not reported"
    which = frames_text(sorted(waiting))
    return (
        f"{len(waiting)} of {count} frames are not in {folder} on this machine ({which}), although "
        f"their work has ended; they were {reported}.{advice}"
    )
