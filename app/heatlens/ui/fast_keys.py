"""Keys that come faster than frames: each one counts, with the modifiers that were held with it.

ImGui takes all events that wait into one frame, but for a second change of the same key. So `Shift`
that is let go of before the next frame is not held any more where that frame sees the `/`. An idle
key, pressed and let go of behind every press, ends the frame there: what follows waits for the next
one. Source: `UpdateInputEvents` of Dear ImGui, "Trickling Rule".

GLFW leaves out a press that has the time, in milliseconds, of the last press of the same key: it
takes it for one that an input method has sent twice (`processEvent` in x11_window.c). A `Ctrl` that
is pressed twice within a millisecond is therefore not held where GLFW is asked, as ImGui asks it.
Each key event tells the modifiers by itself, though, and these count here.
"""

import glfw
from imgui_bundle import imgui

_K = imgui.Key
_IDLE = _K.f24  # on no keyboard, and nobody's shortcut
_MODIFIERS = range(glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SUPER + 1)
_MODS = {
    glfw.MOD_CONTROL: _K.mod_ctrl,
    glfw.MOD_SHIFT: _K.mod_shift,
    glfw.MOD_ALT: _K.mod_alt,
    glfw.MOD_SUPER: _K.mod_super,
}
_RUNS = (  # GLFW and ImGui count letters, digits and function keys in the same order
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
    """Return the key of ImGui for one of GLFW, as far as shortcuts use it; else None."""
    for first, last, begin in _RUNS:
        if first <= key <= last:
            return imgui.Key(int(begin) + key - first)
    return _SINGLE.get(key)


class FastKeys:
    """Stands between the window's key events and ImGui."""

    def __init__(self) -> None:
        self._has_press = False  # since the last end of a frame

    def before(self, key: int, action: int, mods: int = 0) -> None:
        """Call before ImGui hears of an event of GLFW, with the modifiers of that event."""
        if action == glfw.REPEAT:  # ImGui counts the time itself
            return
        if self._has_press:
            _end_frame()
        self._has_press = action == glfw.PRESS and key not in _MODIFIERS
        pressed, io = imgui_key(key) if self._has_press else None, imgui.get_io()
        if pressed is None:
            return
        for bit, mod in _MODS.items():  # ImGui leaves out what changes nothing
            io.add_key_event(mod, bool(mods & bit))
        io.add_key_event(pressed, True)
        _end_frame()  # before GLFW is asked for the modifiers
        self._has_press = False


def _end_frame() -> None:
    """Let what follows wait for the next frame."""
    io = imgui.get_io()
    io.add_key_event(_IDLE, True)
    io.add_key_event(_IDLE, False)


def events_wait() -> bool:
    """Return whether ImGui holds events that it has kept for later frames."""
    return len(imgui.get_current_context().input_events_queue) > 0
