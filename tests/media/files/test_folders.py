"""Test the user's folders: the defaults of each system, and the variables that move them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from platformdirs import PlatformDirs, windows
from platformdirs.macos import MacOS
from platformdirs.windows import Windows

from heatlens.core.base import paths
from heatlens.core.base.paths import preferences_dir, rendered_frames_dir, reports_dir
from support.command_line import ENVIRONMENT

FOLDERS = (preferences_dir, rendered_frames_dir, reports_dir)
VARIABLES = ("HEATLENS_CONFIG_DIR", "HEATLENS_CACHE_DIR", "HEATLENS_LOG_DIR")
ON_LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="of Linux alone")


@pytest.fixture(autouse=True)
def no_variables(monkeypatch):
    """Remove every variable that moves a folder, and give the user a home."""
    xdg = ("XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_STATE_HOME")
    for name in (*VARIABLES, *xdg):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", "/home/ada")


@pytest.fixture
def on_system(monkeypatch):
    """Return a function that lets the program find itself on another system."""

    def on(system):
        monkeypatch.setattr(paths, "PlatformDirs", system)
        monkeypatch.setattr(paths, "_IS_LINUX", False)

    return on


@ON_LINUX
def test_user_folders_on_linux_are_those_of_version_0_1():
    assert [str(folder()) for folder in FOLDERS] == [
        "/home/ada/.config/heatlens",
        "/home/ada/.cache/heatlens/frames",
        "/home/ada/.local/state/heatlens",
    ]


@ON_LINUX
def test_user_folders_on_linux_follow_xdg_variables(monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", "/x/config")
    monkeypatch.setenv("XDG_CACHE_HOME", "/x/cache")
    monkeypatch.setenv("XDG_STATE_HOME", "/x/state")
    assert [str(folder()) for folder in FOLDERS] == [
        "/x/config/heatlens",
        "/x/cache/heatlens/frames",
        "/x/state/heatlens",
    ]


def test_user_folders_on_macos_are_in_library(on_system):
    on_system(MacOS)
    library = "/home/ada/Library"
    assert [folder().as_posix() for folder in FOLDERS] == [
        f"{library}/Application Support/heatlens",
        f"{library}/Caches/heatlens/frames",
        f"{library}/Logs/heatlens",
    ]


def test_user_folders_on_windows_roam_for_preferences_only(monkeypatch, on_system):
    """The folders are read from the environment here; only Windows can ask its shell."""
    on_system(Windows)
    monkeypatch.setattr(windows, "get_win_folder", windows.get_win_folder_from_env_vars)
    monkeypatch.setenv("APPDATA", "/roaming")
    monkeypatch.setenv("LOCALAPPDATA", "/local")
    assert [folder().as_posix() for folder in FOLDERS] == [
        "/roaming/heatlens",
        "/local/heatlens/Cache/frames",
        "/local/heatlens/Logs",
    ]


@pytest.mark.parametrize("system", [PlatformDirs, MacOS, Windows])
def test_user_folders_follow_heatlens_variables_on_every_system(monkeypatch, on_system, system):
    on_system(system)
    for name in VARIABLES:
        monkeypatch.setenv(name, f"/mine/{name}")
    assert [folder() for folder in FOLDERS] == [
        Path("/mine/HEATLENS_CONFIG_DIR"),
        Path("/mine/HEATLENS_CACHE_DIR/frames"),
        Path("/mine/HEATLENS_LOG_DIR"),
    ]


def test_user_folders_ignore_empty_variables(monkeypatch):
    usual = [folder() for folder in FOLDERS]
    for name in VARIABLES:
        monkeypatch.setenv(name, "")
    assert [folder() for folder in FOLDERS] == usual


@ON_LINUX
def test_preferences_dir_without_home_is_absolute():
    """A container whose user is in no list and whose environment is empty has no home."""
    code = (
        "import os; os.path.expanduser = lambda text: text\n"
        "from heatlens.core.base.paths import preferences_dir; print(preferences_dir())"
    )
    environment = {k: v for k, v in ENVIRONMENT.items() if k not in (*VARIABLES, "HOME")}
    run = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    folder = Path(run.stdout.strip())
    assert folder.is_absolute() and folder.parts[0] == os.sep and "~" not in folder.parts
