"""`heatlens export --submit`: write the export as a job for a render farm instead of doing it."""

import argparse
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.commands.export_options import add_export_options
from heatlens.commands.options.given_options import given
from heatlens.commands.output.say import say
from heatlens.documents.shot_file import is_shot_file
from heatlens.export.openjd import PathParameter, chunks_of, job_template
from heatlens.export.plan import ExportPlan
from heatlens.export.replaced import check_replaced

_CHUNK = 10  # frames per task: enough that the start-up time does not matter
# Options that are set for each task, or are useless there.
_REPLACED = ("--frames", "--plate", "--ocio", "--progress", "--submit", "--chunk")


def submit(args: argparse.Namespace, plan: ExportPlan) -> None:
    """Print the template, and notes on how to use it."""
    if plan.job.output.is_movie:
        raise InputError(
            "A movie is one file, and cannot be made in chunks: submit EXR or PNG frames."
        )
    check_replaced(plan)
    paths = _paths(args, plan)
    chunks = chunks_of(plan.job.frames, _CHUNK if args.chunk is None else args.chunk)
    name = plan.job.output.form.text
    template = job_template(name, paths, _words(args, plan), chunks, Path.cwd())
    _check_text(template)
    print(template, end="")
    say(f"{len(plan.job.frames)} frames in {len(chunks)} tasks. Keep the template in {Path.cwd()}")
    for path in paths:
        if path.relative_to(Path.cwd()) is None:
            say(f"it cannot hold this path, so give it on submission: -p {path.name}={path.path}")


def _paths(args: argparse.Namespace, plan: ExportPlan) -> list[PathParameter]:
    paths = [PathParameter("Out", plan.job.output.folder.absolute(), "DIRECTORY", "OUT")]
    if plan.source.files is not None:
        plates = plan.source.files.parent.absolute()
        paths.insert(0, PathParameter("Plates", plates, "DIRECTORY", "IN"))
    if is_shot_file(args.shot):
        paths.insert(0, PathParameter("Shot", Path(args.shot).absolute(), "FILE", "IN"))
    if _is_config_file(args):
        paths.append(PathParameter("Config", Path(args.ocio).absolute(), "FILE", "IN"))
    return paths


def _words(args: argparse.Namespace, plan: ExportPlan) -> list[str]:
    """Return the command line of a task."""
    source, files = plan.source.files, plan.job.output.form.text
    options = _given_words(args)
    if any("{{" in text for text in (source.name if source else "", files, *options)):
        raise InputError("A template cannot hold a name or an option with {{ in it.")
    output = f"{{{{Param.Out}}}}/{files}"
    # A source without files is the built-in scene, which exists on every machine.
    plates = f"{{{{Param.Plates}}}}/{source.name}" if source else str(plan.job.shot.source)
    shot = ["{{Param.Shot}}", f"--plate={plates}"] if is_shot_file(args.shot) else [plates]
    ocio = "{{Param.Config}}" if _is_config_file(args) else args.ocio
    return [
        *("export", *shot, f"--output={output}"),
        *options,
        *([] if ocio is None else [f"--ocio={ocio}"]),
        *("--frames={{Task.Param.Frames}}", "--progress=openjd"),
    ]


def _given_words(args: argparse.Namespace) -> list[str]:
    """Return the given options as they would be typed."""
    return [
        option if value is True else f"{option}={_typed(value)}"
        for option, values in given(args, add_export_options).items()
        for value in (values if isinstance(values, list) else [values])  # one given several times
        if option not in _REPLACED
    ]


def _typed(value: object) -> str:
    """Return a value of an option as it was typed: 320x180 for a size."""
    return "x".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _is_config_file(args: argparse.Namespace) -> bool:
    return args.ocio is not None and not args.ocio.startswith("ocio://")


def _check_text(template: str) -> None:
    """Raise InputError for characters that YAML cannot hold, as a name on disk may have them."""
    if not template.replace("\n", "").isprintable():
        raise InputError(
            "A template takes printable names only, and one of these is not. Rename the file."
        )
