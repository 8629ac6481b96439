"""Compare this machine's heatlens and OpenGL driver with those where a job was written.

Another version or driver, such as software beside a GPU, may give slightly other pictures.
"""

import argparse
from collections.abc import Callable

from heatlens.base.errors import GpuError, InputError
from heatlens.commands.output.say import say
from heatlens.export.plan import ExportPlan
from heatlens.gpu.context import headless_context, is_software
from heatlens.render import FrameRenderer, headless_renderer
from heatlens.version import __version__


def program_of_tasks(on_gpus: bool) -> str:
    """Return "VERSION/DRIVER" for tasks that are to render as this machine does.

    The driver is missing where there is no OpenGL, and where tasks get a GPU that this machine
    lacks: jobs are written on the login node of a cluster.
    """
    try:
        ctx = headless_context()
    except GpuError:
        return __version__
    if on_gpus and is_software(ctx):
        return __version__
    return f"{__version__}/{ctx.info['GL_RENDERER']}"


def renderer_of(args: argparse.Namespace, plan: ExportPlan) -> Callable[[], FrameRenderer]:
    """Return a function that makes a renderer, and compares its program with `--expect`."""

    def made() -> FrameRenderer:
        renderer = headless_renderer()
        found = f"{__version__}/{renderer.ctx.info['GL_RENDERER']}"
        _compare(args.expect or "", found, plan.job.shot.plate_options.strict)
        return renderer

    return made


def _compare(wanted: str, found: str, strict: bool) -> None:
    names = ("heatlens", "OpenGL driver")
    pairs = zip(names, wanted.split("/", 1), found.split("/", 1), strict=False)
    others = [
        f"{name} {here}, not {there}" for name, there, here in pairs if there and there != here
    ]
    if not others:
        return
    told = f"this machine has {' and '.join(others)}, where the job was written"
    if strict:
        raise InputError(f"{told[0].upper()}{told[1:]}. Without --strict it renders nevertheless.")
    say(f"{told}; pictures may differ slightly.")
