"""Give ImGui every key press with its modifiers, also when keys come faster than frames.

ImGui handles all waiting events in one frame, except a second change of the same key. If `Shift`
is released before the next frame, that frame sees `/` without `Shift`. Pressing and releasing an
unused key after every press ends the frame there: later events wait for the next frame.
Source: `UpdateInputEvents` of Dear ImGui, "Trickling Rule".

GLFW drops a press with the same time in milliseconds as the last press of that key, because an
input method may have sent it twice (`processEvent` in x11_window.c). After two presses of `Ctrl`
within one millisecond, GLFW therefore reports it as released, and ImGui asks GLFW. But each key
event carries its own modifiers, and this module uses those.

Text that is typed into a field needs none of that, and would take three frames a letter.

A tab takes a click only if the pointer was over it in the frame before. So a press of a mouse
button that comes together with the movement to that place waits for the next frame as well.
"""

import glfw
from imgui_bundle import imgui

_K = imgui.Key
_IDLE = _K.f24  # a key that keyboards do not have and no shortcut uses
_PRINTED = range(glfw.KEY_SPACE, glfw.KEY_GRAVE_ACCENT + 1)
_COMMANDS = glfw.MOD_CONTROL | glfw.MOD_ALT | glfw.MOD_SUPER
_MODIFIERS = range(glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SUPER + 1)
_MODS = {
    glfw.MOD_CONTROL: _K.mod_ctrl,
    glfw.MOD_SHIFT: _K.mod_shift,
    glfw.MOD_ALT: _K.mod_alt,
    glfw.MOD_SUPER: _K.mod_super,
}
_RUNS = (  # GLFW and ImGui number letters, digits and function keys in the same order
    (glfw.KEY_A, glfw.KEY_Z, _K.a),
    (glfw.KEY_0, glfw.KEY_9, _K._0),
    (glfw.KEY_F1, glfw.KEY_F12, _K.f1),
)
_SINGLE = {
    glfw.KEY_SPACE: _K.space, glfw.KEY_TAB: _K.tab, glfw.KEY_DELETE: _K.delete,
    glfw.KEY_BACKSPACE: _K.backspace,
    glfw.KEY_LEFT: _K.left_arrow, glfw.KEY_RIGHT: _K.right_arrow,
    glfw.KEY_UP: _K.up_arrow, glfw.KEY_DOWN: _K.down_arrow,
    glfw.KEY_HOME: _K.home, glfw.KEY_END: _K.end,
    glfw.KEY_COMMA: _K.comma, glfw.KEY_PERIOD: _K.period, glfw.KEY_SLASH: _K.slash,
    glfw.KEY_MINUS: _K.minus, glfw.KEY_EQUAL: _K.equal,
    glfw.KEY_LEFT_BRACKET: _K.left_bracket, glfw.KEY_RIGHT_BRACKET: _K.right_bracket,
}  # fmt: skip


def imgui_key(key: int) -> imgui.Key | None:
    """Return ImGui's key for a GLFW key code; None for keys that no shortcut uses."""
    for first, last, begin in _RUNS:
        if first <= key <= last:
            return imgui.Key(int(begin) + key - first)
    return _SINGLE.get(key)


class FastKeys:
    """Prepare ImGui for each key event of the window."""

    def __init__(self) -> None:
        self._has_press = False  # whether a key was pressed since the last `_end_frame`

    def before(self, key: int, action: int, mods: int = 0) -> None:
        """Prepare for a GLFW key event with its modifiers; call before ImGui handles the event."""
        if action == glfw.REPEAT:  # ImGui repeats held keys by itself
            return
        if self._has_press:
            _end_frame()
        io = imgui.get_io()
        if io.want_text_input and key in _PRINTED and not mods & _COMMANDS:
            self._has_press = False
            return
        self._has_press = action == glfw.PRESS and key not in _MODIFIERS
        pressed = imgui_key(key) if self._has_press else None
        if pressed is None:
            return
        for bit, mod in _MODS.items():  # ImGui ignores events that change nothing
            io.add_key_event(mod, bool(mods & bit))
        io.add_key_event(pressed, True)
        _end_frame()  # so that this frame does not ask GLFW for the modifiers
        self._has_press = False

    def before_click(self) -> None:
        """Prepare for a press of a mouse button; call before ImGui handles the event."""
        _end_frame()
        self._has_press = False


def _end_frame() -> None:
    """Make all following events wait for the next frame."""
    io = imgui.get_io()
    io.add_key_event(_IDLE, True)
    io.add_key_event(_IDLE, False)


def events_wait() -> bool:
    """Return True if ImGui has queued events for later frames."""
    return len(imgui.get_current_context().input_events_queue) > 0
