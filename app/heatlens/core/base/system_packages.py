"""Say what to install on this system besides Python's packages, in the words of the system."""

import os
import platform
import re
import sys
from typing import NamedTuple


class _Packages(NamedTuple):
    """How a family of Linux systems installs packages, and what it calls those of OpenGL."""

    install: str
    opengl: str
    system_ids: frozenset[str]  # ID and ID_LIKE of /etc/os-release


_FAMILIES = (
    _Packages("apt-get install", "libgl1 libegl1", frozenset({"debian", "ubuntu"})),
    _Packages(
        "dnf install", "mesa-libGL mesa-libEGL mesa-dri-drivers", frozenset({"fedora", "rhel"})
    ),
    _Packages(install="pacman -S", opengl="mesa libglvnd", system_ids=frozenset({"arch"})),
)


def opengl_advice() -> str:
    """Return what gives OpenGL 4.3 on this system, as a sentence without its full stop."""
    if sys.platform == "win32":
        return "Install the newest driver of the graphics card, from its maker"
    if sys.platform == "darwin":
        return (
            "OpenGL on macOS ends at 4.1: install heatlens[wgpu], which draws with Metal, or open "
            "a `heatlens serve` of another machine in the browser"
        )
    family = _family()
    if family is None:
        return "Install the packages of this system that hold libGL and libEGL"
    return f"Install OpenGL with: {family.install} {family.opengl}"


def driver_advice() -> str:
    """Return what to try where the driver is too old for OpenGL 4.3, without the full stop."""
    if sys.platform == "darwin":
        return opengl_advice()
    if sys.platform != "linux":
        return "A newer driver of the graphics card may have it"
    return "A newer driver may have it, and LIBGL_ALWAYS_SOFTWARE=1 draws with the processor"


def display_advice() -> str:
    """Return what a window needs where none can be opened, without the full stop."""
    need = "needs an X server or Wayland" if sys.platform == "linux" else "needs a desktop"
    has_display = sys.platform != "linux" or bool(
        {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys()
    )
    opengl = f". {opengl_advice()}" if has_display else ""
    return f"`heatlens render demo -o first.png` works without a display; a window {need}{opengl}"


def install_advice(package: str) -> str:
    """Return how to install a package that has one name everywhere on Linux, as an order."""
    family = _family()
    return f"install {package}" + (f" ({family.install} {package})" if family else "")


def shader_compiler_advice() -> str:
    """Return how to install glslangValidator, as an order without its full stop."""
    if sys.platform == "darwin":
        return "install it with: brew install glslang"
    if sys.platform == "win32":
        return "install the Vulkan SDK, which holds it"
    family = _family()
    is_debian = family is not None and "debian" in family.system_ids
    return install_advice("glslang-tools" if is_debian else "glslang")


def _family() -> _Packages | None:
    """Return the family of this Linux, or None for an unknown one."""
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        return None
    ids = {release.get("ID", ""), *release.get("ID_LIKE", "").split()}
    return next((family for family in _FAMILIES if family.system_ids & ids), None)


def quoted(word: str) -> str:
    """Return a word as the user types it in a shell of this system, in quotes where it needs any.

    On Windows that is `cmd` and PowerShell, which both take double quotes.
    """
    if sys.platform == "win32":
        is_plain = re.fullmatch(r"[\w.:\\/-]+", word)
        return word if is_plain else f'"{word}"'
    import shlex

    return shlex.quote(word)
