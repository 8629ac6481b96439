"""Check whether a window can be opened, and which OpenGL renderer it would use.

Run as a module, it opens a hidden window and prints the name of its renderer.
"""

import os
import sys
from pathlib import Path

import imgui_bundle
from imgui_bundle import imgui

from heatlens.render.gpu.context import window_device

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
    """Open and close a hidden window; return the name of its OpenGL renderer.

    Raise GpuError if none can be opened.
    """
    glfw.ERROR_REPORTING = "ignore"
    if not glfw.init():
        raise GpuError(f"{glfw.get_error()[1]!r}.")
    try:
        for hint, value in (
            (glfw.VISIBLE, 0),
            (glfw.CONTEXT_VERSION_MAJOR, 4),
            (glfw.CONTEXT_VERSION_MINOR, 3),
            (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
        ):
            glfw.window_hint(hint, value)
        window = glfw.create_window(64, 64, "heatlens", None, None)
        if not window:
            raise GpuError(f"OpenGL 4.3 is needed: {glfw.get_error()[1]!r}.")
        glfw.make_context_current(window)
        return window_device().name
    finally:
        glfw.terminate()


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
