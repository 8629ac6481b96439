"""Alt, alone and held over the picture, shows it without depth of field.

Window managers take Alt+Tab and Alt+F4, and menus are opened with Alt: a moment must pass, no other
key may be down, the pointer must be over the picture, and no window manager may have the keyboard.
"""

from collections.abc import Callable

from imgui_bundle import imgui

HOLD_S = 0.25
_Key = imgui.Key
_ALTS = (_Key.left_alt, _Key.right_alt)
_OTHERS = tuple(key for key in _Key if _Key.tab <= key <= _Key.oem102 and key not in _ALTS)


class AltHeld:
    """Watches the Alt key from frame to frame."""

    def __init__(self) -> None:
        """Make a watch; set `is_keyboard_taken` where another program may take the keyboard."""
        self.is_keyboard_taken: Callable[[], bool] = lambda: False
        self._is_over = False
        self._since_s: float | None = None  # None: it is not held, or not alone
        self._is_spoilt = False  # by another key, until Alt is let go of

    def is_over(self, is_hovered: bool) -> bool:
        """Return True while Alt counts; to be called once a frame."""
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
            self._is_spoilt = self.is_keyboard_taken()  # by the list of windows on Alt+Tab
            self._is_over = not self._is_spoilt
        return self._is_over

    def seconds_until_needed(self) -> float | None:
        """Return how long the window may sleep while Alt is held; None: nothing will change."""
        if self._since_s is None:
            return None
        left_s = self._since_s + HOLD_S - imgui.get_time()
        return max(left_s, 0.01) if left_s > 0 else None
