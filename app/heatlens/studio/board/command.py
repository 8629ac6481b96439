"""Define a command: one thing that the user can do without further values."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from heatlens.core.base.errors import InputError

# The menus in their order, each with its groups; a line is drawn between two groups.
MENUS: dict[str, tuple[str, ...]] = {
    "File": ("open", "shot", "write", "imports", "share", "quit"),
    "Edit": ("history",),
    "Lens": ("turn", "focus", "looks", "numbered looks", "blur"),
    "Play": ("play", "go to", "range", "reel", "frames"),
    "Animate": ("key", "marks", "auto key", "moves", "interpolation", "rows"),
    "View": (
        *("blur", "zoom", "pixels", "exposure", "overlays", "mattes", "guides"),
        *("grade", "interface", "size", "camera"),
    ),
    "Compare": ("with", "gain", "b", "method"),
    "Window": ("picture", "panels", "layout"),
    "Help": ("help",),
}
# The groups that are a submenu of their menu, with its title.
SUBMENUS: dict[tuple[str, str], str] = {
    ("File", "imports"): "Import",
    ("Lens", "turn"): "Turn by a step",
    ("Lens", "numbered looks"): "Take look",
    ("Play", "go to"): "Go to",
    ("Play", "range"): "In and out",
    ("Play", "reel"): "Reel",
    ("Animate", "moves"): "Selected keys",
    ("Animate", "interpolation"): "Interpolation",
    ("View", "zoom"): "Zoom",
    ("View", "exposure"): "Exposure",
    ("View", "overlays"): "Overlays",
    ("View", "mattes"): "Frame mask",
    ("View", "guides"): "Guide lines",
    ("View", "size"): "Interface size",
    ("Compare", "method"): "Compare with",
    ("Window", "panels"): "Panels",
}


@dataclass(frozen=True, eq=False)
class Command:
    """One thing that the user can do: in menus, palette, on a key, and on the browser's page.

    name       unique name, by which other programs call it too
    run        the function that does it
    key        its key as menus show it, such as "Ctrl+Shift+Z"; "" for none
    menu       title of its menu, one of `MENUS`
    group      its group in that menu, which may be one of `SUBMENUS`
    before     the name of the command in front of which it stands; "" for its group's end
    is_on      returns the state of a switch; None for commands that switch nothing
    barred     returns the reason why the command is unavailable now, or ""
    label      returns the text that a menu shows instead of the name
    repeats    it runs repeatedly while the key is held
    is_alone   keys typed after it wait, since it may move the keyboard focus
    is_remote  pages in a browser may give it; it must not open, write or delete a file
    sheet      heading of its button on the browser's page; "" for its key alone, None for neither
    synonyms   other words by which the palette finds it
    """

    name: str
    run: Callable[[], object]
    key: str = ""
    menu: str = ""
    group: str = ""
    before: str = ""
    is_on: Callable[[], bool] | None = None
    barred: Callable[[], str] | None = None
    label: Callable[[], str] | None = None
    repeats: bool = False
    is_alone: bool = False
    is_remote: bool = False
    sheet: str | None = None
    synonyms: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """The text in the menu: `label()` where the command has one, else the name."""
        return self.name if self.label is None else self.label()

    @property
    def submenu(self) -> str:
        """The title of its submenu; "" if it stands in the menu itself."""
        return SUBMENUS.get((self.menu, self.group), "")

    @property
    def turns_lens(self) -> bool:
        """True if it changes the shot or the playhead, which one hand does at a time."""
        return self.menu not in ("View", "Compare")

    def why_not(self) -> str:
        """Return the reason, a sentence, why the command is unavailable now; else ""."""
        return "" if self.barred is None else self.barred()

    def do(self) -> None:
        """Run the command. Raise InputError with the reason if it is unavailable."""
        why = self.why_not()
        if why:
            raise InputError(why)
        self.run()


remote_command = partial(Command, is_remote=True)  # pages in a browser may give it
page_command = partial(Command, is_remote=True, sheet="")  # its key works on these pages, too


def in_group(menu: str, group: str, *commands: Command) -> tuple[Command, ...]:
    """Return the commands in a group of a menu."""
    return tuple(replace(command, menu=menu, group=group) for command in commands)


def in_menu_order(commands: Iterable[Command]) -> tuple[Command, ...]:
    """Return the commands by menu and group; those with `before` stand where they ask to stand."""
    all_commands = tuple(commands)
    places = [(menu, group) for menu, groups in MENUS.items() for group in groups]
    ordered = sorted(
        (command for command in all_commands if not command.before),
        key=lambda command: places.index((command.menu, command.group)),
    )
    for command in all_commands:
        if command.before:
            names = [other.name for other in ordered]
            ordered.insert(names.index(command.before), command)
    return tuple(ordered)


def keys_by_menu(commands: Iterable[Command]) -> dict[str, tuple[tuple[str, str], ...]]:
    """Return by menu the keys of its commands and their names, in the order of the commands."""
    keyed = tuple(command for command in commands if command.key)
    return {
        menu: tuple((it.key, it.name) for it in keyed if it.menu == menu)
        for menu in dict.fromkeys(command.menu for command in keyed)
    }


@dataclass(frozen=True)
class CommandState:
    """A named command: whether it is on (None: it is not a switch), and why it is barred, or ""."""

    name: str
    label: str
    is_on: bool | None
    barred: str


class CommandStates:
    """The states of commands; that of a command that is as before is the same object."""

    def __init__(self, commands: Sequence[Command]) -> None:
        """Take the commands whose states are asked for."""
        self._states = [CommandState(it.name, it.name, None, "") for it in commands]
        self._changing = [
            (index, command)
            for index, command in enumerate(commands)
            if command.is_on or command.barred or command.label
        ]

    def present(self) -> tuple[CommandState, ...]:
        """Return the states now, in the order of the commands."""
        for index, command in self._changing:
            is_on = None if command.is_on is None else bool(command.is_on())
            state = CommandState(command.name, command.shown, is_on, command.why_not())
            if state != self._states[index]:
                self._states[index] = state
        return tuple(self._states)
