"""Build the list of all actions: the named commands of the session, and those of the window."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial

from imgui_bundle import imgui

from heatlens.studio.session.door.named_commands import Command
from heatlens.studio.session.files.file_commands import PURPOSES
from heatlens.studio.session.settings.preferences import Theme
from heatlens.studio.ui.actions import Action, chord_of
from heatlens.studio.ui.menus import Item, items
from heatlens.studio.ui.state import PANELS, UiState

# The items that open a dialog for the name of a file, with the purpose of the dialog.
_DIALOGS = {
    "Open...": "open",
    "Open reference...": "reference",
    "Add a picture behind...": "behind",
    "Open shot...": "shot",
    "Save shot as...": "save shot",
    "Save picture...": "save",
    "Import camera...": "camera",
    "Import grade...": "grade",
    "Import framing lines...": "framing",
    "Pull sheet...": "sheet",
}
# The items that show or hide something, with the flag of `UiState`.
_SWITCHES = {
    "Picture alone": "is_bare",
    "Full screen": "is_full_screen",
    "Second window with the picture": "has_feed",
    "Names of looks in the second window": "has_feed_labels",
}


def actions(commands: Iterable[Command], ui: UiState) -> tuple[Action, ...]:
    """Return all actions, in the order of the menus: `commands` and those of the window."""
    named = {command.name: command for command in (*commands, *_window_commands(ui))}
    return tuple(action for item in items() for action in _actions_of(item, named))


def _actions_of(item: Item, named: dict[str, Command]) -> Iterator[Action]:
    """Yield the action of an item; several for a name with a star."""
    is_one = not item.name.endswith("*")
    names = [item.name] if is_one else [it for it in named if it.startswith(item.name[:-1])]
    for name in names:
        it = named[name]
        yield Action(
            *(name, item.menu, it.run, it.is_on, it.barred, it.label),
            *(chord_of(item.shortcut), item.repeats, item.is_alone),
            item.is_first and name == names[0],
        )


def _window_commands(ui: UiState) -> Iterator[Command]:
    """Yield the actions on the window, and those that first ask for a value in a dialog."""
    for name, purpose in _DIALOGS.items():
        yield Command(name, "File", partial(ui.dialogs.ask, PURPOSES[purpose].key))
    yield Command("Save shot", "File", partial(_save_shot, ui))
    yield Command("Export...", "File", partial(_show_export, ui))
    yield Command("Share with a tablet...", "File", ui.sharing.ask)
    yield Command("Quit", "File", ui.quit)
    yield Command("Rendered frames...", "Play", ui.timeline.open_frames)
    yield Command("Pull focus...", "Animate", ui.open_pull)
    scale, theme = ui.scale, ui.theme
    yield Command("Larger interface", "View", partial(scale.step, 1))
    yield Command("Smaller interface", "View", partial(scale.step, -1))
    yield Command("Interface as large as usual", "View", scale.reset)
    yield Command("Light theme", "View", theme.toggle, lambda: theme.now is Theme.LIGHT)
    yield from _switches(ui)
    yield Command("Reset layout", "Window", ui.reset_layout)
    yield Command("Find a command...", "Help", ui.palette.open)
    yield Command("Go to the menus", "Help", ui.open_menus)
    yield Command("Keys", "Help", partial(ui.toggle, "shows_keys"))


def _switches(ui: UiState) -> Iterator[Command]:
    """Yield the actions that show and hide parts of the window."""
    for name, flag in _SWITCHES.items():
        yield Command(name, "Window", partial(ui.toggle, flag), partial(getattr, ui, flag))
    for name in PANELS:
        is_open: Callable[[], bool] = partial(lambda name: ui.panels[name], name)
        yield Command(name, "Window", partial(ui.toggle_panel, name), is_open)


def _save_shot(ui: UiState) -> None:
    """Save the shot to its file, or ask for a file name if it has none."""
    if not ui.files.documents.save():
        ui.dialogs.ask("save shot")


def _show_export(ui: UiState) -> None:
    """Bring the Export panel to the front."""
    if ui.files.exports.why_not:
        ui.say(ui.files.exports.why_not)
    ui.panels["Export"] = True
    imgui.set_window_focus("Export")
