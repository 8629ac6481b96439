"""Tell which commands the pressed keys mean: translate keys such as "Ctrl+S" into ImGui's."""

import re
from collections.abc import Iterator, Sequence
from functools import cache

from imgui_bundle import imgui

from heatlens.studio.board.command import Command

_K = imgui.Key
CTRL, SHIFT = int(_K.mod_ctrl), int(_K.mod_shift)
KEY_NAMES = {
    "[": _K.left_bracket, "]": _K.right_bracket, "Up": _K.up_arrow, "Down": _K.down_arrow,
    "+": _K.equal, "-": _K.minus, "/": _K.slash, ",": _K.comma, ".": _K.period,
    "Left": _K.left_arrow, "Right": _K.right_arrow, "Space": _K.space, "Home": _K.home,
    "End": _K.end, "Delete": _K.delete, "Tab": _K.tab, "Backspace": _K.backspace, "F1": _K.f1,
    "F10": _K.f10, "F11": _K.f11, "F12": _K.f12,
}  # fmt: skip

# Keys that a text field uses with Ctrl: select all, copy, paste, cut, undo, move by words.
_TEXT_FIELD_KEYS = (
    _K.a, _K.c, _K.v, _K.x, _K.y, _K.z,
    _K.left_arrow, _K.right_arrow, _K.home, _K.end, _K.delete,
)  # fmt: skip


@cache
def chord_of(shortcut: str) -> tuple[imgui.Key | None, int]:
    """Return the key of a shortcut such as "Ctrl+Shift+S", and its CTRL and SHIFT combined.

    The key is None for "".
    """
    if shortcut == "?":
        return _K.slash, SHIFT
    *mods, name = re.split(r"(?<=[a-z])\+", shortcut)
    if not name:
        return None, 0
    key = KEY_NAMES.get(name) or imgui.Key[f"_{name}" if name.isdigit() else name.lower()]
    return key, (CTRL if "Ctrl" in mods else 0) | (SHIFT if "Shift" in mods else 0)


def opens(commands: Sequence[Command], key: imgui.Key, mods: int) -> bool:
    """Return True if keys typed after this one must wait for its effect."""
    meant = [it for it in commands if chord_of(it.key)[0] == key and _fits(it, mods)]
    return not meant or any(
        it.is_alone or chord_of(it.key)[1] & CTRL or it.name.endswith("...") for it in meant
    )


def in_order(pressed: Iterator[Command], typed: Sequence[imgui.Key]) -> list[Command]:
    """Return the commands in the order in which their keys were typed."""
    places = {key: place for place, key in enumerate(typed)}
    return sorted(
        pressed, key=lambda command: places.get(chord_of(command.key)[0] or imgui.Key.none, -1)
    )


def pressed(commands: Sequence[Command]) -> Iterator[Command]:
    """Yield the commands whose keys were pressed in this frame.

    While a text field is edited, only keys that the field does not use itself count.

    No shortcut has Alt or the logo key, so none counts while they are held. ImGui's own
    `imgui.is_key_chord_pressed` is not used, as it ignores the + key without Shift.
    """
    io = imgui.get_io()
    if io.key_alt or io.key_super:
        return
    held = (CTRL if io.key_ctrl else 0) | (SHIFT if io.key_shift else 0)
    for command in commands:
        key, mods = chord_of(command.key)
        if key is None or not _fits(command, held):
            continue
        if io.want_text_input and (not mods & CTRL or key in _TEXT_FIELD_KEYS):
            continue
        if imgui.is_key_pressed(key, command.repeats):
            yield command


def _fits(command: Command, held: int) -> bool:
    """Return True if the held modifiers are those of the command; + may be typed with Shift."""
    key, mods = chord_of(command.key)
    return mods == (held & ~SHIFT if key == _K.equal else held)
