"""Ask the system about its devices: monitors, game pads, and who has the keyboard."""

import ctypes
from functools import cache
from typing import Any

from imgui_bundle import imgui  # noqa: F401  # before glfw: both then share one libglfw

import glfw  # isort: skip

# X.h: AlreadyGrabbed, GrabModeAsync, CurrentTime
_ALREADY_GRABBED, _ASYNCHRONOUS, _NOW = 1, 1, 0
_USUAL_ROOM = 1600, 900  # screen units, if the system does not report the size

GlfwHandle = Any  # a window or a monitor: the types of glfw leave out that there may be none


def room_of(monitor: GlfwHandle) -> tuple[int, int]:
    """Return the size of the work area of a monitor, in screen units."""
    if not monitor:
        return _USUAL_ROOM
    _, _, width, height = glfw.get_monitor_workarea(monitor)
    return (width, height) if width and height else _USUAL_ROOM


def screen_name(window: GlfwHandle) -> str:
    """Return name and size of the monitor that contains the middle of the window."""
    monitor = monitor_of(window)
    if not monitor:
        return ""
    name, size = glfw.get_monitor_name(monitor), glfw.get_video_mode(monitor).size
    text = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
    return f"{text} {size.width}x{size.height}"


def monitor_of(window: GlfwHandle) -> GlfwHandle:
    """Return the monitor with the middle of the window, else the first; None if there is none."""
    (x, y), (width, height) = glfw.get_window_pos(window), glfw.get_window_size(window)
    for monitor in glfw.get_monitors():
        left, top = glfw.get_monitor_pos(monitor)
        size = glfw.get_video_mode(monitor).size
        across, down = x + width // 2 - left, y + height // 2 - top
        if 0 <= across < size.width and 0 <= down < size.height:
            return monitor
    return glfw.get_primary_monitor()


def pad_axes() -> dict[str, float] | None:
    """Return the positions of the axes of the first pad, -1 to 1; None if none is connected."""
    for pad in range(glfw.JOYSTICK_1, glfw.JOYSTICK_LAST + 1):
        if glfw.joystick_present(pad):
            values, count = glfw.get_joystick_axes(pad)
            return {f"axis {at + 1}": float(values[at]) for at in range(count)}
    return None


def is_keyboard_taken(window: GlfwHandle) -> bool:
    """Return True if another program has taken the keyboard from a GLFW `window`.

    A window manager grabs the keyboard while it shows its list of windows; GLFW does not report
    that. Return False on systems other than X11. X has no query for this, so the keyboard is
    grabbed for a moment; GLFW ignores the focus changes that this causes.
    """
    if glfw.get_platform() != glfw.PLATFORM_X11:
        return False
    library = _x11()
    if library is None:
        return False
    display = glfw.get_x11_display()  # type: ignore[no-untyped-call]
    drawable = glfw.get_x11_window(window)
    status = library.XGrabKeyboard(display, drawable, 0, _ASYNCHRONOUS, _ASYNCHRONOUS, _NOW)
    if status != _ALREADY_GRABBED:
        library.XUngrabKeyboard(display, _NOW)
        library.XFlush(display)
    return bool(status == _ALREADY_GRABBED)


@cache
def _x11() -> ctypes.CDLL | None:
    """Return the X11 library that GLFW uses; None if it cannot be loaded."""
    try:
        library = ctypes.CDLL("libX11.so.6")
    except OSError:
        return None
    display, window, option, time = ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_ulong
    library.XGrabKeyboard.argtypes = [display, window, option, option, option, time]
    library.XUngrabKeyboard.argtypes = [display, time]
    library.XFlush.argtypes = [display]
    return library
