"""Ask the X server whether another program has taken the keyboard.

A window manager grabs the keyboard while it shows its list of windows; GLFW does not report that.
"""

import ctypes
from functools import cache

import glfw

from heatlens.ui.monitors import GlfwHandle

_ALREADY_GRABBED = 1  # X.h: AlreadyGrabbed
_ASYNCHRONOUS = 1  # GrabModeAsync
_NOW = 0  # CurrentTime


def is_keyboard_taken(window: GlfwHandle) -> bool:
    """Return True if another program has taken the keyboard from a GLFW `window`.

    Return False on systems other than X11. X has no query for this, so the keyboard is grabbed for
    a moment; GLFW ignores the focus changes that this causes.
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
