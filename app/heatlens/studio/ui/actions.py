"""Define an action: one thing the user can do, for menu, palette, shortcuts and list of keys."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from imgui_bundle import imgui

from heatlens.studio.session.door.named_commands import Command

_K = imgui.Key
CTRL, SHIFT = int(_K.mod_ctrl), int(_K.mod_shift)
_MODS = CTRL | SHIFT
_KEY_NAMES = {
    _K.left_bracket: "[", _K.right_bracket: "]", _K.up_arrow: "Up", _K.down_arrow: "Down",
    _K.equal: "+", _K.minus: "-", _K.slash: "/", _K.comma: ",", _K.period: ".",
    _K.left_arrow: "Left", _K.right_arrow: "Right", _K.space: "Space", _K.home: "Home",
    _K.end: "End", _K.delete: "Delete", _K.tab: "Tab", _K.backspace: "Backspace", _K.f1: "F1",
    _K.f10: "F10", _K.f11: "F11", _K.f12: "F12",
}  # fmt: skip

# Keys that a text field uses with Ctrl: select all, copy, paste, cut, undo, move by words.
_TEXT_FIELD_KEYS = (
    _K.a, _K.c, _K.v, _K.x, _K.y, _K.z,
    _K.left_arrow, _K.right_arrow, _K.home, _K.end, _K.delete,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Action(Command):
    """A command in the window: in a menu, in the palette, and perhaps on a key.

    chord     key combined with CTRL and SHIFT as ImGui combines them; 0 for no shortcut
    repeats   whether it runs repeatedly while the key is held
    is_first  it begins a group of its menu, with a line above it
    is_alone  keys typed after it wait, since it may open something or move the keyboard focus;
              also true with Ctrl, and for names that end in "..."
    """

    chord: int = 0
    repeats: bool = False
    is_alone: bool = False
    is_first: bool = False

    @cached_property
    def key(self) -> imgui.Key | None:
        """The key without Ctrl and Shift; None if there is no shortcut."""
        return imgui.Key(self.chord & ~_MODS) if self.chord else None

    @property
    def mods(self) -> int:
        """The modifiers of the shortcut, a combination of CTRL and SHIFT."""
        return self.chord & _MODS

    @property
    def shortcut(self) -> str:
        """The shortcut as text, for example "Ctrl+Shift+S"; "" if there is none."""
        if self.key is None:
            return ""
        parts = ["Ctrl"] * bool(self.mods & CTRL) + ["Shift"] * bool(self.mods & SHIFT)
        name = _KEY_NAMES.get(self.key) or str(self.key.name).lstrip("_").upper()
        if (name, parts) == ("/", ["Shift"]):
            return "?"
        return "+".join([*parts, name])


def chord_of(shortcut: str) -> int:
    """Return the key of a shortcut as it is written in menus, such as "Ctrl+Shift+S"; 0 for ""."""
    if shortcut == "?":
        return int(_K.slash) | SHIFT
    *mods, name = re.split(r"(?<=[a-z])\+", shortcut)
    if not name:
        return 0
    named = {shown: key for key, shown in _KEY_NAMES.items()}
    key = named.get(name) or imgui.Key[f"_{name}" if name.isdigit() else name.lower()]
    return int(key) | (CTRL if "Ctrl" in mods else 0) | (SHIFT if "Shift" in mods else 0)


def opens(actions: tuple[Action, ...], key: imgui.Key, mods: int) -> bool:
    """Return True if keys typed after this one must wait for its effect."""
    meant = [action for action in actions if action.key == key and _fits(action, mods)]
    return not meant or any(
        action.is_alone or action.mods & CTRL or action.name.endswith("...") for action in meant
    )


def in_order(pressed: Iterator[Action], typed: Sequence[imgui.Key]) -> list[Action]:
    """Return the actions in the order in which their keys were typed."""
    places = {key: place for place, key in enumerate(typed)}
    return sorted(pressed, key=lambda action: places.get(action.key or imgui.Key.none, -1))


def pressed(actions: tuple[Action, ...]) -> Iterator[Action]:
    """Yield the actions whose shortcuts were pressed in this frame.

    While a text field is edited, only shortcuts that the field does not use itself count.

    No shortcut has Alt or the logo key, so none counts while they are held. ImGui's own
    `is_key_chord_pressed` is not used, as it ignores the + key without Shift.
    """
    io = imgui.get_io()
    if io.key_alt or io.key_super:
        return
    held = (CTRL if io.key_ctrl else 0) | (SHIFT if io.key_shift else 0)
    for action in actions:
        if action.key is None or not _fits(action, held):
            continue
        if io.want_text_input and (not action.mods & CTRL or action.key in _TEXT_FIELD_KEYS):
            continue
        if imgui.is_key_pressed(action.key, action.repeats):
            yield action


def _fits(action: Action, held: int) -> bool:
    """Return True if the held modifiers are those of the action; + may be typed with Shift."""
    return action.mods == (held & ~SHIFT if action.key == _K.equal else held)
