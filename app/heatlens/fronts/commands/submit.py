"""Write an export as a job for several machines: `heatlens export --submit`."""

import argparse
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.reel import SHOT_FIELD
from heatlens.deliver.export.finished import check_may_replace
from heatlens.deliver.export.movie import check_display
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import ExportPlan
from heatlens.deliver.farm.inputs import absolute_path, config_files, folder_of_source, input_files
from heatlens.deliver.farm.job import (
    FRAMES,
    FarmJob,
    Needs,
    Place,
    Step,
    Word,
    group_frames,
    measure_first_frames,
    topmost_folders,
)
from heatlens.deliver.farm.openjd import job_template, relative_to, write_bundle
from heatlens.deliver.farm.slurm import slurm_script
from heatlens.fronts.commands.options.farm_options import expected_program
from heatlens.fronts.commands.options.job_words import JobWords
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.media.documents.lens_kits import kit_shelf
from heatlens.media.documents.reel_file import is_reel
from heatlens.media.documents.shot_file import is_shot_file
from heatlens.media.sequence.names import frames_text

ENGINES: dict[str, Callable[[FarmJob], str]] = {
    "openjd": lambda job: job_template(job, Path.cwd()),
    "slurm": slurm_script,
}
_INSTRUCTIONS: dict[str, Callable[[], str]] = {
    "openjd": lambda: f"Keep the template in {Path.cwd()}",
    "slurm": lambda: "Run the script with sh where Slurm takes jobs.",
}
_MOST_NAME_LETTERS = 40  # of a shot, in the name of a step, which may have 64 characters
_DEFAULT_CPUS = 2  # a task of a small plate fits a small node


@dataclass(frozen=True)
class SubmittedShot:
    """A shot of a job; `args` are the options of its own export, `name` is "" without a reel."""

    args: argparse.Namespace
    plan: ExportPlan
    name: str = ""


def submit(args: argparse.Namespace, shots: Sequence[SubmittedShot]) -> None:
    """Print the job that exports all shots, or write its bundle, and print how to use it."""
    for shot in shots:
        check_may_replace(shot.plan)
    _check_job(args, shots)
    job = _job_with_measured_cost(args, shots)
    frames = sum(len(shot.plan.job.frames) for shot in shots)
    tasks = job.count - (job.last is not None)
    summary = f"{frames} frames in {tasks} task{'' if tasks == 1 else 's'}"
    if args.bundle is not None:
        write_bundle(job, args.bundle)
        print_messages(f"{summary}. Submit them with: deadline bundle submit {args.bundle}")
        print_result(str(args.bundle))
        return
    print(ENGINES[args.submit](job), end="")
    print_messages(f"{summary}. {_INSTRUCTIONS[args.submit]()}")
    for place in job.places if args.submit == "openjd" else ():
        if relative_to(place, Path.cwd()) is None:
            option = f"-p {place.name}={place.path}"
            print_messages(f"the template cannot hold this path; give it on submission: {option}")


def _check_job(args: argparse.Namespace, shots: Iterable[SubmittedShot]) -> None:
    """Raise InputError for a bundle of another engine, and for shots that need this machine."""
    if args.bundle is not None and args.submit != "openjd":
        raise InputError("--bundle is for --submit openjd.")
    for shot in shots:
        check_other_machines(args, shot.plan)


def check_other_machines(args: argparse.Namespace, plan: ExportPlan) -> None:
    """Raise InputError for an export that other processes or machines could not make."""
    if args.lens_kit is not None and args.lens_kit.partition(":")[0] in kit_shelf().own:
        raise InputError(
            f"--lens-kit {args.lens_kit}: other machines may lack this kit. Put it into a shot, "
            "which stores its kit: heatlens shot new --lens-kit."
        )
    if plan.job.output.is_movie:
        check_display(plan.job)
    if plan.job.output.is_movie and plan.job.options.force:
        raise InputError(
            f"--force would render every frame once more where the movie is joined: leave it out, "
            f"and delete {plan.job.output.pattern} first."
        )


def _job_with_measured_cost(args: argparse.Namespace, shots: Sequence[SubmittedShot]) -> FarmJob:
    """Return the job with frames and memory for each task.

    Without --chunk and --memory, three frames of the first shot are rendered to measure them.
    """
    job, first_job, cost = farm_job(args, shots), shots[0].plan.job, None
    if args.chunk is None or args.memory is None:
        print_messages(
            "rendering three frames to measure what a task needs; --chunk with --memory skips this"
        )
        cost = measure_first_frames(job, first_job.output.form.text, first_job.frames)
        print_messages(
            f"a frame takes {cost.frame_s:.2g} s here, and a task {cost.memory_bytes / 1e9:.1f} GB"
        )
    memory = cost.memory_gib if cost is not None and args.memory is None else args.memory
    steps = tuple(
        replace(step, parts=group_frames(shot.plan.job.frames, args.chunk, cost))
        for step, shot in zip(job.steps, shots, strict=True)
    )
    return replace(job, steps=steps, needs=replace(job.needs, memory_gib=memory))


def farm_job(args: argparse.Namespace, shots: Sequence[SubmittedShot]) -> FarmJob:
    """Return the job with a step for each shot, each of one task; its memory is unknown yet."""
    expected = None if args.submit is None else expected_program(on_gpus=bool(args.gpus))
    config = None
    if not shots[0].plan.job.output.is_exr:
        config = args.ocio or os.environ.get("OCIO") or None
    color_files = config_files(config)
    input_paths = [path for shot in shots for path in input_files(shot.plan)]
    shot_files = _files_of_shots(args, shots)
    places = (*_places(args, shots, shot_files, input_paths), *_config_place(color_files))
    words = JobWords(places, config, expected)
    return FarmJob(
        name=(Path(args.shot) if is_reel(args.shot) else shots[0].plan.job.output.pattern).name,
        places=places,
        steps=tuple(_export_step(number, shot, words) for number, shot in enumerate(shots, 1)),
        last=_join_step(args, shots[0], words),
        needs=Needs(processors=args.cpus or _DEFAULT_CPUS, gpus=args.gpus or 0),
        inputs=tuple(dict.fromkeys((*shot_files, *input_paths, *color_files))),
    )


def _places(
    args: argparse.Namespace,
    shots: Sequence[SubmittedShot],
    files: Sequence[Path],
    input_paths: list[Path],
) -> Iterator[Place]:
    """Yield the places that may differ between machines: shot file, folders and output."""
    has_reel = bool(shots[0].name)
    if files and not has_reel:
        yield Place("Shot", files[0], "FILE", "IN")
    yield from _folder_places(shots, (*input_paths, *(files if has_reel else ())))
    output = absolute_path(args.output.partition(SHOT_FIELD)[0] + "_").parent
    yield Place("Out", output, "DIRECTORY", "OUT")


def _config_place(color_files: Sequence[Path]) -> Iterator[Place]:
    """Yield the place of the first of these files of a color configuration, if there are any."""
    if color_files:
        yield Place("Config", color_files[0], "FILE", "IN")


def task_words(args: argparse.Namespace, plan: ExportPlan) -> tuple[Word, ...]:
    """Return the command line with which another process makes frames of this export."""
    check_other_machines(args, plan)
    return farm_job(args, [SubmittedShot(args, plan)]).steps[0].words[:-1]


def _files_of_shots(args: argparse.Namespace, shots: Iterable[SubmittedShot]) -> tuple[Path, ...]:
    """Return the shot files, and the reel or edit that names them."""
    names = (args.shot, *(shot.args.shot for shot in shots))
    files = (absolute_path(name) for name in names if is_shot_file(name) or is_reel(name))
    return tuple(dict.fromkeys(files))


def _folder_places(shots: Sequence[SubmittedShot], files: Iterable[Path]) -> Iterator[Place]:
    """Yield the folders of the plates and of other files, without folders inside others.

    The shots of a reel share one folder if possible, to keep the relative paths between them.
    """
    plate_folders = (folder_of_source(shot.plan) for shot in shots)
    distinct_plate_folders = [
        folder for folder in dict.fromkeys(plate_folders) if folder is not None
    ]
    top_folders = topmost_folders((*distinct_plate_folders, *(path.parent for path in files)))
    if shots[0].name:
        common = Path(os.path.commonpath(top_folders)) if top_folders else Path()
        top_folders = top_folders if common == common.parent else (common,)
    counts = {"Plates": 0, "Files": 0}
    for folder in top_folders:
        kind = (
            "Plates"
            if any(folder in (it, *it.parents) for it in distinct_plate_folders)
            else "Files"
        )
        counts[kind] += 1
        name = kind if counts[kind] == 1 else f"{kind}{counts[kind]}"
        yield Place(name, folder, "DIRECTORY", "IN")


def _export_step(number: int, shot: SubmittedShot, words: JobWords) -> Step:
    """Return the step that exports a shot, with all of its frames as one task."""
    name = f"Export {number:03} {shot.name[:_MOST_NAME_LETTERS]}" if shot.name else "Export"
    command = (*words.shot_command(shot.args, shot.plan), ("--part=", FRAMES))
    return Step(name, command, (frames_text(shot.plan.job.frames),))


def _join_step(args: argparse.Namespace, first: SubmittedShot, words: JobWords) -> Step | None:
    """Return the task that exports again once all frames are finished; None if not needed."""
    if not (parse_output(args.output).is_movie or args.after_export or args.edit_out):
        return None
    command = words.reel_command(args) if first.name else words.shot_command(args, first.plan)
    after_export = ((f"--after-export={args.after_export}",),) if args.after_export else ()
    return Step("Join", (*command, *after_export))
