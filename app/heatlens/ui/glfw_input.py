"""Put the events of GLFW for keys and pointer into the input queue, in ImGui's terms.

ImGui's own callbacks are not used: they would ask GLFW which modifiers are held now, but a key may
have waited in the queue. GLFW drops a press with the same time in milliseconds as the last press of
that key, because an input method may have sent it twice (`processEvent` in x11_window.c), so that
after two presses of `Ctrl` in one millisecond it reports it as released. But each event carries its
own modifiers, and those are used here.
"""

import ctypes
from collections.abc import Callable

from imgui_bundle import imgui  # import before glfw, so that both share one libglfw

from heatlens.ui.devices import GlfwHandle

import glfw  # isort: skip

from heatlens.ui.input_queue import Button, Focus, InputQueue, Motion, Press, Release, Wheel

_K = imgui.Key
_MODS = {
    glfw.MOD_CONTROL: _K.mod_ctrl,
    glfw.MOD_SHIFT: _K.mod_shift,
    glfw.MOD_ALT: _K.mod_alt,
    glfw.MOD_SUPER: _K.mod_super,
}
_OWN_MOD = {  # in its own event, a modifier may be missing when pressed, or present when released
    key: mod
    for name, mod in zip(("CONTROL", "SHIFT", "ALT", "SUPER"), _MODS, strict=True)
    for key in (getattr(glfw, f"KEY_LEFT_{name}"), getattr(glfw, f"KEY_RIGHT_{name}"))
}
_PRINTED = range(glfw.KEY_SPACE, glfw.KEY_GRAVE_ACCENT + 1)


def _glfw_name(name: str) -> str:
    """Return GLFW's name of a key of ImGui."""
    name = name.lstrip("_").upper().removesuffix("_ARROW").replace("CTRL", "CONTROL")
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

    def __init__(self, window: GlfwHandle, queue: InputQueue, woken: Callable[[], None]) -> None:
        """Register the callbacks; ImGui asks GLFW only for sizes and cursors."""
        self._queue = queue
        self._woken = woken
        pointer = ctypes.cast(window, ctypes.c_void_p).value or 0
        imgui.backends.glfw_init_for_opengl(pointer, False)
        # Without this call ImGui would ask GLFW in every frame where the pointer is now.
        imgui.backends.glfw_cursor_enter_callback(pointer, 1)
        glfw.set_key_callback(window, self._key)
        glfw.set_char_callback(window, lambda _, code: self._text(chr(code)))
        glfw.set_mouse_button_callback(window, self._button)
        glfw.set_cursor_pos_callback(window, lambda _, x, y: self._add(Motion((x, y))))
        glfw.set_cursor_enter_callback(window, self._entered)
        glfw.set_scroll_callback(window, lambda _, x, y: self._add(Wheel(x, y)))
        glfw.set_window_focus_callback(window, lambda _, is_here: self._add(Focus(bool(is_here))))

    def _add(self, act: Press | Release | Motion | Button | Wheel | Focus) -> None:
        self._queue.add(act)
        self._woken()

    def _text(self, text: str) -> None:
        self._queue.add_text(text)
        self._woken()

    def _key(self, _window: object, code: int, scancode: int, action: int, mods: int) -> None:
        if action == glfw.REPEAT:  # ImGui repeats held keys by itself
            self._woken()
            return
        is_down, own = action == glfw.PRESS, _OWN_MOD.get(code, 0)
        held = imgui_mods(mods | own if is_down else mods & ~own)
        printed = glfw.get_key_name(code, scancode) if code in _PRINTED else None
        key = imgui_key(code, printed)
        if is_down:
            self._add(Press(key, held))
        elif key is not None:
            self._add(Release(key, held))

    def _button(self, _window: object, number: int, action: int, mods: int) -> None:
        self._add(Button(number, action == glfw.PRESS, imgui_mods(mods)))

    def _entered(self, window: GlfwHandle, is_inside: int) -> None:
        self._add(Motion(glfw.get_cursor_pos(window) if is_inside else None))
