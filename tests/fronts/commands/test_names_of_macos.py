"""Test command lines that draw by wgpu with the names that Python's library has on macOS.

Nothing that draws by OpenGL can be imported. Vulkan takes the place of Metal, and files and
processes are those of Linux: see `support/macos_standin.py`.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from support.command_line import ENVIRONMENT, picture
from support.exports import write_plate, write_shot_file

TESTS = Path(__file__).parents[2]
# What is run, and a part of what it prints or of the names of the files that it writes.
LINES = (
    ("--version", "heatlens "),
    ("--install-desktop", "Desktop files are for Linux"),
    ("info PLATE", "32 x 18 px"),
    ("render PLATE -o OUT/r.exr --gpu wgpu", "r.exr"),
    ("render demo -o OUT/demo.png --size 64x36 --gpu wgpu --quality draft", "demo.png"),
    ("export SHOT -o OUT/e.####.exr --frames 1001-1002 --gpu wgpu", "e.1002.exr"),
    ("export SHOT -o OUT/p.####.exr --frames 1001-1002 --processes 2 --gpu wgpu", "p.1002.exr"),
)


def test_commands_draw_by_wgpu_without_opengl_and_the_window(tmp_path):
    plate, shot = write_plate(tmp_path / "one.exr"), write_shot_file(tmp_path)
    out = tmp_path / "out"
    out.mkdir()
    places = {"PLATE": str(plate), "SHOT": str(shot), "OUT": str(out)}
    lines = [[places.get(word, word) for word in line.split()] for line, _ in LINES]
    lines = [[word.replace("OUT", str(out)) for word in line] for line in lines]
    folders = (TESTS / "support" / "macos", TESTS, ENVIRONMENT["PYTHONPATH"])
    run = subprocess.run(
        [sys.executable, str(TESTS / "support" / "windows" / "run_lines.py")],
        input=json.dumps(lines),
        env=ENVIRONMENT | {"PYTHONPATH": ":".join(map(str, folders))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    files = " ".join(path.name for path in out.iterdir())
    failures = {
        line: (code, errors, output)
        for (line, part), (code, output, errors) in zip(LINES, json.loads(run.stdout), strict=True)
        if code != (2 if line == "--install-desktop" else 0) or part not in output + errors + files
    }
    assert failures == {}
    assert np.ptp(picture(out / "r.exr")[1]) > 0.1
