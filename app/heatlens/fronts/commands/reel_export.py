"""`heatlens export` of a reel or an edit: each of its shots, or one movie of the cut."""

import argparse
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import SHOT_FIELD, Reel, ReelShot
from heatlens.deliver.export.cut import Cut, export_cut, find_sound_in_cut, kept_frames_output
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import ExportPlan, plan_export
from heatlens.deliver.export.run import FrameDone
from heatlens.fronts.commands.export_options import make_export_job
from heatlens.fronts.commands.options.given_options import refuse_options
from heatlens.fronts.commands.options.reel_options import (
    check_for_export,
    read_given_reel,
    shots_with_options,
)
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import gather_messages, print_messages, print_result
from heatlens.media.documents.edit_out import ExportedShot, check_edit_out, write_edit
from heatlens.media.files.atomic_file import check_folder, make_folder

_NOT_FOR_CUTS = ("send", "after_export", "edit_out", "handles")

ShotToExport = tuple[argparse.Namespace, ExportPlan, str]
FinishedFrames = AbstractContextManager[Iterator[FrameDone]]


@dataclass(frozen=True)
class ReelActions:
    """The functions with which `heatlens export` exports the shots of a reel.

    print_notes    print the notes on a shot before its frames are made
    export_one     export a shot
    submit         write a job of all shots
    export_frames  yield the frames of a shot as they are finished, here or elsewhere
    """

    print_notes: Callable[[argparse.Namespace, ExportPlan], None]
    export_one: Callable[[argparse.Namespace, ExportPlan, str], None]
    submit: Callable[[Iterable[ShotToExport]], None]
    export_frames: Callable[[argparse.Namespace, ExportPlan], FinishedFrames]


def export_reel(args: argparse.Namespace, work: ReelActions) -> None:
    """Export the reel `args.shot`.

    Every shot is planned before the first frame is made; missing files are therefore reported at
    once.
    """
    reel = read_given_reel(args, args.shot)
    check_for_export(args, reel)
    for shot in reel.shots:
        print_messages(*(f"{shot.name}: {note}." for note in shot.notes))
    if SHOT_FIELD not in args.output:
        _export_cut(args, reel, work)
        return
    if args.edit_out is not None:
        check_edit_out(args.edit_out)
    with gather_messages(len(reel.shots)):
        jobs = [
            (shot, shot_args, make_export_job(shot_args))
            for shot, shot_args in shots_with_options(args, reel, args.output)
        ]
    if args.submit is not None:
        work.submit(
            (shot_args, plan_export(job, job.frames), shot.name) for shot, shot_args, job in jobs
        )
        return
    make_folder(Path(args.output.partition(SHOT_FIELD)[0] + SHOT_FIELD).parent)
    plans = [(shot, shot_args, plan_export(job)) for shot, shot_args, job in jobs]
    with gather_messages(len(reel.shots)):
        for _, shot_args, plan in plans:
            work.print_notes(shot_args, plan)
    for shot, shot_args, plan in plans:
        work.export_one(shot_args, plan, shot.name)
    if args.edit_out is not None:
        write_edit(
            args.edit_out,
            reel,
            _exported_shots(reel, [(shot, plan.job) for shot, _, plan in plans]),
        )
        print_result(str(args.edit_out))


def _export_cut(args: argparse.Namespace, reel: Reel, work: ReelActions) -> None:
    """Export all shots as one movie, or submit that work to a farm with --submit."""
    refuse_options(args, _NOT_FOR_CUTS, "This is not possible with one movie of a cut")
    output = parse_output(args.output)
    check_folder(output.pattern)
    parts, shots = [], []
    with gather_messages(len(reel.shots)):
        for number, (shot, shot_args) in enumerate(
            shots_with_options(args, reel, args.output), start=1
        ):
            job = replace(
                make_export_job(shot_args), output=kept_frames_output(output, number, shot.name)
            )
            parts.append(plan_export(job, job.frames))
            shots.append((shot_args, parts[-1], shot.name))
    if args.submit is not None:
        work.submit(shots)
        return
    cut, count = Cut(reel, output, tuple(parts)), sum(len(plan.frames) for plan in parts)
    print_messages(
        *filter(
            None,
            (
                find_sound_in_cut(cut, plan, shot_number)[1]
                for shot_number, plan in enumerate(parts)
            ),
        )
    )
    with (
        progress_line() as show,
        closing(
            export_cut(cut, lambda shot_number: work.export_frames(*shots[shot_number][:2]))
        ) as steps,
    ):
        for number, (shot_number, done) in enumerate(steps, start=1):
            show(f"{shots[shot_number][2]}, frame {done.frame}, {number} of {count} done")
    print_result(str(output.pattern))


def _exported_shots(reel: Reel, jobs: list[tuple[ReelShot, ExportJob]]) -> dict[str, ExportedShot]:
    """Return the exported files and frames of each shot, by its name, for the edit."""
    exported = {}
    for reel_shot, (shot, job) in zip(reel.shots, jobs, strict=True):
        frames = FrameRange(job.frames[0], job.frames[-1])
        if job.output.is_movie:
            raise InputError("--edit-out is for exported frames, not for movies of the shots.")
        cut_frames = reel_shot.frames or frames
        folder, form = job.output.folder, job.output.form
        exported[shot.name] = ExportedShot(
            shot=job.shot,
            folder=folder,
            form=form,
            frames=frames,
            cut=cut_frames,
            retime=reel_shot.retime,
        )
    return exported
