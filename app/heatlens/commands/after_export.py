"""Run a command of the user's after an export: how a tracker of shots learns of new frames."""

import json
import subprocess

from heatlens.base.errors import InputError
from heatlens.commands.options.shot_timecode import shot_timecodes
from heatlens.export.plan import ExportPlan
from heatlens.model.shot import LensParameter

_STDERR = 2  # the descriptor


def run_after(command: str, plan: ExportPlan, name: str) -> None:
    """Run `command` by the shell, with a line of JSON on its standard input.

    What it prints goes to standard error. Raises InputError if it fails.
    """
    told = f"{json.dumps(_facts(plan, name))}\n"
    done = subprocess.run(command, shell=True, input=told, text=True, stdout=_STDERR)
    if done.returncode:
        raise InputError(
            f"--after-export: the frames of {name} are written, but {command!r} ended with exit "
            f"code {done.returncode}."
        )


def _facts(plan: ExportPlan, name: str) -> dict[str, object]:
    """Return what the command is told; the lens has one value for each frame."""
    frames = plan.frames
    lens = {str(p): [getattr(frame.lens, p) for frame in frames] for p in LensParameter}
    timecode = shot_timecodes(plan.job.shot, frames[0].frame)(frames[0].frame)
    files = dict.fromkeys(str(frame.path.absolute()) for frame in frames)
    return {
        "shot": name,
        "files": list(files),
        "frames": [frame.frame for frame in frames],
        "lens": lens,
        "timecode": None if timecode is None else str(timecode),
    }
