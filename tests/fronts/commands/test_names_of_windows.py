"""Test command lines and the window with the names that Python's library has on Windows.

OpenGL, files and processes are those of Linux: see `support/windows_standin.py`.
"""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from support.command_line import ENVIRONMENT, picture, start_heatlens
from support.lines_elsewhere import failed_lines
from support.patience import PATIENCE_S
from support.x_server import Screen, Window

TESTS = Path(__file__).parents[2]
FOLDER = TESTS / "support" / "windows"
# Lets a process see the names that are there.
THERE = {"PYTHONPATH": ":".join(map(str, (FOLDER, TESTS, ENVIRONMENT["PYTHONPATH"])))}
QUICK = ("--quality", "draft", "--proxy", "0.5")
# What is run, and a part of what it prints or of the names of the files that it writes.
LINES = (
    ("--version", "heatlens "),
    ("--help", "COMMAND"),
    ("info PLATE", "32 x 18 px"),
    ("info --json PLATE", '"width_px": 32'),
    ("info demo", "frames"),
    ("render PLATE -o OUT/r.exr", "r.exr"),
    ("render PLATE -o OUT/r.png --f-stop 1.4 --focus-at 5,5", "r.png"),
    ("render demo -o OUT/demo.png --size 64x36 --frame 2", "demo.png"),
    ("export SHOT -o OUT/e.####.exr", "e.1001.exr"),
    ("export SHOT -o OUT/movie.mp4 --frames 1001-1002", "movie.mp4"),
    ("export SHOT -o OUT/p.####.exr --frames 1001-1002 --processes 2", "p.1002.exr"),
    ("export SHOT -o OUT/f.####.exr --submit openjd --chunk 2", "specificationVersion"),
    ("camera SHOT -o OUT/cam.usda", "cam.usda"),
    ("camera SHOT -o OUT/cam.nk", "cam.nk"),
    ("shot new PLATE -o OUT/new.heatlens.json", "new.heatlens.json"),
    ("shot show SHOT", "1001"),
    ("shot sheet SHOT -o OUT/sheet.html", "sheet.html"),
    ("reel OUT/new.heatlens.json -o OUT/cut.heatreel.json", "cut.heatreel.json"),
    ("compare OUT/r.exr OUT/r.exr", "99.000 dB"),
    ("bench --size 64x36 --runs 1 --quality draft", "ms"),
    ("kits", "mm"),
    ("addon build -o OUT/blender.zip", "blender.zip"),
    ("--install-desktop", "Desktop files are for Linux"),
    ("--print-completion bash", "complete"),
    ("render OUT/none.exr -o OUT/n.exr", "is not there"),
)
REFUSED = ("none.exr", "--install-desktop")


@pytest.fixture(scope="module")
def screen() -> Iterator[Screen]:
    """Return a screen for X11's contexts, which take the place of those of Windows."""
    opened = Screen()
    yield opened
    opened.close()


def test_ctrl_c_leaves_no_unfinished_file(screen, tmp_path):
    """No parent process removes them there, as one does on Linux."""
    out = tmp_path / "out"
    environment = ENVIRONMENT | THERE | {"DISPLAY": screen.display}
    words = ("export", "demo", "-o", out / "n.mp4", "--size", "64x36", "--frames", "1-90")
    process = start_heatlens(*words, env=environment)
    end = time.monotonic() + PATIENCE_S
    while not list(out.glob(".heatlens-*")):
        assert time.monotonic() < end and process.poll() is None, process.communicate()
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, errors.splitlines()[-1]) == (130, "heatlens: stopped")
    assert not out.exists()


def test_end_removes_what_a_thread_has_not_finished(tmp_path):
    code = (
        "import sys, heatlens.fronts.commands.launch as launch\n"
        "from heatlens.core.base import stopping\n"
        "def work():\n"
        "    block = stopping.mark_unfinished(sys.argv[1])\n"
        "    block.__enter__()\n"
        "    open(sys.argv[1], 'w').close()\n"
        "    launch._end_now(130)\n"
        "launch._run_command = work\n"
        "launch.main()"
    )
    environment = ENVIRONMENT | THERE
    command = [sys.executable, "-c", code, str(tmp_path / "half")]
    assert subprocess.run(command, env=environment, check=False).returncode == 130
    assert list(tmp_path.iterdir()) == []


def test_commands_and_window_find_their_names(screen, tmp_path):
    environment = ENVIRONMENT | THERE | {"DISPLAY": screen.display}
    assert failed_lines(LINES, tmp_path, environment, REFUSED) == {}
    _, pixels = picture(tmp_path / "out" / "r.exr")
    assert np.ptp(pixels) > 0.1
    window = Window(screen, tmp_path, "view", str(tmp_path / "one.exr"), *QUICK, **THERE)
    window.rest()
    assert len(screen.picture().getcolors(1 << 24)) > 100
    window.quit()
    assert window.closed() == (0, "")
