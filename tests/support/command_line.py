"""`heatlens` as it is called: in this process, or in one of its own."""

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
BEFORE = b"what stood here before"
CAMERA = lens_attributes(50.0, 2.0, 2.24, 36.0, 24.0)
_open: list[subprocess.Popen[str]] = []
ENVIRONMENT = os.environ | {"PYTHONPATH": str(Path(heatlens.__file__).parents[1])}


def depths() -> np.ndarray:
    """Return metres: column x is at x + 1, the top row infinitely far."""
    depth = np.broadcast_to(np.arange(1, WIDTH + 1, dtype=np.float32), (HEIGHT, WIDTH)).copy()
    depth[0] = np.inf
    return depth


def channels() -> dict[str, np.ndarray]:
    return rgb(HEIGHT, WIDTH) | {"Z": depths()}


def stderr_of_run(capsys, code: int, *words: object) -> str:
    """Run the command, which must end with `code`; what was said on stderr, on one line."""
    assert main([str(word) for word in words]) == code
    return " ".join(capsys.readouterr().err.split())


def render(capsys, plate, out, *words: object) -> str:
    """Render, which must succeed; what was said on stderr. Stdout names the result alone."""
    assert main(["render", str(plate), "-o", str(out), *map(str, words)]) == 0
    said = capsys.readouterr()
    assert said.out == f"{out}\n"
    assert all(line.startswith("heatlens: ") for line in said.err.splitlines())
    return said.err


def refused(capsys, plate, out, *words: object) -> str:
    """Run a command that must fail with code 2, and return its stderr of two lines at most.

    The folder must stay as it was.
    """
    before = folder_of(out)
    assert main(["render", str(plate), "-o", str(out), *map(str, words)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert 1 <= len(said.err.splitlines()) <= 2 and said.err.startswith("heatlens: ")
    assert folder_of(out) == before
    return said.err


def folder_of(path) -> dict[str, bytes]:
    """Name and content of every file beside `path`."""
    if not path.parent.is_dir():
        return {}
    return {p.name: p.read_bytes() for p in path.parent.iterdir() if p.is_file()}


def picture(path) -> tuple[dict, np.ndarray]:
    """Read the header and (H, W, 3) of an EXR."""
    ((header, found),) = read_parts(path)
    return header, np.stack([found[name] for name in "RGB"], axis=-1).astype(np.float32)


def started(*words: object, **options: object) -> subprocess.Popen[str]:
    """Start `heatlens WORDS` as a process of its own, with its output on pipes unless told."""
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": ENVIRONMENT} | options
    command = [sys.executable, "-m", "heatlens", *map(str, words)]
    process = subprocess.Popen(command, text=True, **given)
    _open.append(process)
    return process


def end_started() -> None:
    """End what a test that failed left running, whose warning would fall into another test."""
    while _open:
        with _open.pop() as process:  # closes the pipes
            process.kill()
