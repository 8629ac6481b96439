"""Test command lines that draw by wgpu with the names that Python's library has on macOS.

Nothing that draws by OpenGL can be imported. Vulkan takes the place of Metal, and files and
processes are those of Linux: see `support/macos_standin.py`.
"""

from pathlib import Path

import numpy as np

from support.command_line import ENVIRONMENT, picture
from support.lines_elsewhere import failed_lines

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
    folders = (TESTS / "support" / "macos", TESTS, ENVIRONMENT["PYTHONPATH"])
    environment = ENVIRONMENT | {"PYTHONPATH": ":".join(map(str, folders))}
    assert failed_lines(LINES, tmp_path, environment, ("--install-desktop",)) == {}
    assert np.ptp(picture(tmp_path / "out" / "r.exr")[1]) > 0.1
