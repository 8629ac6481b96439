"""Open the GLFW window at its last size, or raise an error with the reason why that fails."""

import threading
from typing import Any

from heatlens.studio.ui.devices import work_area_of  # imports ImGui before glfw, see `window.py`

import glfw  # isort: skip

from heatlens.core.base.errors import (
    GpuError,
    HeatlensError,
    MissingPackageError,
    NoWindowError,
)
from heatlens.core.base.system_packages import display_advice, driver_advice
from heatlens.core.model.view.ui_sizes import fitted_size
from heatlens.render.gpu.context import Gpu, choose_gpu
from heatlens.studio.settings.preferences import PreferenceValues
from heatlens.studio.ui.icon import icon
from heatlens.studio.ui.window_gpu import WindowGpu, attach, hints_of, window_libraries

_SIZE = 1600, 900
_NAME = "heatlens"  # by it a desktop knows which program a window belongs to
_ICON_SIZES_PX = 16, 32, 64


# `open_window` reports errors as NoWindowError, and waking a window that is not there yet is none.
glfw.ERROR_REPORTING = "ignore"


_is_woken = threading.Event()


def wake_window() -> None:
    """Make the loop of the window turn; any thread may call this, also while there is none."""
    _is_woken.set()
    glfw.post_empty_event()


def take_wake() -> bool:
    """Return True if the window was woken since the last call.

    GLFW does not tell, and forgets it with the next events that it handles.
    """
    is_woken = _is_woken.is_set()
    _is_woken.clear()
    return is_woken


def open_window(preferences: PreferenceValues) -> WindowGpu:
    """Return a new window, which is shown. Raises NoWindowError."""
    gpu = new_window(_SIZE)
    window = gpu.handle
    # Wayland takes the icon of the desktop file instead.
    icons: list[Any] = [icon(size) for size in _ICON_SIZES_PX]
    glfw.set_window_icon(window, len(icons), icons)
    # Set the size once the window exists: the remembered size already includes the monitor's scale.
    size = preferences.window_size or glfw.get_window_size(window)
    glfw.set_window_size(window, *fitted_size(size, work_area_of(glfw.get_primary_monitor())))
    if preferences.is_maximized:
        glfw.maximize_window(window)
    glfw.show_window(window)
    return gpu


def new_window(size: tuple[int, int]) -> WindowGpu:
    """Return a new hidden window, drawn by the library that was chosen, or by the first that can.

    Processes that are started later draw with wgpu if the window does. Raise NoWindowError, or
    another GpuError, with what the first library lacks.
    """
    if not glfw.init():
        raise NoWindowError(f"No window can be opened: {_glfw_error()}. {display_advice()}.")
    reasons: list[HeatlensError] = []
    for gpu in window_libraries():
        try:
            window = _window_drawn_by(gpu, size)
        except (GpuError, MissingPackageError) as error:
            reasons.append(error)
            continue
        if gpu is Gpu.WGPU:
            choose_gpu(gpu)
        return window
    glfw.terminate()
    raise reasons[0]


def _window_drawn_by(gpu: Gpu, size: tuple[int, int]) -> WindowGpu:
    """Return a new hidden window. Raises GpuError, or MissingPackageError, where `gpu` cannot."""
    glfw.default_window_hints()
    hints = hints_of(gpu) | {glfw.SCALE_TO_MONITOR: 1, glfw.VISIBLE: 0}
    for hint, value in hints.items():
        glfw.window_hint(hint, value)
    for name_hint in (glfw.X11_CLASS_NAME, glfw.X11_INSTANCE_NAME, glfw.WAYLAND_APP_ID):
        glfw.window_hint_string(name_hint, _NAME)
    window = glfw.create_window(*size, _NAME, None, None)
    glfw.window_hint(glfw.VISIBLE, 1)  # the default, for other windows
    if not window:
        needed = " with OpenGL 4.3" if gpu is Gpu.OPENGL else ""
        raise NoWindowError(f"No window{needed} can be opened: {_glfw_error()}. {driver_advice()}.")
    try:
        return attach(gpu, window)
    except (GpuError, MissingPackageError):
        glfw.destroy_window(window)
        raise


def _glfw_error() -> str:
    """Return the last error of GLFW as text."""
    code, description = glfw.get_error()
    if not description:
        return f"error {code:#x}" if code else "no reason was given"
    return str(description.decode() if isinstance(description, bytes) else description).rstrip(".")
