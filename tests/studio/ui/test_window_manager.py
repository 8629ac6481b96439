"""The real window under a window manager: chords, sizes, full screen, a second window, a shot.

The positions of controls come from `Twin`, the same interface without a window.
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
from heatlens.media.documents.shot_file import autosave_path, read_shot, unnamed_path, write_shot
from heatlens.render.gpu.device import Device
from heatlens.studio.ui.picture.held_alone import HOLD_S
from heatlens.studio.ui.theme import DARK
from support.gui import gui_of
from support.patience import PATIENCE_S
from support.session_files import LENS, room_file
from support.x_server import SCREEN, Screen, Window

QUICK = ("--bokeh", "heat", "--quality", "draft", "--proxy", 0.5)
FIRST, LAST = 1001, 1400


@pytest.fixture
def control() -> Iterator[Screen]:
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
    manager.wait(PATIENCE_S)


def geometry(window: Window, name: str = "") -> tuple[int, int]:
    """Return the size of the window, or of the one called `name`."""
    window_ids = window.screen.hand("search", "--name", name).splitlines() if name else [window.id]
    output = window.screen.hand("getwindowgeometry", "--shell", window_ids[0]) if window_ids else ""
    values = dict(line.split("=") for line in output.splitlines() if "=" in line)
    return int(values.get("WIDTH", 0)), int(values.get("HEIGHT", 0))


def scale_is(preferences: Path, scale: float) -> bool:
    """Return whether the scale of the interface is remembered for the screen."""
    ui_scales = json.loads(preferences.read_text())["ui_scales"] if preferences.is_file() else {}
    return list(ui_scales.values()) == [scale]


def toggle_twice(window: Window, *words: object) -> None:
    """Run xdotool with `words` twice: the first must change the screen, the second restore it."""
    rest = window.rest()
    window.screen.hand(*words)
    window.until(lambda: window.seen() != rest, f"an answer to {words}")
    window.rest()
    window.screen.hand(*words)
    window.until(lambda: window.seen() == rest, f"the end of {words}")


def test_real_window_handles_chords_full_screen_and_second_window(
    control: Screen, tmp_path: Path
) -> None:
    preferences_file = tmp_path / "config" / "preferences.json"
    preferences_file.parent.mkdir()
    preferences_file.write_text(
        json.dumps({"window_size": [3840, 2160]})
    )  # remembered from a larger screen
    window = Window(control, tmp_path, room_file(tmp_path / "room.exr"), *QUICK)
    window.activate()
    assert all(0 < side <= limit for side, limit in zip(geometry(window), SCREEN, strict=True))
    toggle_twice(window, "key", "w")  # keys arrive

    # Chords without time between their keys: each counts, with its own modifier.
    for key, scale in (("equal", 1.1), ("equal", 1.25), ("minus", 1.1), ("equal", 1.25)):
        control.hand("key", "--delay", 0, f"ctrl+{key}")
        window.until(partial(scale_is, preferences_file, scale), f"the scale {scale}")
    # One after the other, but not the same key twice in a millisecond: GLFW tells one of the two.
    control.hand("key", "--delay", 5, *["ctrl+minus", "w"] * 2, "ctrl+equal")
    window.until(partial(scale_is, preferences_file, 1.1), "the scale after five keys at once")
    control.hand("key", "--delay", 0, "ctrl+equal")
    window.until(partial(scale_is, preferences_file, 1.25), "the scale 1.25")
    assert json.loads(preferences_file.read_text())["layout_em"] == 15.0 * 1.25
    for _ in range(3):
        toggle_twice(window, "key", "--delay", 0, "F1")

    # Words typed at once, to their end: a guide that the palette finds, and off again.
    screen_at_rest = window.rest()
    for is_changed in (True, False):
        control.hand("key", "--delay", 0, "ctrl+shift+p")
        control.hand("type", "--delay", 0, "safe areas")
        control.hand("key", "--delay", 0, "Return")
        window.until(
            lambda expected=is_changed: (window.rest() != screen_at_rest) == expected, "the guide"
        )

    toggle_twice(window, "key", "Tab")
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
    control = window.screen
    window.move(500, 450)
    window.rest()
    sharp = _corner(window)
    control.hand("keydown", "alt")
    window.until(lambda: bool((_corner(window) != sharp).any()), "the pinhole picture")
    control.hand("keyup", "alt")
    window.until(lambda: bool((_corner(window) == sharp).all()), "the picture again")
    shown = window.seen()
    control.hand("keydown", "alt", "key", "Tab")
    window.until(lambda: window.seen() != shown, "the list of windows")
    time.sleep(2 * HOLD_S)
    window.rest()
    assert (_corner(window) == sharp).all()
    control.hand("keyup", "alt")
    window.until(lambda: window.seen() == shown, "the end of the list")


def _corner(window: Window) -> np.ndarray:
    """Return a corner of the picture, which the dialogs of the window manager do not cover."""
    return np.asarray(window.screen.picture().convert("RGB"))[120:320, 60:360].copy()


class Twin:
    """Positions of controls, from the interface of the same size without a window."""

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


def save_until(window: Window, path: Path, condition: Callable[[Shot], bool], what: str) -> Shot:
    """Save with Ctrl+S until the shot in the file meets `condition`; return that shot."""

    def is_there() -> bool:
        window.screen.hand("key", "ctrl+s")
        return condition(read_shot(path))

    window.until(is_there, what)
    return read_shot(path)


def focus_frames(shot: Shot) -> list[float]:
    return [key.frame for key in shot.curves.of(LensParameter.FOCUS_DISTANCE).keys]


def has_color(window: Window, color: Any) -> bool:
    """Return whether any pixel of the screen has this color."""
    expected = np.array([color.x, color.y, color.z]) * 255
    pixels = np.asarray(window.screen.picture().convert("RGB")).astype(int)
    return bool((np.abs(pixels - expected).max(axis=-1) < 4).any())


def test_real_window_keys_compares_and_exports_a_shot(
    control: Screen, tmp_path: Path, session_context: Device
) -> None:
    shot = sequence(tmp_path)
    preferences_file = tmp_path / "config" / "preferences.json"
    preferences_file.parent.mkdir()
    preferences_file.write_text(json.dumps({"keep_frames": False}))  # it would never come to rest
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as a shell script starts it with &
    try:
        window = Window(control, tmp_path, shot, title="pull.heatlens.json")
    finally:
        signal.signal(signal.SIGINT, before)
    window.activate()
    twin = Twin(session_context, window, shot)
    _key(window, shot, twin)
    _compare_looks(window, shot, twin)
    _export_and_close(window, shot, twin)


def _key(window: Window, shot: Path, twin: Twin) -> None:
    """Key a focus, then try one with auto key off, which is shown in a color of its own."""
    input_hand = window.screen.hand
    window.click(*twin.picture(73, 167))  # the post; the focus lies on the ball
    clicked = save_until(window, shot, lambda it: it.lens != LENS, "a focus by a click")
    assert focus_frames(clicked) == []
    input_hand("key", "k")
    save_until(window, shot, lambda it: focus_frames(it) == [FIRST], "a key")
    input_hand("key", "Right")
    window.click(*twin.picture(200, 107))
    save_until(window, shot, lambda it: len(focus_frames(it)) == 2, "a key of auto key")
    input_hand("key", "Right")
    input_hand("key", "a")
    window.click(*twin.picture(73, 167))
    window.until(lambda: has_color(window, DARK.trial), "what is only tried")
    assert len(focus_frames(save_until(window, shot, lambda _: True, "the shot"))) == 2
    input_hand("key", "Left")
    window.until(lambda: not has_color(window, DARK.trial), "the keyed focus again")
    input_hand("key", "a")


def _compare_looks(window: Window, shot: Path, twin: Twin) -> None:
    """Keep two looks, show them in the grid beside the current lens, and take the first."""
    input_hand = window.screen.hand
    input_hand("key", "shift+l")
    wide = save_until(window, shot, lambda it: len(it.looks) == 1, "a look").lens.f_stop
    input_hand("key", "--delay", 20, "braceright", "braceright", "braceright")
    input_hand("key", "shift+l")
    closed = save_until(window, shot, lambda it: len(it.looks) == 2, "another look")
    assert closed.lens.f_stop > wide
    rest = window.rest()
    input_hand("key", "shift+w")
    window.until(lambda: window.rest() != rest, "the grid")
    window.click(*twin.look_a)
    save_until(window, shot, lambda it: it.lens.f_stop == wide, "the first look")
    input_hand("key", "Escape")


def _export_and_close(window: Window, shot: Path, twin: Twin) -> None:
    """Export, close the window during it, answer its question; check that no process is left."""
    input_hand = window.screen.hand
    input_hand("key", "ctrl+e")
    window.rest()
    window.click(*twin.export)
    window.until(lambda: "% exported" in window.title(), "the progress in the title")
    exporting = window.processes()
    corner_before = _corner(window)
    input_hand("key", "alt+F4")
    window.until(lambda: bool((_corner(window) != corner_before).any()), "the question")
    input_hand("key", "Escape")  # go on with the export
    window.until(lambda: bool((_corner(window) == corner_before).all()), "the end of the question")
    title_before = window.title()
    window.until(lambda: "exported" in window.title() != title_before, "more of the export")
    input_hand("key", "alt+F4")
    window.until(lambda: bool((_corner(window) != corner_before).any()), "the question again")
    input_hand("key", "Return")  # stop it and close
    assert window.closed() == (0, "")
    window.until(lambda: not any(Path(f"/proc/{it}").exists() for it in exporting), "their end")
    written_files = sorted((shot.parent / "shot_dof").glob("*"))
    assert 0 < len(written_files) < LAST - FIRST + 1
    assert {path.suffix for path in written_files} <= {".exr"}


def test_interrupt_ends_real_window_and_keeps_the_autosave(control: Screen, tmp_path: Path) -> None:
    plate = room_file(tmp_path / "room.exr")
    window = Window(control, tmp_path, plate, *QUICK)
    window.activate()
    autosave = autosave_path(unnamed_path(tmp_path / "config", str(plate)))
    window.until(lambda: bool(control.hand("key", "m")) or autosave.exists(), "the autosave")
    window.rest()
    window.process.send_signal(signal.SIGINT)
    assert window.closed() == (130, "heatlens: stopped\n")
    assert read_shot(autosave).marks
