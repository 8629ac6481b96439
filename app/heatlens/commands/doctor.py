"""`heatlens doctor`: check whether everything works on this machine, also for bug reports."""

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import asdict

from heatlens.doctor import machine_check, picture_check, window_check
from heatlens.doctor.finding import Check, Finding, made_sure
from heatlens.doctor.gpu_check import Gpu
from heatlens.gpu.context import headless_context

_DESCRIPTION = """\
Checks everything that heatlens depends on: packages, OpenGL and its limits, every shader, the
solvers against float64, the still life against a stored picture, colours, fonts and display. Takes
a few seconds. The exit code is 1 if something fails. Paste the output into bug reports.
"""
_EPILOG = """\
examples:
  heatlens doctor
  heatlens doctor --json > doctor.json
"""


def register(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add `doctor` to the command line."""
    parser = commands.add_parser(
        "doctor",
        help="check whether everything works on this machine",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--json", action="store_true", help="one JSON object instead of lines")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Run all checks and print each finding at once; return 1 if something fails."""
    start, found = time.perf_counter(), []
    for finding in _findings():
        found.append(finding)
        if not args.json:
            print(f"{finding.state:5}  {finding.name}: {finding.said}", flush=True)
    faults = sum(finding.state == "fault" for finding in found)
    seconds = time.perf_counter() - start
    if args.json:
        report = {"ok": not faults, "seconds": seconds, "findings": [asdict(f) for f in found]}
        print(json.dumps(report, indent=2))
    else:
        told = "nothing is at fault" if not faults else f"at fault: {faults}"
        print(f"{len(found)} findings in {seconds:.1f} s, {told}")
    return int(faults > 0)


def _findings() -> Iterator[Finding]:
    for name, check in _checks().items():
        yield from made_sure(name, check)


def _checks() -> dict[str, Check]:
    """Return the checks, basic ones first; the display is last, because drivers may crash there."""
    gpu = Gpu(headless_context)
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
        "fonts": window_check.fonts,
        "display": window_check.display,
    }
