"""Measure what the first frames of an export cost on this machine, in a process of their own."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence

from heatlens.base.errors import InputError
from heatlens.base.stopping import temporary_folder
from heatlens.farm.job import FarmJob, Measured, typed
from heatlens.sequence.names import frames_text

_UNIT_BYTES = 1 if sys.platform == "darwin" else 1024  # the unit of ru_maxrss


def measured(job: FarmJob, name: str, frames: Sequence[int]) -> Measured:
    """Render the first two of `frames` to a folder that is deleted.

    `name` is that of the output files. Raises InputError with the reason if that fails.
    """
    with temporary_folder() as folder:
        words = (*typed(job.steps[0].words, frames_text(frames[:2])), f"--output={folder / name}")
        line = [sys.executable, "-P", "-m", "heatlens", *words, "--progress=json"]
        begin = time.monotonic()
        with subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
            assert process.stdout is not None
            told = [(time.monotonic() - begin, json.loads(row)) for row in process.stdout]
            usage = os.wait4(process.pid, 0)[2]
    return _cost(told, usage.ru_maxrss * _UNIT_BYTES)


def _cost(told: Sequence[tuple[float, dict[str, object]]], memory_bytes: int) -> Measured:
    ends_s = [at_s for at_s, event in told if event["event"] == "frame"]
    last = told[-1][1] if told else {}
    if not ends_s or last["event"] != "end":
        why = last.get("message", "it was killed, as systems do when memory runs out")
        raise InputError(f"The first frame, which shows what a task needs, failed: {why}")
    frame_s = ends_s[-1] - ends_s[0] if len(ends_s) > 1 else ends_s[0]
    return Measured(ends_s[0], frame_s, memory_bytes)
