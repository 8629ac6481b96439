"""The real window under a window manager: chords, sizes, full screen, a second window, Alt+F4."""

import json
import shutil
import subprocess
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from support.window_plates import room_file
from support.x_server import SCREEN, WAIT_S, Screen, Window

QUICK = ("--bokeh", "heat", "--quality", "draft", "--proxy", 0.5)


@pytest.fixture
def desk() -> Iterator[Screen]:
    """Return a screen on which a window manager runs."""
    if shutil.which("openbox") is None:
        pytest.skip("openbox is missing: apt-get install openbox")
    screen = Screen()
    environment = {"DISPLAY": screen.display, "PATH": "/usr/bin:/bin", "HOME": "/nonexistent"}
    quiet = subprocess.DEVNULL
    manager = subprocess.Popen(["openbox"], env=environment, stdout=quiet, stderr=quiet)
    yield screen
    screen.close()
    manager.kill()
    manager.wait(WAIT_S)


def geometry(window: Window, name: str = "") -> tuple[int, int]:
    """Return the size of the window, or of the one called `name`."""
    found = window.screen.hand("search", "--name", name).splitlines() if name else [window.id]
    told = window.screen.hand("getwindowgeometry", "--shell", found[0]) if found else ""
    values = dict(line.split("=") for line in told.splitlines() if "=" in line)
    return int(values.get("WIDTH", 0)), int(values.get("HEIGHT", 0))


def scale_is(preferences: Path, scale: float) -> bool:
    """Return whether the scale of the interface is remembered for the screen."""
    now = json.loads(preferences.read_text())["ui_scales"] if preferences.is_file() else {}
    return list(now.values()) == [scale]


def test_a_directors_desk(desk: Screen, tmp_path: Path) -> None:
    window = Window(desk, tmp_path, room_file(tmp_path / "room.exr"), *QUICK)
    desk.hand("windowactivate", "--sync", window.id)
    time.sleep(2.0)
    window.changes("key", "w")  # keys arrive
    window.keys("w")
    assert all(side <= room for side, room in zip(geometry(window), SCREEN, strict=True))

    # Chords without time between their keys: each counts, with its own modifier.
    kept = tmp_path / "config" / "preferences.json"
    for key, scale in (("equal", 1.1), ("equal", 1.25), ("minus", 1.1), ("equal", 1.25)):
        desk.hand("key", "--delay", 0, f"ctrl+{key}")
        window.until(partial(scale_is, kept, scale), f"the scale {scale}")
    # One after the other, but not the same key twice in a millisecond: GLFW tells one of the two.
    desk.hand("key", "--delay", 5, *["ctrl+minus", "w"] * 2, "ctrl+equal")
    window.until(partial(scale_is, kept, 1.1), "the scale after five keys at once")
    desk.hand("key", "--delay", 0, "ctrl+equal")
    window.until(partial(scale_is, kept, 1.25), "the scale 1.25")
    assert json.loads(kept.read_text())["layout_em"] == 15.0 * 1.25

    before = geometry(window)
    window.keys("F11")
    window.until(lambda: geometry(window) == SCREEN, "the full screen")
    window.keys("Escape")
    window.until(lambda: geometry(window) == before, "the window again")

    window.keys("F12")
    window.until(lambda: min(geometry(window, "heatlens picture")) > 100, "the second window")
    desk.hand("windowactivate", "--sync", window.id)
    time.sleep(0.5)
    window.keys("F12")
    window.until(lambda: geometry(window, "heatlens picture") == (0, 0), "its end")

    window.keys("alt+F4")
    assert window.closed() == (0, "")
