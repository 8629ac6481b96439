"""Everything that can be done, by name: menu, palette, shortcuts and the list of keys read this."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from imgui_bundle import imgui

if TYPE_CHECKING:
    from heatlens.ui.app import App

_K = imgui.Key
_CTRL, _SHIFT = int(_K.mod_ctrl), int(_K.mod_shift)
_KEY_NAMES = {
    _K.left_bracket: "[", _K.right_bracket: "]", _K.up_arrow: "Up", _K.down_arrow: "Down",
    _K.equal: "+", _K.minus: "-", _K.slash: "/", _K.comma: ",", _K.period: ".",
    _K.left_arrow: "Left", _K.right_arrow: "Right", _K.space: "Space", _K.home: "Home",
    _K.end: "End", _K.delete: "Delete", _K.tab: "Tab", _K.f1: "F1",
}  # fmt: skip

# With Ctrl, what text fields do with them: select all, copy, paste, cut, undo, move by words.
_OF_TEXT = (
    _K.a, _K.c, _K.v, _K.x, _K.y, _K.z,
    _K.left_arrow, _K.right_arrow, _K.home, _K.end, _K.delete,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Action:
    """One thing the user can do.

    name      unique, as it stands in the menu
    menu      the menu it stands in
    run       does it
    key       its key, with `mods` (Ctrl, Shift); repeats while held where `repeats`
    is_on     for what is switched: whether it is on
    barred    why it cannot be done with what is open, or nothing
    """

    name: str
    menu: str
    run: Callable[["App"], None]
    key: imgui.Key | None = None
    mods: int = 0
    repeats: bool = False
    is_on: Callable[["App"], bool] | None = None
    barred: Callable[["App"], str] | None = None

    def why_not(self, app: "App") -> str:
        """A sentence that says why it cannot be done now; nothing where it can."""
        return "" if self.barred is None else self.barred(app)

    def do(self, app: "App") -> None:
        """Do it, or say why that cannot be."""
        why = self.why_not(app)
        if why:
            app.say(why)
        else:
            self.run(app)

    @property
    def shortcut(self) -> str:
        """The keys as people read them."""
        if self.key is None:
            return ""
        parts = ["Ctrl"] * bool(self.mods & _CTRL) + ["Shift"] * bool(self.mods & _SHIFT)
        name = _KEY_NAMES.get(self.key) or str(self.key.name).lstrip("_").upper()
        if (name, parts) == ("/", ["Shift"]):
            return "?"
        return "+".join([*parts, name])


def pressed(actions: tuple[Action, ...]) -> Iterator[Action]:
    """The actions whose keys went down in this frame; none while text is typed."""
    io = imgui.get_io()
    held = (_CTRL if io.key_ctrl else 0) | (_SHIFT if io.key_shift else 0)
    for action in actions:
        if action.key is None or not _fits(action, held):
            continue
        if io.want_text_input and (not action.mods & _CTRL or action.key in _OF_TEXT):
            continue
        if imgui.is_key_pressed(action.key, action.repeats):
            yield action


def _fits(action: Action, held: int) -> bool:
    """The modifiers are those of the action; a + may need Shift, or a key of its own."""
    return action.mods == (held & ~_SHIFT if action.key == _K.equal else held)
