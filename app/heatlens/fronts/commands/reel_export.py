"""`heatlens export` of a reel or an edit: each of its shots, or one movie of the cut."""

import argparse
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import SHOT_FIELD, Reel, ReelShot
from heatlens.deliver.export.cut import Cut, export_cut, heard_in_cut, kept_movie
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import ExportPlan, planned
from heatlens.deliver.export.run import FrameDone
from heatlens.fronts.commands.export_options import job_of
from heatlens.fronts.commands.options.given_options import refuse_given
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import said_once, say, tell
from heatlens.fronts.commands.reel_options import checked_for_export, reel_of, shots_of
from heatlens.media.documents.edit_out import Exported, check_edit_out, write_edit
from heatlens.media.files.atomic_file import check_folder, make_folder

_NOT_OF_A_CUT = ("send", "after_export", "edit_out", "handles")

ShotToExport = tuple[argparse.Namespace, ExportPlan, str]
MadeFrames = AbstractContextManager[Iterator[FrameDone]]


@dataclass(frozen=True)
class ReelWork:
    """What `heatlens export` does with shots.

    say_before  print what is to be known of a shot before its frames are made
    export_one  export a shot
    submit      write a job of all shots
    made        the frames of a shot as they are finished, here or elsewhere
    """

    say_before: Callable[[argparse.Namespace, ExportPlan], None]
    export_one: Callable[[argparse.Namespace, ExportPlan, str], None]
    submit: Callable[[Iterable[ShotToExport]], None]
    made: Callable[[argparse.Namespace, ExportPlan], MadeFrames]


def export_reel(args: argparse.Namespace, work: ReelWork) -> None:
    """Export the reel `args.shot`.

    Every shot is planned before the first frame is made, so that what is missing is told at once.
    """
    reel = reel_of(args, args.shot)
    checked_for_export(args, reel)
    for shot in reel.shots:
        say(*(f"{shot.name}: {note}." for note in shot.notes))
    if SHOT_FIELD not in args.output:
        _export_cut(args, reel, work)
        return
    if args.edit_out is not None:
        check_edit_out(args.edit_out)
    with said_once(len(reel.shots)):
        jobs = [(shot, own, job_of(own)) for shot, own in shots_of(args, reel, args.output)]
    if args.submit is not None:
        work.submit((own, planned(job, job.frames), shot.name) for shot, own, job in jobs)
        return
    make_folder(Path(args.output.partition(SHOT_FIELD)[0] + SHOT_FIELD).parent)
    plans = [(shot, own, planned(job)) for shot, own, job in jobs]
    with said_once(len(reel.shots)):
        for _, own, plan in plans:
            work.say_before(own, plan)
    for shot, own, plan in plans:
        work.export_one(own, plan, shot.name)
    if args.edit_out is not None:
        write_edit(args.edit_out, reel, _exported(reel, [(s, p.job) for s, _, p in plans]))
        tell(str(args.edit_out))


def _export_cut(args: argparse.Namespace, reel: Reel, work: ReelWork) -> None:
    """Export all shots as one movie."""
    refuse_given(args, _NOT_OF_A_CUT, "This is not possible with one movie of a cut")
    output = parse_output(args.output)
    check_folder(output.pattern)
    parts, shots = [], []
    with said_once(len(reel.shots)):
        for number, (shot, own) in enumerate(shots_of(args, reel, args.output), start=1):
            job = replace(job_of(own), output=kept_movie(output, number, shot.name))
            parts.append(planned(job, job.frames))
            shots.append((own, parts[-1], shot.name))
    if args.submit is not None:
        work.submit(shots)
        return
    cut, count = Cut(reel, output, tuple(parts)), sum(len(plan.frames) for plan in parts)
    say(*filter(None, (heard_in_cut(cut, plan, at)[1] for at, plan in enumerate(parts))))
    with (
        progress_line() as show,
        closing(export_cut(cut, lambda at: work.made(*shots[at][:2]))) as steps,
    ):
        for number, (at, done) in enumerate(steps, start=1):
            show(f"{shots[at][2]}, frame {done.frame}, {number} of {count} done")
    tell(str(output.pattern))


def _exported(reel: Reel, jobs: list[tuple[ReelShot, ExportJob]]) -> dict[str, Exported]:
    """Return what was exported of each shot, by its name."""
    made = {}
    for inner, (shot, job) in zip(reel.shots, jobs, strict=True):
        frames = FrameRange(job.frames[0], job.frames[-1])
        if job.output.is_movie:
            raise InputError("--edit-out is for exported frames, not for movies of the shots.")
        cut = inner.frames or frames
        folder, form = job.output.folder, job.output.form
        made[shot.name] = Exported(job.shot, folder, form, frames, cut, inner.retime)
    return made
