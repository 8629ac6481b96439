"""Export frames that other processes or machines render."""

import os
import time
from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import closing
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.deliver.export.finished import check_may_replace, is_finished
from heatlens.deliver.export.kept_frames import is_movie_joined
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame, plan_export
from heatlens.deliver.export.run import FrameDone, export_frames
from heatlens.media.files.atomic_file import check_writable, make_folder
from heatlens.media.sequence.names import frames_text
from heatlens.render.frame_renderer import FrameRenderer

_LATE_FILES_S, _CHECK_INTERVAL_S = (
    10.0,
    0.25,
)  # files of other machines may be seen late on a network disk
Make = Callable[[tuple[PlannedFrame, ...]], Iterator[FrameDone]]


def export_elsewhere(
    plan: ExportPlan, make: Make, make_renderer: Callable[[], FrameRenderer], advice: str = ""
) -> Generator[FrameDone]:
    """Export one frame a step, in the order in which `make` has finished them.

    Frames that are finished already are not passed to `make`. The frames of a movie become lossless
    files, which this process joins. A frame counts as finished only if this process sees its file.
    Raises InputError as `export_frames` does, and with `advice` for frames whose files are missing.
    """
    check_may_replace(plan)
    parts = plan_export(plan.job, plan.job.frames) if plan.makes_movie else plan
    is_joined_already = is_movie_joined(parts)
    make_folder(plan.job.output.folder)
    check_writable(plan.job.output.pattern)
    missing_frames = []
    for frame in parts.frames:
        if is_joined_already or (not plan.job.options.force and is_finished(frame)):
            yield FrameDone(frame.frame, frame.path, was_there=True)
        else:
            missing_frames.append(frame)
    if missing_frames:
        make_folder(parts.folder)
        with closing(_await_files(tuple(missing_frames), make, advice)) as finished_frames:
            yield from finished_frames
    if plan.makes_movie and not is_joined_already:
        with closing(export_frames(plan, make_renderer)) as steps:
            for _ in steps:
                pass


# A worker's report is not enough: workers with disks of their own write files that this machine
# never sees. A frame counts once its finished file is seen here. On a network disk that may be some
# seconds after the worker has closed it.
def _await_files(frames: tuple[PlannedFrame, ...], make: Make, advice: str) -> Generator[FrameDone]:
    """Make `frames`, and yield each one when it is reported and its finished file is seen here.

    Waits `_LATE_FILES_S` for files of reported frames. Raises InputError if files are missing then.
    """
    waiting, reported = {frame.frame: frame for frame in frames}, {}
    for done in make(frames):
        if done.frame in waiting:
            reported[done.frame] = done
            if is_finished(waiting[done.frame]):
                del waiting[done.frame]
                yield done
    deadline = time.monotonic() + _LATE_FILES_S
    while reported.keys() & waiting.keys():
        os.listdir(frames[0].path.parent)  # a network disk then asks its server what is there
        for number in [it for it in reported if it in waiting and is_finished(waiting[it])]:
            del waiting[number]
            yield reported[number]
        if time.monotonic() > deadline:
            break
        time.sleep(_CHECK_INTERVAL_S)
    if waiting:
        raise InputError(
            _missing_message(waiting, reported, len(frames), frames[0].path.parent, advice)
        )


def _missing_message(
    waiting: Collection[int], written: Collection[int], count: int, folder: Path, advice: str
) -> str:
    """Return the message for frames whose files did not appear in `folder`."""
    report_text = "reported as written" if all(it in written for it in waiting) else "not reported"
    frame_list = frames_text(sorted(waiting))
    return (
        f"{len(waiting)} of {count} frames are not in {folder} on this machine ({frame_list}), "
        "although "
        f"their work has ended; they were {report_text}.{advice}"
    )
