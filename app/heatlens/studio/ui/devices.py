"""Ask GLFW about monitors, game pads and the keyboard, and queue its events in ImGui's terms.

Each event carries its own modifiers, and those are used here instead of ImGui's own callbacks. The
callbacks would ask GLFW which modifiers are held now, but a key may have waited in the queue. GLFW
also drops a press with the same time in milliseconds as the last press of that key, because an
input method may have sent it twice (`processEvent` in x11_window.c): after two presses of `Ctrl` in
one millisecond, it reports the key as released.
"""

import ctypes
import re
import sys
from collections.abc import Callable
from functools import cache
from typing import Any

from imgui_bundle import imgui  # before glfw, so that both share one libglfw

import glfw  # isort: skip

from heatlens.studio.ui.input_queue import Button, Focus, InputQueue, Motion, Press, Release, Wheel

# X.h: AlreadyGrabbed, GrabModeAsync, CurrentTime
_ALREADY_GRABBED, _ASYNCHRONOUS, _NOW = 1, 1, 0
_USUAL_AREA = 1600, 900  # screen units, if the system does not report the size

GlfwHandle = Any  # a window or a monitor: the types of glfw leave out that there may be none


def work_area_of(monitor: GlfwHandle) -> tuple[int, int]:
    """Return the size of the work area of a monitor, in screen units."""
    if not monitor:
        return _USUAL_AREA
    _, _, width, height = glfw.get_monitor_workarea(monitor)
    return (width, height) if width and height else _USUAL_AREA


def screen_name(window: GlfwHandle) -> str:
    """Return name and size of the monitor that contains the middle of the window."""
    monitor = monitor_of(window)
    if not monitor:
        return ""
    name, size = glfw.get_monitor_name(monitor), glfw.get_video_mode(monitor).size
    text = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
    return f"{text} {size.width}x{size.height}"


def screen_width_px(window: GlfwHandle) -> int:
    """Return the width of the monitor that contains the middle of the window; 0 without one."""
    monitor = monitor_of(window)
    return int(glfw.get_video_mode(monitor).size.width) if monitor else 0


def units_scale(window: GlfwHandle) -> float:
    """Return by how much the interface must grow in screen units, as the system wishes.

    On macOS and Wayland the screen units themselves grow with the scale of the monitor.
    """
    if glfw.get_platform() in (glfw.PLATFORM_COCOA, glfw.PLATFORM_WAYLAND):
        return 1.0
    return float(glfw.get_window_content_scale(window)[0])


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
            return {f"axis {index + 1}": float(values[index]) for index in range(count)}
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


_K = imgui.Key
# On a Mac, Cmd does what Ctrl does elsewhere, and Ctrl what the logo key does.
_CTRL, _SUPER = ("SUPER", "CONTROL") if sys.platform == "darwin" else ("CONTROL", "SUPER")
_MODS = {
    getattr(glfw, f"MOD_{_CTRL}"): _K.mod_ctrl,
    glfw.MOD_SHIFT: _K.mod_shift,
    glfw.MOD_ALT: _K.mod_alt,
    getattr(glfw, f"MOD_{_SUPER}"): _K.mod_super,
}
_OWN_MOD = {  # in its own event, a modifier may be missing when pressed, or present when released
    key: mod
    for name, mod in zip((_CTRL, "SHIFT", "ALT", _SUPER), _MODS, strict=True)
    for key in (getattr(glfw, f"KEY_LEFT_{name}"), getattr(glfw, f"KEY_RIGHT_{name}"))
}
_PRINTED = range(glfw.KEY_SPACE, glfw.KEY_GRAVE_ACCENT + 1)


def _glfw_name(name: str) -> str:
    """Return GLFW's name of a key of ImGui."""
    name = name.lstrip("_").upper().removesuffix("_ARROW")
    name = re.sub("CTRL|SUPER", lambda it: _CTRL if it[0] == "CTRL" else _SUPER, name)
    return f"KEY_{name.replace('KEYPAD_', 'KP_').replace('KEYPAD', 'KP_')}"


_KEYS = {
    getattr(glfw, _glfw_name(name)): key  # the name of a member may be that of an alias
    for name, key in _K.__members__.items()
    if hasattr(glfw, _glfw_name(name))
}


def imgui_key(key: int, printed: str | None = None) -> imgui.Key | None:
    """Return ImGui's key for a GLFW key code; None for a key that it does not know.

    `printed` is the character of the key in the user's layout: GLFW names keys by their position on
    an American keyboard.
    """
    if printed and printed.isascii() and len(printed) == 1:
        key = ord(printed.upper())  # GLFW's codes of printed keys are those of ASCII
    return _KEYS.get(key)


def imgui_mods(mods: int) -> int:
    """Return ImGui's modifiers for those of GLFW."""
    return sum(int(mod) for bit, mod in _MODS.items() if mods & bit)


class GlfwInput:
    """The callbacks of a window, which fill a queue and wake the loop."""

    def __init__(self, window: GlfwHandle, queue: InputQueue, wake: Callable[[], None]) -> None:
        """Register the callbacks; ImGui asks GLFW only for sizes and cursors."""
        self._queue = queue
        self._wake = wake
        pointer = ctypes.cast(window, ctypes.c_void_p).value or 0
        imgui.backends.glfw_init_for_other(pointer, False)
        # Without this call ImGui would ask GLFW in every frame where the pointer is now.
        imgui.backends.glfw_cursor_enter_callback(pointer, 1)
        glfw.set_key_callback(window, self._on_key)
        glfw.set_char_callback(window, lambda _, code: self._queue_text(chr(code)))
        glfw.set_mouse_button_callback(window, self._on_button)
        glfw.set_cursor_pos_callback(window, lambda _, x, y: self._queue_event(Motion((x, y))))
        glfw.set_cursor_enter_callback(window, self._on_pointer_entered)
        glfw.set_scroll_callback(window, lambda _, x, y: self._queue_event(Wheel(x, y)))
        glfw.set_window_focus_callback(
            window, lambda _, is_here: self._queue_event(Focus(bool(is_here)))
        )

    def _queue_event(self, event: Press | Release | Motion | Button | Wheel | Focus) -> None:
        """Queue an event for the next frame, and wake the window for it."""
        self._queue.add(event)
        self._wake()

    def _queue_text(self, text: str) -> None:
        """Queue typed text for the next frame, and wake the window for it."""
        self._queue.add_text(text)
        self._wake()

    def _on_key(self, _window: object, code: int, scancode: int, action: int, mods: int) -> None:
        """Queue a press or release of a key with the modifiers that are held after it."""
        if action == glfw.REPEAT:  # ImGui repeats held keys by itself
            self._wake()
            return
        is_down, own_modifier = action == glfw.PRESS, _OWN_MOD.get(code, 0)
        held_mods = imgui_mods(mods | own_modifier if is_down else mods & ~own_modifier)
        printed = glfw.get_key_name(code, scancode) if code in _PRINTED else None
        key = imgui_key(code, printed)
        if is_down:
            self._queue_event(Press(key, held_mods))
        elif key is not None:
            self._queue_event(Release(key, held_mods))

    def _on_button(self, _window: object, number: int, action: int, mods: int) -> None:
        self._queue_event(Button(number, is_down=action == glfw.PRESS, mods=imgui_mods(mods)))

    def _on_pointer_entered(self, window: GlfwHandle, is_inside: int) -> None:
        self._queue_event(Motion(glfw.get_cursor_pos(window) if is_inside else None))
