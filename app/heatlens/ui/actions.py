"""Everything that can be done, by name: menu, palette, shortcuts and the list of keys read this."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from imgui_bundle import imgui

from heatlens.session.messages import Problem

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

# With Ctrl, what text fields do with them: select all, copy, paste, cut, undo, move by words.
_OF_TEXT = (
    _K.a, _K.c, _K.v, _K.x, _K.y, _K.z,
    _K.left_arrow, _K.right_arrow, _K.home, _K.end, _K.delete,
)  # fmt: skip

# With Alt, what window managers do with them.
_OF_WINDOWS = (_K.tab, _K.space, _K.escape, _K.f4, _K.f10, _K.f11, _K.f12)


@dataclass(frozen=True, eq=False)
class Action:
    """One thing the user can do.

    name      unique, as it stands in the menu
    menu      the menu it stands in
    run       does it
    chord     its key, joined with CTRL and SHIFT as ImGui joins them; 0: none
    repeats   it is done again and again while the key is held
    is_on     for what is switched: whether it is on
    barred    why it cannot be done with what is open, or nothing
    label     what the menu shows in the place of the name
    """

    name: str
    menu: str
    run: Callable[[], object]
    chord: int = 0
    repeats: bool = False
    is_on: Callable[[], bool] | None = None
    barred: Callable[[], str] | None = None
    label: Callable[[], str] | None = None

    @property
    def shown(self) -> str:
        """What the menu shows: the name, or more than that where it depends on what is open."""
        return self.name if self.label is None else self.label()

    def why_not(self) -> str:
        """Return a sentence that says why it cannot be done now; "" where it can."""
        return "" if self.barred is None else self.barred()

    def do(self, say: Callable[[str], None]) -> None:
        """Do it, or say why that cannot be."""
        why = self.why_not()
        if why:
            say(Problem(why))
        else:
            self.run()

    @property
    def key(self) -> imgui.Key | None:
        """Its key without Ctrl and Shift."""
        return imgui.Key(self.chord & ~_MODS) if self.chord else None

    @property
    def mods(self) -> int:
        """What is held with its key."""
        return self.chord & _MODS

    @property
    def shortcut(self) -> str:
        """The keys as people read them."""
        if self.key is None:
            return ""
        parts = ["Ctrl"] * bool(self.mods & CTRL) + ["Shift"] * bool(self.mods & SHIFT)
        name = _KEY_NAMES.get(self.key) or str(self.key.name).lstrip("_").upper()
        if (name, parts) == ("/", ["Shift"]):
            return "?"
        return "+".join([*parts, name])


def pressed(actions: tuple[Action, ...]) -> Iterator[Action]:
    """Return the actions whose keys went down in this frame; none while text is typed.

    ImGui's own `is_key_chord_pressed` would leave every key dead while Alt is held, which shows
    the picture without depth of field, and the + without Shift.
    """
    io = imgui.get_io()
    held = (CTRL if io.key_ctrl else 0) | (SHIFT if io.key_shift else 0)
    for action in actions:
        if action.key is None or not _fits(action, held):
            continue
        if io.key_alt and action.key in _OF_WINDOWS:
            continue
        if io.want_text_input and (not action.mods & CTRL or action.key in _OF_TEXT):
            continue
        if imgui.is_key_pressed(action.key, action.repeats):
            yield action


def _fits(action: Action, held: int) -> bool:
    """Return True where what is held is what the action asks for; a + may need Shift."""
    return action.mods == (held & ~SHIFT if action.key == _K.equal else held)
