"""Detect that Alt or Ctrl alone is held over the picture, where the key has its own meaning.

Window managers use Alt+Tab and Alt+F4, and Alt opens menus. A held key therefore counts only after
a moment, with no other key down, the pointer over the picture, and the keyboard not grabbed.
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

    def __init__(
        self,
        modifier: imgui.Key,
        allowed_keys: tuple[imgui.Key, ...] = (),
        is_keyboard_taken: Callable[[], bool] = lambda: False,
    ) -> None:
        """Watch Alt or Ctrl; the keys of `allowed_keys` may be pressed at the same time.

        `is_keyboard_taken` returns True while another program has grabbed the keyboard.
        """
        self._is_keyboard_taken = is_keyboard_taken
        self._modifier = int(modifier)
        allowed = (*_KEYS[modifier], *allowed_keys)
        self._other_keys = [
            key for key in _Key if _Key.tab <= key <= _Key.oem102 and key not in allowed
        ]
        self._counts = False
        self._since_s: float | None = None  # when it was pressed; None if not held, or not alone
        self._has_other_key = False  # another key was pressed since; lasts until it is released

    def update(self, is_hovered: bool) -> bool:
        """Return True while the key is held alone over the picture; call this once a frame."""
        io = imgui.get_io()
        if not io.key_mods & self._modifier or io.want_text_input:
            self._since_s, self._has_other_key, self._counts = None, False, False
            return False
        self._has_other_key |= any(imgui.is_key_down(key) for key in self._other_keys)
        if self._has_other_key or not is_hovered:
            self._since_s, self._counts = None, False
            return False
        if self._since_s is None:
            self._since_s = imgui.get_time()
        if not self._counts and imgui.get_time() - self._since_s >= HOLD_S:
            # For example by the window list of Alt+Tab.
            self._has_other_key = self._is_keyboard_taken()
            self._counts = not self._has_other_key
        return self._counts

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the held key counts; None if nothing is due."""
        if self._since_s is None:
            return None
        remaining_s = self._since_s + HOLD_S - imgui.get_time()
        return max(remaining_s, 0.01) if remaining_s > 0 else None
