"""Check whether a window can be opened, and which renderer would draw it.

Run as a module, it opens a hidden window and prints the name of its renderer.
"""

import os
import sys
from pathlib import Path

import imgui_bundle
from imgui_bundle import imgui

from heatlens.studio.ui.open_window import new_window

import glfw  # isort: skip

from heatlens.core.base.errors import GpuError, InputError
from heatlens.studio.ui import theme


def check_fonts() -> str:
    """Load the fonts of the interface; return their folder.

    Raise InputError if one cannot be loaded.
    """
    folder = Path(imgui_bundle.__file__).parent / "assets" / "fonts" / "Roboto"
    old_context, new_context = imgui.get_current_context(), imgui.create_context()
    imgui.set_current_context(new_context)
    try:
        theme.apply(1.0)
    except (RuntimeError, OSError) as error:
        raise InputError(f"The fonts in {folder} cannot be loaded: {error}.") from error
    finally:
        imgui.destroy_context(new_context)
        if old_context is not None:
            imgui.set_current_context(old_context)
    return str(folder)


def display_variable() -> str | None:
    """Return the display variable of the environment, for example "DISPLAY=:0"; None if unset."""
    for name in ("WAYLAND_DISPLAY", "DISPLAY"):
        if os.environ.get(name):
            return f"{name}={os.environ[name]}"
    return None


def try_window() -> str:
    """Open and close a hidden window; return the name of its renderer.

    Raise GpuError if none can be opened.
    """
    try:
        window = new_window((64, 64))
        name = window.device.name
        window.close()
    finally:
        glfw.terminate()
    return name


def _print_renderer() -> int:
    """Print the renderer of a window, or why there is none; return the exit code."""
    try:
        sys.stdout.write(f"{try_window()}\n")
    except GpuError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(_print_renderer())
