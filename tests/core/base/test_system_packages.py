"""Test that what to install is said in the words of the system."""

from types import SimpleNamespace

import pytest

from heatlens.core.base import extras, system_packages
from heatlens.core.base.errors import MissingPackageError

SYSTEMS = {
    "debian": ("linux", {"ID": "debian"}, "apt-get install libgl1 libegl1"),
    "mint": ("linux", {"ID": "linuxmint", "ID_LIKE": "ubuntu debian"}, "apt-get install libgl1"),
    "fedora": ("linux", {"ID": "fedora"}, "dnf install mesa-libGL mesa-libEGL"),
    "rocky": ("linux", {"ID": "rocky", "ID_LIKE": "rhel centos fedora"}, "dnf install mesa-libGL"),
    "arch": ("linux", {"ID": "arch"}, "pacman -S mesa"),
    "unknown": ("linux", {"ID": "plan9"}, "libGL and libEGL"),
    "windows": ("win32", None, "driver of the graphics card"),
    "macos": ("darwin", None, "heatlens serve"),
}


@pytest.fixture(params=SYSTEMS)
def words_of_system(request, monkeypatch) -> str:
    """Stand on one of the systems, and return what its advice must say."""
    platform, release, words = SYSTEMS[request.param]

    def read_release() -> dict[str, str]:
        if release is None:
            raise OSError("no /etc/os-release")
        return release

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(system_packages, "sys", SimpleNamespace(platform=platform))
    monkeypatch.setattr(
        system_packages, "platform", SimpleNamespace(freedesktop_os_release=read_release)
    )
    return words


def test_advice_names_packages_of_the_system_alone(words_of_system):
    others = {"apt-get", "dnf", "pacman", "LIBGL"} - set(words_of_system.split())
    for advice in (
        system_packages.opengl_advice(),
        system_packages.display_advice(),
        extras.extra("gui").install_command(),
    ):
        assert words_of_system in advice
        assert not any(other in advice for other in others), advice


def test_advice_without_a_display_names_no_packages(words_of_system, monkeypatch):
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    is_linux = system_packages.sys.platform == "linux"
    assert (words_of_system in system_packages.display_advice()) != is_linux


def test_old_driver_is_drawn_around_on_linux_alone(words_of_system):
    is_linux = system_packages.sys.platform == "linux"
    assert ("LIBGL_ALWAYS_SOFTWARE" in system_packages.driver_advice()) == is_linux


@pytest.mark.parametrize(
    ("word", "on_linux", "on_windows"),
    [
        ("heatlens[gui]", "'heatlens[gui]'", '"heatlens[gui]"'),
        ("plate.exr", "plate.exr", "plate.exr"),
        ("my plate.exr", "'my plate.exr'", '"my plate.exr"'),
        (r"C:\shots\a-1.exr", r"'C:\shots\a-1.exr'", r"C:\shots\a-1.exr"),
        ("a&b", "'a&b'", '"a&b"'),
        ("", "''", '""'),
    ],
)
def test_words_are_quoted_for_the_shell_of_the_system(monkeypatch, word, on_linux, on_windows):
    for platform, quoted in (("linux", on_linux), ("win32", on_windows)):
        monkeypatch.setattr(system_packages, "sys", SimpleNamespace(platform=platform))
        assert system_packages.quoted(word) == quoted


def test_frozen_program_advises_an_installation_for_missing_parts(monkeypatch):
    """pip cannot add a package to the folder without Python."""
    monkeypatch.setattr("sys.frozen", True, raising=False)
    with (
        pytest.raises(MissingPackageError, match=r"made without it; install .* pip install"),
        extras.extra("usd").require(package="usd-core"),
    ):
        raise ImportError("No module named 'pxr'")
