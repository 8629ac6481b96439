"""Keys that come faster than frames: each one counts, with the modifiers that were held with it.

ImGui takes all events that wait into one frame, but for a second change of the same key. So `Shift`
that is let go of before the next frame is not held any more where that frame sees the `/`. An idle
key, pressed and let go of behind every press, ends the frame there: what follows waits for the next
one. Source: `UpdateInputEvents` of Dear ImGui, "Trickling Rule".
"""

import glfw
from imgui_bundle import imgui

_IDLE = imgui.Key.f24  # on no keyboard, and nobody's shortcut
_MODIFIERS = range(glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SUPER + 1)


class FastKeys:
    """Stands between the window's key events and ImGui."""

    def __init__(self) -> None:
        self._has_press = False  # since the last end of a frame

    def before(self, key: int, action: int) -> None:
        """Call before ImGui hears of an event of GLFW."""
        if action == glfw.REPEAT:  # ImGui counts the time itself
            return
        if self._has_press:
            imgui.get_io().add_key_event(_IDLE, True)
            imgui.get_io().add_key_event(_IDLE, False)
        self._has_press = action == glfw.PRESS and key not in _MODIFIERS


def events_wait() -> bool:
    """Return whether ImGui holds events that it has kept for later frames."""
    return len(imgui.get_current_context().input_events_queue) > 0
