"""Write an export as a job for several machines: `heatlens export --submit`."""

import argparse
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.reel import SHOT_FIELD
from heatlens.deliver.export.finished import check_replaced
from heatlens.deliver.export.movie import check_display
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import ExportPlan
from heatlens.deliver.farm.inputs import (
    config_files,
    files_beside,
    folder_of_source,
    images_of,
    plain_path,
)
from heatlens.deliver.farm.job import (
    FRAMES,
    FarmJob,
    Needs,
    Place,
    Step,
    Word,
    located,
    measured,
    parts_of,
    topmost,
)
from heatlens.deliver.farm.openjd import job_template, relative_to, write_bundle
from heatlens.deliver.farm.slurm import slurm_script
from heatlens.fronts.commands.export_options import add_export_options
from heatlens.fronts.commands.options.farm_options import program_of_tasks
from heatlens.fronts.commands.options.given_options import given
from heatlens.fronts.commands.output.say import say, tell
from heatlens.media.documents.lens_kits import kit_shelf
from heatlens.media.documents.reel_file import REEL_SUFFIX, is_reel
from heatlens.media.documents.shot_file import is_shot_file
from heatlens.media.sequence.names import frames_text

ENGINES: dict[str, Callable[[FarmJob], str]] = {
    "openjd": lambda job: job_template(job, Path.cwd()),
    "slurm": slurm_script,
}
_HOW: dict[str, Callable[[], str]] = {
    "openjd": lambda: f"Keep the template in {Path.cwd()}",
    "slurm": lambda: "Run the script with sh where Slurm takes jobs.",
}
_NAME_MOST = 40  # of a shot, in the name of a step, which may have 64 characters
_CPUS = 2  # a task of a small plate fits a small node

# Options that are set for each task, or are useless there.
_REPLACED = (
    *("--frames", "--plate", "--ocio", "--progress", "--submit", "--bundle", "--moved"),
    *("--chunk", "--memory", "--cpus", "--gpus", "--part", "--cluster", "--fetch"),
    *("--processes", "--device", "--expect"),
)
_FILES = ("--depth", "--behind", "--aperture-image")  # options that name files


@dataclass(frozen=True)
class JobWords:
    """Makes the command lines of one job.

    config    the OpenColorIO config of pictures and movies
    expected  version and driver that the job was written with, see `--expect`
    """

    places: tuple[Place, ...]
    config: str | None
    expected: str | None

    def of_shot(self, args: argparse.Namespace, plan: ExportPlan) -> Iterator[Word]:
        """Yield the words of the export of a shot."""
        job = plan.job
        source, output = plan.source.files, plain_path(job.output.pattern)
        # A source without files is the built-in scene, which exists on every machine.
        name, has_file = str(job.shot.source), is_shot_file(args.shot)
        lead = "--plate=" if has_file else ""
        yield ("export",)
        if has_file:
            yield self._at("", args.shot)
        yield (lead + name,) if source is None else self._at(lead, source)
        yield self._at("--output=", output, "OUT")
        if has_file and (job.shot.plate_options.files_beside or images_of(job.shot)):
            yield from self._moved(plain_path(args.shot).parent)
        yield from self._given(args)
        yield (f"--frames={frames_text(job.frames)}",)

    def of_reel(self, args: argparse.Namespace) -> Iterator[Word]:
        """Yield the words of the export of a whole reel."""
        yield from (("export",), self._at("", args.shot), self._at("--output=", args.output, "OUT"))
        yield from (self._at("--media=", folder) for folder in args.media)
        if not args.shot.lower().endswith(REEL_SUFFIX):  # an edit, which may name absolute paths
            yield from (("--media=", folder) for folder in self._folders)
        if args.edit_out is not None:
            yield self._at("--edit-out=", args.edit_out, "OUT")
        numbers = {"--edit-fps": args.edit_fps, "--handles": args.handles}
        yield from ((f"{option}={value:g}",) for option, value in numbers.items() if value)
        yield from self._given(args)

    def _at(self, lead: str, path: str | os.PathLike[str], flow: str = "IN") -> Word:
        """Return a word that ends with a path; what is written may lie in a folder that is read."""
        return located([it for it in self.places if it.flow == flow], lead, plain_path(path))

    @property
    def _folders(self) -> list[Place]:
        return [it for it in self.places if it.kind == "DIRECTORY" and it.flow == "IN"]

    def _moved(self, folder: Path) -> Iterator[Word]:
        """Yield --moved for each folder that a shot in `folder` names, relative and absolute."""
        for place in self._folders:
            for old in (os.path.relpath(place.path, folder), str(place.path)):
                yield from (("--moved",), (old,), (place,))

    def _given(self, args: argparse.Namespace) -> Iterator[Word]:
        """Yield the given options as they would be typed, and what is the same for all tasks."""
        for option, values in given(args, add_export_options).items():
            for value in values if isinstance(values, list) else [values]:  # given several times
                if option in _FILES:
                    name = value.path if isinstance(value, OpeningImage) else str(value)
                    yield self._at(f"{option}=", name)
                elif option not in _REPLACED:
                    yield (option,) if value is True else (f"{option}={_typed(value)}",)
        if self.config is not None:
            has_file = Path(self.config).is_file()
            yield self._at("--ocio=", self.config) if has_file else (f"--ocio={self.config}",)
        if self.expected is not None:
            yield (f"--expect={self.expected}",)


def _typed(value: object) -> str:
    """Return a value of an option as it was typed: 320x180 for a size."""
    return "x".join(map(str, value)) if isinstance(value, tuple) else str(value)


@dataclass(frozen=True)
class SentShot:
    """A shot of a job; `args` are the options of its own export, `name` is "" without a reel."""

    args: argparse.Namespace
    plan: ExportPlan
    name: str = ""


def submit(args: argparse.Namespace, shots: Sequence[SentShot]) -> None:
    """Print the job that exports all shots, or write its bundle, and say how to use it."""
    for shot in shots:
        check_replaced(shot.plan)
    _check(args, shots)
    job = _measured_job(args, shots)
    frames = sum(len(shot.plan.job.frames) for shot in shots)
    tasks = job.count - (job.last is not None)
    count = f"{frames} frames in {tasks} task{'' if tasks == 1 else 's'}"
    if args.bundle is not None:
        write_bundle(job, args.bundle)
        say(f"{count}. Submit them with: deadline bundle submit {args.bundle}")
        tell(str(args.bundle))
        return
    print(ENGINES[args.submit](job), end="")
    say(f"{count}. {_HOW[args.submit]()}")
    for place in job.places if args.submit == "openjd" else ():
        if relative_to(place, Path.cwd()) is None:
            option = f"-p {place.name}={place.path}"
            say(f"the template cannot hold this path; give it on submission: {option}")


def _check(args: argparse.Namespace, shots: Iterable[SentShot]) -> None:
    if args.bundle is not None and args.submit != "openjd":
        raise InputError("--bundle is for --submit openjd.")
    for shot in shots:
        check_elsewhere(args, shot.plan)


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


def _measured_job(args: argparse.Namespace, shots: Sequence[SentShot]) -> FarmJob:
    """Return the job. Frames of the first shot are rendered to find a --chunk or --memory."""
    job, first, cost = farm_job(args, shots), shots[0].plan.job, None
    if args.chunk is None or args.memory is None:
        say("rendering two frames to measure what a task needs; --chunk with --memory skips this")
        cost = measured(job, first.output.form.text, first.frames)
        say(f"a frame takes {cost.frame_s:.2g} s here, and a task {cost.memory_bytes / 1e9:.1f} GB")
    memory = cost.memory_gib if cost is not None and args.memory is None else args.memory
    steps = tuple(
        replace(step, parts=parts_of(shot.plan.job.frames, args.chunk, cost))
        for step, shot in zip(job.steps, shots, strict=True)
    )
    return replace(job, steps=steps, needs=replace(job.needs, memory_gib=memory))


def farm_job(args: argparse.Namespace, shots: Sequence[SentShot]) -> FarmJob:
    """Return the job, with the frames of a shot as one part, without the memory that it needs."""
    expected = None if args.submit is None else program_of_tasks(on_gpus=bool(args.gpus))
    config = None
    if not shots[0].plan.job.output.is_exr:
        config = args.ocio or os.environ.get("OCIO") or None
    tables = config_files(config)
    beside = [path for shot in shots for path in files_beside(shot.plan)]
    files = _files_of_shots(args, shots)
    places = (*_places(args, shots, files, beside), *_place_of_config(tables))
    words = JobWords(places, config, expected)
    return FarmJob(
        name=(Path(args.shot) if is_reel(args.shot) else shots[0].plan.job.output.pattern).name,
        places=places,
        steps=tuple(_step(number, shot, words) for number, shot in enumerate(shots, 1)),
        last=_last(args, shots[0], words),
        needs=Needs(processors=args.cpus or _CPUS, gpus=args.gpus or 0),
        inputs=tuple(dict.fromkeys((*files, *beside, *tables))),
    )


def _places(
    args: argparse.Namespace, shots: Sequence[SentShot], files: Sequence[Path], beside: list[Path]
) -> Iterator[Place]:
    """Yield what a machine may have elsewhere: the shot file or folders, and the output."""
    is_of_reel = bool(shots[0].name)
    if files and not is_of_reel:
        yield Place("Shot", files[0], "FILE", "IN")
    yield from _folders(shots, (*beside, *(files if is_of_reel else ())))
    output = plain_path(args.output.partition(SHOT_FIELD)[0] + "_").parent
    yield Place("Out", output, "DIRECTORY", "OUT")


def _place_of_config(tables: Sequence[Path]) -> Iterator[Place]:
    if tables:
        yield Place("Config", tables[0], "FILE", "IN")


def task_words(args: argparse.Namespace, plan: ExportPlan) -> tuple[Word, ...]:
    """Return the command line with which another process makes frames of this export."""
    check_elsewhere(args, plan)
    return farm_job(args, [SentShot(args, plan)]).steps[0].words[:-1]


def _files_of_shots(args: argparse.Namespace, shots: Iterable[SentShot]) -> tuple[Path, ...]:
    """Return the shot files, and the reel or edit that names them."""
    named = (args.shot, *(shot.args.shot for shot in shots))
    files = (plain_path(name) for name in named if is_shot_file(name) or is_reel(name))
    return tuple(dict.fromkeys(files))


def _folders(shots: Sequence[SentShot], files: Iterable[Path]) -> Iterator[Place]:
    """Yield the folder of the plates, then those of other files, each with all that lies below.

    The files of several shots keep their places to each other, in one folder if possible.
    """
    of_plates = (folder_of_source(shot.plan) for shot in shots)
    plates = [folder for folder in dict.fromkeys(of_plates) if folder is not None]
    tops = topmost((*plates, *(path.parent for path in files)))
    if shots[0].name:
        common = Path(os.path.commonpath(tops)) if tops else Path()
        tops = tops if common == common.parent else (common,)
    counts = {"Plates": 0, "Files": 0}
    for folder in tops:
        kind = "Plates" if any(folder in (it, *it.parents) for it in plates) else "Files"
        counts[kind] += 1
        name = kind if counts[kind] == 1 else f"{kind}{counts[kind]}"
        yield Place(name, folder, "DIRECTORY", "IN")


def _step(number: int, shot: SentShot, words: JobWords) -> Step:
    """Return the frames of a shot as one task."""
    name = f"Export {number:03} {shot.name[:_NAME_MOST]}" if shot.name else "Export"
    made = (*words.of_shot(shot.args, shot.plan), ("--part=", FRAMES))
    return Step(name, made, (frames_text(shot.plan.job.frames),))


def _last(args: argparse.Namespace, first: SentShot, words: JobWords) -> Step | None:
    """Return the task that waits for all frames: the same export, which finds them finished."""
    if not (parse_output(args.output).is_movie or args.after_export or args.edit_out):
        return None
    made = words.of_reel(args) if first.name else words.of_shot(args, first.plan)
    after = ((f"--after-export={args.after_export}",),) if args.after_export else ()
    return Step("Join", (*made, *after))
