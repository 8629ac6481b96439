"""The real window on a virtual screen, driven by mouse and keys as by a user."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.fronts.commands.main import main
from heatlens.media.plate.exr.exr_write import write_exr
from heatlens.media.sequence.sequence_search import find_sequence
from heatlens.studio.ui.theme import SURROUND
from support.command_line import ENVIRONMENT, start_heatlens
from support.patience import PATIENCE_S
from support.plates import room
from support.x_server import Screen, Window


@pytest.fixture(scope="module")
def screen() -> Iterator[Screen]:
    server = Screen()
    yield server
    server.close()


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    color, depth = room()
    height, width = depth.shape
    box = Box(0, 0, width, height)
    path = tmp_path / "room.exr"
    channels = {name: color[..., i] for i, name in enumerate("RGB")} | {"Z": depth}
    write_exr(path, channels, box, box)
    return path


def screen_pixels(screen: Screen) -> np.ndarray:
    return np.asarray(screen.picture().convert("RGB")).astype(int)


def test_real_window_survives_a_session_of_mouse_and_keys(
    screen: Screen, plate: Path, tmp_path: Path, request
) -> None:
    window = Window(screen, tmp_path, plate, "--f-stop", 1.4, "--quality", "draft")
    assert window.title() == "room.exr - heatlens"
    window.keys("F1")
    time.sleep(0.5)
    window.keys("F1")
    window.changes("mousemove", 400, 400, "click", 1)  # focus on what is there
    window.drag((300, 840), (700, 840))  # the focus bar
    window.move(1400, 92)
    screen.hand("click", 1)
    window.keys("ctrl+a")
    screen.hand("type", "--delay", "60", "6'3\"")
    window.keys("Return")
    for key in ("z", "z", "p", "c", "v", "l", "w", "x", "e", "f", "1"):
        window.keys(key)
    screen.hand("windowsize", window.id, 1100, 700)
    time.sleep(1.0)
    resized = screen_pixels(screen)[:700, :1100]
    picture_folder = os.environ.get("HEATLENS_TEST_PICTURES")
    if picture_folder:
        Path(picture_folder).mkdir(parents=True, exist_ok=True)
        screen.picture().save(Path(picture_folder) / f"{request.node.name}.png")
    assert resized.std() > 10  # a picture, not an empty window
    window.keys("ctrl+z", "ctrl+z")
    window.quit()
    assert window.closed() == (0, "")


def test_idle_real_window_uses_under_two_percent_of_a_core(
    screen: Screen, plate: Path, tmp_path: Path
) -> None:
    """The processor time over three idle seconds must be under 2 % of a core."""
    window = Window(screen, tmp_path, plate, "--quality", "draft", "--proxy", 0.5)
    window.rest()
    before = window.cpu_seconds()
    time.sleep(3.0)
    used = window.cpu_seconds() - before
    screen.hand("windowclose", window.id)
    window.process.kill()
    window.process.communicate()
    assert used <= 0.06


def test_later_command_opens_its_file_in_the_running_window(
    screen: Screen, plate: Path, tmp_path: Path
) -> None:
    window = Window(screen, tmp_path, plate)
    other_plate = shutil.copy(plate, tmp_path / "other.exr")
    later_process = start_heatlens(other_plate, env=window.environment)
    later_process.communicate(timeout=PATIENCE_S)
    assert later_process.returncode == 0
    window.until(lambda: window.title() == "other.exr - heatlens", "the file named later")
    window.quit()
    code, output = window.closed()
    assert (code, output) == (0, "")


_STUCK = """
import sys
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from heatlens.studio.share.sharing import Sharing
from heatlens.studio.ui import window
window.FrameRenderer = lambda ctx: sys.stdin.read()  # what compiles shaders and takes long
window.Loop(window.open_window(Preferences().values), Start(""), Preferences(), Sharing())
"""


def test_real_window_shows_its_background_before_compiling_shaders(screen: Screen) -> None:
    environment = ENVIRONMENT | {"DISPLAY": screen.display}
    environment.pop("WAYLAND_DISPLAY", None)
    process = subprocess.Popen(
        [sys.executable, "-c", _STUCK], env=environment, stdin=subprocess.PIPE
    )
    screen.started.append(process)
    surround = [round(255 * value) for value in SURROUND]
    end = time.monotonic() + PATIENCE_S
    while (screen_pixels(screen) == surround).all(axis=2).mean() < 0.5:
        assert process.poll() is None and time.monotonic() < end
        time.sleep(0.1)
    process.kill()
    process.communicate()


def test_view_without_a_display_reports_one_message(plate: Path) -> None:
    environment = {k: v for k, v in ENVIRONMENT.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    process = start_heatlens(plate, env=environment)
    out, errors = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, out, errors.count("\n")) == (2, "", 1)
    assert "heatlens render" in errors and "DISPLAY" in errors


def test_view_reports_a_missing_plate_before_opening_a_window(capsys, tmp_path: Path) -> None:
    assert main([str(tmp_path / "nothing.exr")]) == 2
    assert "nothing.exr" in capsys.readouterr().err


def test_mistyped_command_gets_a_suggestion(capsys) -> None:
    assert main(["rendr", "plate.exr"]) == 2
    assert "Did you mean render?" in capsys.readouterr().err


def test_view_without_gui_libraries_says_what_to_install(capsys, monkeypatch, plate) -> None:
    monkeypatch.setitem(__import__("sys").modules, "heatlens.studio.ui.window", None)
    assert main([str(plate)]) == 2
    errors = capsys.readouterr().err
    assert "pip install 'heatlens[gui]'" in errors and "heatlens render" in errors


def test_still_life_asset_is_a_single_plate() -> None:
    from heatlens.core.base.paths import data_dir

    assert find_sequence(data_dir("assets") / "still_life.exr").is_single
