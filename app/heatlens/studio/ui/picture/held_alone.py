"""Detect that Alt or Ctrl alone is held over the picture: it has a meaning of its own there.

Window managers use Alt+Tab and Alt+F4, and Alt opens menus. It therefore counts only after a
moment, with no other key down, the pointer over the picture, and the keyboard not grabbed.
"""

from collections.abc import Callable

from imgui_bundle import imgui

HOLD_S = 0.25
_Key = imgui.Key
_KEYS = {
    _Key.mod_alt: (_Key.left_alt, _Key.right_alt),
    _Key.mod_ctrl: (_Key.left_ctrl, _Key.right_ctrl),
}


class HeldAlone:
    """The state of the key, updated once a frame."""

    def __init__(self, held: imgui.Key, together: tuple[imgui.Key, ...] = ()) -> None:
        """Create it for Alt or Ctrl; the keys of `together` may be pressed at the same time.

        Set `is_keyboard_taken` on systems where a program can grab the keyboard.
        """
        self.is_keyboard_taken: Callable[[], bool] = lambda: False
        self._mod = int(held)
        allowed = (*_KEYS[held], *together)
        self._others = [it for it in _Key if _Key.tab <= it <= _Key.oem102 and it not in allowed]
        self._is_over = False
        self._since_s: float | None = None  # when it was pressed; None if not held, or not alone
        self._is_spoilt = False  # another key was pressed since; lasts until it is released

    def is_over(self, is_hovered: bool) -> bool:
        """Return True while it counts as held over the picture; call this once a frame."""
        io = imgui.get_io()
        if not io.key_mods & self._mod or io.want_text_input:
            self._since_s, self._is_spoilt, self._is_over = None, False, False
            return False
        self._is_spoilt |= any(imgui.is_key_down(key) for key in self._others)
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
        """Return how many seconds the loop may sleep until it counts; None if nothing is due."""
        if self._since_s is None:
            return None
        left_s = self._since_s + HOLD_S - imgui.get_time()
        return max(left_s, 0.01) if left_s > 0 else None
