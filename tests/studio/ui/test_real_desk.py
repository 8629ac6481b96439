"""The real window under a window manager: chords, sizes, full screen, a second window, a shot.

Where controls lie is asked of the same interface without a window: `Twin`.
"""

import json
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import autosave_path, read_shot, write_shot
from heatlens.render.gpu.device import Device
from heatlens.studio.session.shot.shot_store import unnamed_path
from heatlens.studio.ui.picture.held_alone import HOLD_S
from heatlens.studio.ui.theme import DARK
from support.gui import gui_of
from support.session_files import LENS, room_file
from support.x_server import SCREEN, WAIT_S, Screen, Window

QUICK = ("--bokeh", "heat", "--quality", "draft", "--proxy", 0.5)
FIRST, LAST = 1001, 1400


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


def toggled(window: Window, *words: object) -> None:
    """Run xdotool WORDS, which must change what is seen, and again, which must undo that."""
    rest = window.rest()
    window.screen.hand(*words)
    window.until(lambda: window.seen() != rest, f"an answer to {words}")
    window.rest()
    window.screen.hand(*words)
    window.until(lambda: window.seen() == rest, f"the end of {words}")


def test_a_directors_desk(desk: Screen, tmp_path: Path) -> None:
    kept = tmp_path / "config" / "preferences.json"
    kept.parent.mkdir()
    kept.write_text(json.dumps({"window_size": [3840, 2160]}))  # remembered from a larger screen
    window = Window(desk, tmp_path, room_file(tmp_path / "room.exr"), *QUICK)
    window.activate()
    assert all(0 < side <= room for side, room in zip(geometry(window), SCREEN, strict=True))
    toggled(window, "key", "w")  # keys arrive

    # Chords without time between their keys: each counts, with its own modifier.
    for key, scale in (("equal", 1.1), ("equal", 1.25), ("minus", 1.1), ("equal", 1.25)):
        desk.hand("key", "--delay", 0, f"ctrl+{key}")
        window.until(partial(scale_is, kept, scale), f"the scale {scale}")
    # One after the other, but not the same key twice in a millisecond: GLFW tells one of the two.
    desk.hand("key", "--delay", 5, *["ctrl+minus", "w"] * 2, "ctrl+equal")
    window.until(partial(scale_is, kept, 1.1), "the scale after five keys at once")
    desk.hand("key", "--delay", 0, "ctrl+equal")
    window.until(partial(scale_is, kept, 1.25), "the scale 1.25")
    assert json.loads(kept.read_text())["layout_em"] == 15.0 * 1.25
    for _ in range(3):
        toggled(window, "key", "--delay", 0, "question")

    # Words typed at once, to their end: a guide that the palette finds, and off again.
    rest = window.rest()
    for is_seen in (True, False):
        desk.hand("key", "--delay", 0, "ctrl+shift+p")
        desk.hand("type", "--delay", 0, "safe areas")
        desk.hand("key", "--delay", 0, "Return")
        window.until(lambda wanted=is_seen: (window.rest() != rest) == wanted, "the safe areas")

    toggled(window, "key", "Tab")
    before = geometry(window)
    window.keys("F11")
    window.until(lambda: geometry(window) == SCREEN, "the full screen")
    window.keys("Escape")
    window.until(lambda: geometry(window) == before, "the window again")

    window.keys("F12")
    window.until(lambda: min(geometry(window, "heatlens picture")) > 100, "the second window")
    window.activate()
    window.keys("F12")
    window.until(lambda: geometry(window, "heatlens picture") == (0, 0), "its end")
    _hold_alt(window)
    window.keys("alt+F4")
    assert window.closed() == (0, "")


def _hold_alt(window: Window) -> None:
    """Check that Alt shows the pinhole picture while it is held, and Alt+Tab does not."""
    desk = window.screen
    window.move(500, 450)
    window.rest()
    sharp = _corner(window)
    desk.hand("keydown", "alt")
    window.until(lambda: bool((_corner(window) != sharp).any()), "the pinhole picture")
    desk.hand("keyup", "alt")
    window.until(lambda: bool((_corner(window) == sharp).all()), "the picture again")
    shown = window.seen()
    desk.hand("keydown", "alt", "key", "Tab")
    window.until(lambda: window.seen() != shown, "the list of windows")
    time.sleep(2 * HOLD_S)
    window.rest()
    assert (_corner(window) == sharp).all()
    desk.hand("keyup", "alt")
    window.until(lambda: window.seen() == shown, "the end of the list")


def _corner(window: Window) -> np.ndarray:
    """Return a part of the picture, away from what a window manager shows in the middle."""
    return np.asarray(window.screen.picture().convert("RGB"))[120:320, 60:360].copy()


class Twin:
    """The interface in the same size without a window, which tells where its controls lie."""

    def __init__(self, ctx: Device, window: Window, shot: Path) -> None:
        with gui_of(ctx, shot, size=geometry(window)) as gui:
            self._picture = gui.at_picture(0, 0), gui.at_picture(1, 1)
            gui.do("Export...")
            gui.frame(2)  # the button, once the panel was brought to the front
            self.export = gui.middle("Export")
            for _ in range(2):
                gui.session.pictures.looks.keep()
            gui.do("Grid of looks")
            gui.frame(2)
            self.look_a = gui.middle("grid A")

    def picture(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the picture is in the window."""
        (left, top), (right, below) = self._picture
        return left + x * (right - left), top + y * (below - top)


def sequence(folder: Path) -> Path:
    """Write a shot of many frames, all of them one file, which takes a while to export."""
    first = room_file(folder / f"shot.{FIRST}.exr", 320, 214)
    for frame in range(FIRST + 1, LAST + 1):
        os.link(first, folder / f"shot.{frame}.exr")
    defocus, source = DefocusSettings(quality=Quality.PREVIEW), str(folder / "shot.####.exr")
    shot = Shot(LENS, defocus, source, frames=FrameRange(FIRST, LAST))
    path = folder / "pull.heatlens.json"
    write_shot(path, shot)
    return path


def saved(window: Window, path: Path, condition: Callable[[Shot], bool], what: str) -> Shot:
    """Save with Ctrl+S until the file says what is wanted; return the shot that it holds."""

    def is_there() -> bool:
        window.screen.hand("key", "ctrl+s")
        return condition(read_shot(path))

    window.until(is_there, what)
    return read_shot(path)


def focus_frames(shot: Shot) -> list[float]:
    return [key.frame for key in shot.curves.of(LensParameter.FOCUS_DISTANCE).keys]


def has_color(window: Window, color: Any) -> bool:
    """Return whether something on the screen is written in a color."""
    wanted = np.array([color.x, color.y, color.z]) * 255
    seen = np.asarray(window.screen.picture().convert("RGB")).astype(int)
    return bool((np.abs(seen - wanted).max(axis=-1) < 4).any())


def test_a_shot_is_keyed_compared_and_exported(
    desk: Screen, tmp_path: Path, session_context: Device
) -> None:
    shot = sequence(tmp_path)
    kept = tmp_path / "config" / "preferences.json"
    kept.parent.mkdir()
    kept.write_text(json.dumps({"keep_frames": False}))  # it would never come to rest
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as a shell script starts it with &
    try:
        window = Window(desk, tmp_path, shot, title="pull.heatlens.json")
    finally:
        signal.signal(signal.SIGINT, before)
    window.activate()
    twin = Twin(session_context, window, shot)
    _key(window, shot, twin)
    _compare_looks(window, shot, twin)
    _export_and_close(window, shot, twin)


def _key(window: Window, shot: Path, twin: Twin) -> None:
    """Key a focus, then try one with auto key off: it is seen in a color of its own."""
    hand = window.screen.hand
    window.click(*twin.picture(73, 167))  # the post; the focus lies on the ball
    clicked = saved(window, shot, lambda it: it.lens != LENS, "a focus by a click")
    assert focus_frames(clicked) == []
    hand("key", "k")
    saved(window, shot, lambda it: focus_frames(it) == [FIRST], "a key")
    hand("key", "Right")
    window.click(*twin.picture(200, 107))
    saved(window, shot, lambda it: len(focus_frames(it)) == 2, "a key of auto key")
    hand("key", "Right")
    hand("key", "a")
    window.click(*twin.picture(73, 167))
    window.until(lambda: has_color(window, DARK.tried), "what is only tried")
    assert len(focus_frames(saved(window, shot, lambda _: True, "the shot"))) == 2
    hand("key", "Left")
    window.until(lambda: not has_color(window, DARK.tried), "the keyed focus again")
    hand("key", "a")


def _compare_looks(window: Window, shot: Path, twin: Twin) -> None:
    """Keep two looks, see them in the grid beside the lens of now, and take the first."""
    hand = window.screen.hand
    hand("key", "shift+l")
    wide = saved(window, shot, lambda it: len(it.looks) == 1, "a look").lens.f_stop
    hand("key", "--delay", 20, "braceright", "braceright", "braceright")
    hand("key", "shift+l")
    closed = saved(window, shot, lambda it: len(it.looks) == 2, "another look")
    assert closed.lens.f_stop > wide
    rest = window.rest()
    hand("key", "shift+w")
    window.until(lambda: window.rest() != rest, "the grid")
    window.click(*twin.look_a)
    saved(window, shot, lambda it: it.lens.f_stop == wide, "the first look")
    hand("key", "Escape")


def _export_and_close(window: Window, shot: Path, twin: Twin) -> None:
    """Export, close on it, which asks, and close anyway: no process goes on."""
    hand = window.screen.hand
    hand("key", "ctrl+e")
    window.rest()
    window.click(*twin.export)
    window.until(lambda: "% exported" in window.title(), "the progress in the title")
    exporting = window.processes()
    bright = _corner(window)
    hand("key", "alt+F4")
    window.until(lambda: bool((_corner(window) != bright).any()), "the question")
    hand("key", "Escape")  # go on with the export
    window.until(lambda: bool((_corner(window) == bright).all()), "the end of the question")
    done = window.title()
    window.until(lambda: "exported" in window.title() != done, "more of the export")
    hand("key", "alt+F4")
    window.until(lambda: bool((_corner(window) != bright).any()), "the question again")
    hand("key", "Return")  # stop it and close
    assert window.closed() == (0, "")
    window.until(lambda: not any(Path(f"/proc/{it}").exists() for it in exporting), "their end")
    written = sorted((shot.parent / "shot_dof").glob("*"))
    assert 0 < len(written) < LAST - FIRST + 1
    assert {path.suffix for path in written} <= {".exr"}


def test_ctrl_c_ends_a_window_at_rest_and_keeps_what_is_not_saved(
    desk: Screen, tmp_path: Path
) -> None:
    plate = room_file(tmp_path / "room.exr")
    window = Window(desk, tmp_path, plate, *QUICK)
    window.activate()
    kept = autosave_path(unnamed_path(tmp_path / "config", str(plate)))
    window.until(lambda: bool(desk.hand("key", "m")) or kept.exists(), "the autosave")
    window.rest()
    window.process.send_signal(signal.SIGINT)
    assert window.closed() == (130, "heatlens: stopped\n")
    assert read_shot(kept).marks
