"""`heatlens doctor`: check whether everything works on this machine, also for bug reports."""

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict

from heatlens.core.base.pace import Step
from heatlens.fronts.commands.options.device_option import add_device_option, use_device
from heatlens.fronts.commands.output.progress_line import paced_progress
from heatlens.fronts.commands.output.say import print_result
from heatlens.fronts.doctor import gpu_check, machine_check, picture_check
from heatlens.fronts.doctor.finding import Check, Finding, run_check
from heatlens.fronts.doctor.gpu_check import Gpu
from heatlens.render.defocus.line_solver import SOLVERS
from heatlens.render.gpu.context import headless_context

DESCRIPTION = """\
Checks everything that heatlens depends on: packages, the graphics library, every shader, the
solvers against float64, the still life against a stored picture, colours, fonts and display, and
whether a second start finds its shaders compiled. Says how long it takes. The exit code is 1 if
something fails. Paste the output into bug reports.
"""
# Seconds that each check takes if nothing is compiled yet. The time left is estimated from a pace
# of each check: one pace for all would hardly follow the shaders, which a GPU driver builds slowly.
_SECONDS = {
    "packages": 1.2,
    "shaders": 0.02,
    "solvers": 1.5,
    "still life": 3.4,
    "second start": 6.2,
}
EPILOG = """\
examples:
  heatlens doctor
  heatlens doctor --json > doctor.json
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object instead of lines"
    )
    add_device_option(parser)


def run(args: argparse.Namespace) -> int:
    """Run all checks and print each finding at once; return 1 if something fails."""
    use_device(args)
    start, findings = time.perf_counter(), []
    with paced_progress(_steps()) as report_step:
        for finding in _findings(report_step):
            findings.append(finding)
            report_step("")
            if not args.json:
                print_result(f"{finding.state:5}  {finding.name}: {finding.said}")
    faults = sum(finding.state == "fault" for finding in findings)
    seconds = time.perf_counter() - start
    if args.json:
        report = {"ok": not faults, "seconds": seconds, "findings": [asdict(f) for f in findings]}
        print(json.dumps(report, indent=2))
    else:
        verdict = "no fault found" if not faults else f"at fault: {faults}"
        print(f"{len(findings)} findings in {seconds:.1f} s, {verdict}")
    return int(faults > 0)


def _steps() -> list[Step]:
    """Return the steps of all checks in order, with the seconds that they take.

    The times were measured on two cores, and are longer on a machine with other work. Each check
    has its own pace, because the driver of a GPU builds shaders more slowly.
    """
    load_factor = _load_factor()
    solvers = [gpu_check.solver_step(name) for name in SOLVERS]
    step_names = {"shaders": gpu_check.shader_steps(), "solvers": solvers}
    return [
        Step(words, load_factor * _SECONDS.get(name, 0.1), name)
        for name in _checks()
        for words in (name, *step_names.get(name, ()))
    ]


def _load_factor() -> float:
    """Return the factor by which other work slows the checks down now: load per processor."""
    if sys.platform != "linux":  # other systems report no load, or in another way
        return 1.0
    processors = len(os.sched_getaffinity(0))
    return max(1.0, (os.getloadavg()[0] + 1.0) / processors)


def _findings(report_step: Callable[[str], None]) -> Iterator[Finding]:
    """Run all checks; report the name of each one before it runs, and yield its findings."""
    for name, check in _checks(report_step).items():
        report_step(name)
        yield from run_check(name, check)


def _checks(report_step: Callable[[str], None] = lambda _: None) -> dict[str, Check]:
    """Return the checks, basic ones first; the display is last, because drivers may crash there."""
    gpu = Gpu(headless_context, report_step)
    return {
        "machine": machine_check.system,
        "packages": machine_check.packages,
        "EXR": machine_check.files,
        "OpenGL": gpu.device,
        "shaders": gpu.shaders,
        "solvers": gpu.solvers,
        "still life": lambda: picture_check.still_life(gpu.ctx),
        "OpenColorIO": lambda: picture_check.color(gpu.ctx),
        "OpenGL errors": gpu.errors,
        "second start": machine_check.second_start,
        "fonts": machine_check.fonts,
        "display": machine_check.display,
    }
