"""Run the command `heatlens` in this process or in one of its own."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import heatlens
from heatlens.fronts.commands.main import main
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.camera_header import lens_attributes
from support.exr_files import rgb

WIDTH, HEIGHT = 16, 10
OLD_CONTENT = b"what stood here before"
CAMERA = lens_attributes(50.0, 2.0, 2.24, 36.0, 24.0)
_open: list[subprocess.Popen[str]] = []
ENVIRONMENT = os.environ | {"PYTHONPATH": str(Path(heatlens.__file__).parents[1])}


def depths() -> np.ndarray:
    """Return depths (H, W) in metres: column x is at x + 1 m, the top row at infinity."""
    depth = np.broadcast_to(np.arange(1, WIDTH + 1, dtype=np.float32), (HEIGHT, WIDTH)).copy()
    depth[0] = np.inf
    return depth


def channels() -> dict[str, np.ndarray]:
    return rgb(HEIGHT, WIDTH) | {"Z": depths()}


def stderr_of_run(capsys, code: int, *words: object) -> str:
    """Run a command that must exit with `code`. Return its stderr joined to one line."""
    assert main([str(word) for word in words]) == code
    return " ".join(capsys.readouterr().err.split())


def message_of_refusal(capsys, *words: object) -> str:
    """Run a command that is refused with code 2. Return its one line on stderr."""
    assert main([str(word) for word in words]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) == 1
    return captured.err


def render(capsys, plate, out, *words: object) -> str:
    """Run `heatlens render`, which must succeed and print only `out`. Return its stderr."""
    assert main(["render", str(plate), "-o", str(out), *map(str, words)]) == 0
    captured = capsys.readouterr()
    assert captured.out == f"{out}\n"
    assert all(line.startswith("heatlens: ") for line in captured.err.splitlines())
    return captured.err


def refused_render_message(capsys, plate, out, *words: object) -> str:
    """Run `heatlens render`, which must fail with code 2. Return its stderr of at most two lines.

    The folder must stay as it was.
    """
    files_before = folder_of(out)
    assert main(["render", str(plate), "-o", str(out), *map(str, words)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert 1 <= len(captured.err.splitlines()) <= 2 and captured.err.startswith("heatlens: ")
    assert folder_of(out) == files_before
    return captured.err


def folder_of(path) -> dict[str, bytes]:
    """Return name and content of every file in the folder of `path`."""
    if not path.parent.is_dir():
        return {}
    return {p.name: p.read_bytes() for p in path.parent.iterdir() if p.is_file()}


def picture(path) -> tuple[dict, np.ndarray]:
    """Read the header and (H, W, 3) of an EXR."""
    ((header, planes),) = read_parts(path)
    return header, np.stack([planes[name] for name in "RGB"], axis=-1).astype(np.float32)


def start_heatlens(*words: object, **options: object) -> subprocess.Popen[str]:
    """Start `heatlens WORDS` as a process, with its output on pipes unless `options` differ."""
    process_options = {
        "stdout": subprocess.PIPE,
        "stderr": subprocess.PIPE,
        "env": ENVIRONMENT,
    } | options
    command = [sys.executable, "-m", "heatlens", *map(str, words)]
    process = subprocess.Popen(command, text=True, **process_options)
    _open.append(process)
    return process


def start_heatlens_on_full_disk(file_bytes: int, *words: object) -> subprocess.Popen[str]:
    """Start `heatlens WORDS` as a process whose files can have at most `file_bytes`.

    The error of a longer file, EFBIG, acts as ENOSPC. The process writes no byte code, which
    Python would truncate without an error and fail to load in later processes.
    """
    import resource  # here, as Windows has none

    return start_heatlens(
        *words,
        env=ENVIRONMENT | {"PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (file_bytes, file_bytes)),
    )


def kill_started_processes() -> None:
    """Kill processes left by a failed test, whose warnings would appear in another test."""
    while _open:
        with _open.pop() as process:  # closes the pipes
            process.kill()
