"""Write an export as a job for several machines: `heatlens export --submit`."""

import argparse
import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.commands.export_options import add_export_options
from heatlens.commands.options.given_options import given
from heatlens.commands.output.say import say, tell
from heatlens.documents.lens_kits import kit_shelf
from heatlens.documents.shot_file import is_shot_file
from heatlens.export.finished import check_replaced
from heatlens.export.movie import check_display
from heatlens.export.plan import ExportPlan
from heatlens.farm.inputs import config_files, files_beside, folder_of_source, images_of, plain_path
from heatlens.farm.job import (
    FRAMES,
    FarmJob,
    Needs,
    Place,
    Word,
    located,
    parts_of,
    topmost,
)
from heatlens.farm.measure import measured
from heatlens.farm.openjd import job_template, relative_to, write_bundle
from heatlens.farm.slurm import slurm_script
from heatlens.model.opening_image import OpeningImage
from heatlens.sequence.names import frames_text

# Options that are set for each task, or are useless there.
_REPLACED = (
    *("--frames", "--plate", "--ocio", "--progress", "--submit", "--bundle", "--moved"),
    *("--chunk", "--memory", "--cpus", "--gpus", "--part", "--cluster", "--fetch"),
    "--processes",
)
ENGINES: dict[str, Callable[[FarmJob], str]] = {
    "openjd": lambda job: job_template(job, Path.cwd()),
    "slurm": slurm_script,
}
_HOW: dict[str, Callable[[], str]] = {
    "openjd": lambda: f"Keep the template in {Path.cwd()}",
    "slurm": lambda: "Run the script with sh where Slurm takes jobs.",
}
_CPUS = 2  # a task of a small plate fits a small node
_FILES = ("--depth", "--behind", "--aperture-image")  # options that name files


def submit(args: argparse.Namespace, plan: ExportPlan) -> None:
    """Print the job, or write its bundle, and say how to use it."""
    check_replaced(plan)
    _check(args, plan)
    job = _measured_job(args, plan)
    count = f"{len(plan.job.frames)} frames in {len(job.parts)} tasks"
    if args.bundle is not None:
        write_bundle(job, args.bundle)
        say(f"{count}. Submit them with: deadline bundle submit {args.bundle}")
        tell(str(args.bundle))
        return
    print(ENGINES[args.submit](job), end="")
    say(f"{count}. {_HOW[args.submit]()}")
    for place in job.places if args.submit == "openjd" else ():
        if relative_to(place, Path.cwd()) is None:
            told = f"-p {place.name}={place.path}"
            say(f"the template cannot hold this path; give it on submission: {told}")


def _check(args: argparse.Namespace, plan: ExportPlan) -> None:
    if args.bundle is not None and args.submit != "openjd":
        raise InputError("--bundle is for --submit openjd.")
    check_elsewhere(args, plan)


def check_elsewhere(args: argparse.Namespace, plan: ExportPlan) -> None:
    """Raise InputError for what only this process could make."""
    if args.lens_kit is not None and args.lens_kit.partition(":")[0] in kit_shelf().own:
        raise InputError(
            f"--lens-kit {args.lens_kit}: other machines may lack this kit. Put it into a shot, "
            "which stores its kit: heatlens shot new --lens-kit."
        )
    if plan.job.output.is_movie:
        check_display(plan.job)
    if plan.job.output.is_movie and plan.job.options.force:
        raise InputError(
            f"--force would render the frames of the parts again for the movie: delete "
            f"{plan.job.output.pattern} instead."
        )


def _measured_job(args: argparse.Namespace, plan: ExportPlan) -> FarmJob:
    """Return the job. The first frames are rendered to find a --chunk or --memory not given."""
    job, cost = farm_job(args, plan), None
    if args.chunk is None or args.memory is None:
        say("rendering two frames to measure what a task needs; --chunk with --memory skips this")
        cost = measured(job, plan.job.output.form.text, plan.job.frames)
        say(f"a frame takes {cost.frame_s:.2g} s here, and a task {cost.memory_bytes / 1e9:.1f} GB")
    memory = cost.memory_gib if cost is not None and args.memory is None else args.memory
    parts = parts_of(plan.job.frames, args.chunk, cost)
    return replace(job, parts=parts, needs=replace(job.needs, memory_gib=memory))


def farm_job(args: argparse.Namespace, plan: ExportPlan) -> FarmJob:
    """Return the job of an export as a single part, without the memory that it needs."""
    config = None if plan.job.output.is_exr else args.ocio or os.environ.get("OCIO") or None
    tables = config_files(config)
    beside = files_beside(plan)
    shot = (plain_path(args.shot),) if is_shot_file(args.shot) else ()
    places = (
        *(Place("Shot", path, "FILE", "IN") for path in shot),
        *_folders(plan, beside),
        Place("Out", plain_path(plan.job.output.folder), "DIRECTORY", "OUT"),
        *(Place("Config", path, "FILE", "IN") for path in tables[:1]),
    )
    return FarmJob(
        name=plan.job.output.form.text,
        places=places,
        words=tuple(_words(args, plan, places, config)),
        parts=(frames_text(plan.job.frames),),
        joins=plan.job.output.is_movie or args.after_export is not None,
        needs=Needs(processors=args.cpus or _CPUS, gpus=args.gpus or 0),
        inputs=(*shot, *beside, *tables),
        last=() if args.after_export is None else ((f"--after-export={args.after_export}",),),
    )


def task_words(args: argparse.Namespace, plan: ExportPlan) -> tuple[Word, ...]:
    """Return the command line with which another process makes frames of this export."""
    check_elsewhere(args, plan)
    return farm_job(args, plan).words[:-1]


def _folders(plan: ExportPlan, files: Iterable[Path]) -> Iterator[Place]:
    """Yield the folder of the plates, then those of other files, each with all that lies below."""
    plates = folder_of_source(plan)
    tops = topmost((*(() if plates is None else (plates,)), *(path.parent for path in files)))
    others = 1
    for folder in tops:
        is_first = plates is not None and (folder == plates or folder in plates.parents)
        others += not is_first
        name = "Plates" if is_first else "Files" if others == 2 else f"Files{others - 1}"
        yield Place(name, folder, "DIRECTORY", "IN")


def _words(
    args: argparse.Namespace, plan: ExportPlan, places: tuple[Place, ...], config: str | None
) -> Iterator[Word]:
    """Yield the words of a task."""
    source, output = plan.source.files, plain_path(plan.job.output.pattern)
    # A source without files is the built-in scene, which exists on every machine.
    name, shot = str(plan.job.shot.source), is_shot_file(args.shot)
    lead = "--plate=" if shot else ""
    yield ("export",)
    if shot:
        yield located(places, "", plain_path(args.shot))
    yield (lead + name,) if source is None else located(places, lead, plain_path(source))
    yield located(places, "--output=", output)
    if shot and (plan.job.shot.plate_options.files_beside or images_of(plan.job.shot)):
        yield from _moved(plain_path(args.shot).parent, places)
    yield from _given_words(args, places)
    if config is not None and Path(config).is_file():
        yield located(places, "--ocio=", plain_path(config))
    elif config is not None:
        yield (f"--ocio={config}",)
    yield (f"--frames={frames_text(plan.job.frames)}",)
    yield ("--part=", FRAMES)


def _moved(folder: Path, places: Iterable[Place]) -> Iterator[Word]:
    """Yield --moved for each folder that a shot in `folder` names, relative and absolute."""
    for place in places:
        if place.kind == "DIRECTORY" and place.flow == "IN":
            for old in (os.path.relpath(place.path, folder), str(place.path)):
                yield from (("--moved",), (old,), (place,))


def _given_words(args: argparse.Namespace, places: Iterable[Place]) -> Iterator[Word]:
    """Yield the given options as they would be typed."""
    for option, values in given(args, add_export_options).items():
        for value in values if isinstance(values, list) else [values]:  # one given several times
            if option in _FILES:
                name = value.path if isinstance(value, OpeningImage) else str(value)
                yield located(places, f"{option}=", plain_path(name))
            elif option not in _REPLACED:
                yield (option,) if value is True else (f"{option}={_typed(value)}",)


def _typed(value: object) -> str:
    """Return a value of an option as it was typed: 320x180 for a size."""
    return "x".join(map(str, value)) if isinstance(value, tuple) else str(value)
