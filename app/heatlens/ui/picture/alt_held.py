"""Detect that Alt alone is held over the picture, which shows it without depth of field.

Window managers use Alt+Tab and Alt+F4, and Alt opens menus. Alt therefore counts only after a
moment, with no other key down, the pointer over the picture, and the keyboard not grabbed.
"""

from collections.abc import Callable

from imgui_bundle import imgui

HOLD_S = 0.25
_Key = imgui.Key
_ALTS = (_Key.left_alt, _Key.right_alt)
_OTHERS = tuple(key for key in _Key if _Key.tab <= key <= _Key.oem102 and key not in _ALTS)


class AltHeld:
    """The state of the Alt key, updated once a frame."""

    def __init__(self) -> None:
        """Create it; set `is_keyboard_taken` on systems where a program can grab the keyboard."""
        self.is_keyboard_taken: Callable[[], bool] = lambda: False
        self._is_over = False
        self._since_s: float | None = None  # when Alt was pressed; None if not held, or not alone
        self._is_spoilt = False  # another key was pressed since; lasts until Alt is released

    def is_over(self, is_hovered: bool) -> bool:
        """Return True while Alt counts as held over the picture; call this once a frame."""
        io = imgui.get_io()
        if not io.key_alt or io.want_text_input:
            self._since_s, self._is_spoilt, self._is_over = None, False, False
            return False
        self._is_spoilt |= any(imgui.is_key_down(key) for key in _OTHERS)
        if self._is_spoilt or not is_hovered:
            self._since_s, self._is_over = None, False
            return False
        if self._since_s is None:
            self._since_s = imgui.get_time()
        if not self._is_over and imgui.get_time() - self._since_s >= HOLD_S:
            self._is_spoilt = self.is_keyboard_taken()  # for example by the window list of Alt+Tab
            self._is_over = not self._is_spoilt
        return self._is_over

    def seconds_until_needed(self) -> float | None:
        """Return how many seconds the loop may sleep until Alt counts; None if nothing is due."""
        if self._since_s is None:
            return None
        left_s = self._since_s + HOLD_S - imgui.get_time()
        return max(left_s, 0.01) if left_s > 0 else None
