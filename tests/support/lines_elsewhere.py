"""Run command lines in a process that has the names of another system's Python library."""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from support.exports import write_plate, write_shot_file

_RUNNER = Path(__file__).parent / "line_runner" / "run_lines.py"


def failed_lines(
    lines: Sequence[tuple[str, str]],
    folder: Path,
    environment: Mapping[str, str],
    refused: Sequence[str],
) -> dict[str, tuple[int, str, str]]:
    """Return the lines that failed, with their exit code, errors and output.

    A line names PLATE, SHOT and the folder OUT; beside it stands a part of what it prints, or of
    the names of the files that it writes to `folder` / "out". Lines with one of the words of
    `refused` have to end with code 2.
    """
    plate, shot, out = write_plate(folder / "one.exr"), write_shot_file(folder), folder / "out"
    out.mkdir()
    texts = [line for line, _ in lines]
    for name, path in {"PLATE": plate, "SHOT": shot, "OUT": out}.items():
        texts = [line.replace(name, str(path)) for line in texts]
    run = subprocess.run(
        [sys.executable, str(_RUNNER)],
        input=json.dumps([line.split() for line in texts]),
        env=dict(environment),
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    files = " ".join(path.name for path in out.iterdir())
    return {
        line: (code, errors, output)
        for (line, part), (code, output, errors) in zip(lines, json.loads(run.stdout), strict=True)
        if code != (2 if any(word in line for word in refused) else 0)
        or part not in output + errors + files
    }
