"""The options of an export that several processes or machines make.

This machine's heatlens and graphics driver are compared with those where a job was written: another
version or driver, such as software beside a GPU, may give slightly other pictures.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

from heatlens.core.base.errors import GpuError, InputError
from heatlens.deliver.export.plan import ExportPlan
from heatlens.fronts.commands.options.device_option import add_device_option
from heatlens.fronts.commands.options.value_types import parse_whole_number
from heatlens.fronts.commands.output.say import print_messages
from heatlens.render.frame_renderer import FrameRenderer, headless_renderer
from heatlens.render.gpu.context import headless_context, is_software
from heatlens.version import __version__


def add_farm_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose who makes the frames of an export, here or elsewhere."""
    group = parser.add_argument_group("render farm")
    _add_job_options(group)
    _add_worker_options(group)


def _add_job_options(group: "argparse._ArgumentGroup") -> None:
    """Add the options that describe a job for other machines."""
    group.add_argument(
        "--submit",
        choices=("openjd", "slurm"),
        help="print the export as a job instead of rendering: openjd, a template of Open Job "
        "Description (YAML); slurm, a shell script that submits it to Slurm",
    )
    group.add_argument(
        "--bundle",
        type=Path,
        metavar="FOLDER",
        help="with openjd: write a job bundle that lists the parameter values and all files to "
        "read, for AWS Deadline Cloud",
    )
    group.add_argument(
        "--chunk",
        type=parse_whole_number,
        metavar="N",
        help="frames of each task (default: about a minute of work, measured by rendering two "
        "frames here)",
    )
    group.add_argument(
        "--memory",
        type=parse_whole_number,
        metavar="GIB",
        help="memory of each task (default: measured in the same way, rounded up)",
    )
    group.add_argument("--expect", metavar="VERSION/DRIVER", help=argparse.SUPPRESS)
    group.add_argument(
        "--cpus", type=parse_whole_number, metavar="N", help="processors of a task (default 2)"
    )
    group.add_argument(
        "--gpus", type=parse_whole_number, metavar="N", help="GPUs of each task (default 0)"
    )


def _add_worker_options(group: "argparse._ArgumentGroup") -> None:
    """Add the options that choose who makes the frames now, and which frames."""
    group.add_argument(
        "--processes",
        type=parse_whole_number,
        metavar="N",
        help="render with N processes on this machine, which uses many processors better",
    )
    add_device_option(group, has_processes=True)
    group.add_argument(
        "--cluster",
        metavar="tcp://HOST:8786",
        help="render with the workers of this Dask scheduler; `heatlens worker` starts one",
    )
    group.add_argument("--agreed", metavar="NAME@HOST", help=argparse.SUPPRESS)
    group.add_argument(
        "--fetch",
        action="store_true",
        help="with --cluster: send frames back over the network, if the workers cannot reach the "
        "output folder (default: they write there)",
    )
    group.add_argument(
        "--part",
        metavar="RANGE",
        help="render only these frames of the export, as the tasks of a farm do; frames of a movie "
        "are kept in a folder beside it until an export without --part joins them",
    )
    group.add_argument(
        "--moved",
        nargs=2,
        action="append",
        default=[],
        metavar=("OLD", "NEW"),
        help="look in the folder NEW for files that the shot names in the folder OLD; may be given "
        "several times",
    )


def expected_program(on_gpus: bool) -> str:
    """Return "VERSION/DRIVER" for tasks that must render as this machine does.

    The driver is left out if this machine cannot draw, or if tasks get a GPU that this machine
    lacks, such as the login node of a cluster.
    """
    try:
        ctx = headless_context()
    except GpuError:
        return __version__
    # With the software driver of the login node, --strict would refuse every task of such a job.
    if on_gpus and is_software(ctx):
        return __version__
    return f"{__version__}/{ctx.name}"


def make_renderer_function(
    args: argparse.Namespace, plan: ExportPlan
) -> Callable[[], FrameRenderer]:
    """Return a function that makes a renderer, and compares its program with `--expect`."""

    def make_renderer() -> FrameRenderer:
        """Return a renderer; compare its program with the expected one first."""
        renderer = headless_renderer()
        program = f"{__version__}/{renderer.ctx.name}"
        _compare_programs(args.expect or "", program, plan.job.shot.plate_options.strict)
        return renderer

    return make_renderer


def _compare_programs(expected: str, present: str, strict: bool) -> None:
    """Print how this program differs from the one that wrote the job; if strict, raise InputError.

    `present` and `expected` are "VERSION/DRIVER" of the two.
    """
    names = ("heatlens", "graphics driver")
    pairs = zip(names, expected.split("/", 1), present.split("/", 1), strict=False)
    differences = [
        f"{name} {present_part}, not {expected_part}"
        for name, expected_part, present_part in pairs
        if expected_part and expected_part != present_part
    ]
    if not differences:
        return
    difference = f"this machine has {' and '.join(differences)}, with which the job was written"
    if strict:
        raise InputError(
            f"{difference[0].upper()}{difference[1:]}. Without --strict it renders nevertheless."
        )
    print_messages(f"{difference}; pictures may differ slightly.")
