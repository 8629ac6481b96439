"""List the commands on the window itself, and those that first ask for a value in a dialog."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from imgui_bundle import imgui

from heatlens.studio.board.command import Command, in_group
from heatlens.studio.settings.file_purposes import PURPOSES
from heatlens.studio.settings.preferences import Theme
from heatlens.studio.ui.panels.rendering_panel import SPEED
from heatlens.studio.ui.seek import show_setting
from heatlens.studio.ui.state import PANELS, UiState

_FIRST_TO_OPEN = "Open the demo"  # the command of the session that the dialogs stand in front of


def window_commands(ui: UiState) -> tuple[Command, ...]:
    """Return the commands on the window."""
    return (
        *(*_file(ui), *_other_shots(ui), *_boxes(ui)),
        *(*_interface(ui), *_window(ui), *_help(ui)),
    )


def _dialog(ui: UiState, name: str, purpose: str, key: str = "", before: str = "") -> Command:
    """Return the command that asks for the name of a file."""
    return Command(name, partial(ui.dialogs.ask, PURPOSES[purpose].key), key, before=before)


def _file(ui: UiState) -> Iterator[Command]:
    """Yield the commands that open file dialogs, and those on sharing and quitting."""
    dialog = partial(_dialog, ui)
    yield from in_group(
        *("File", "open"),
        dialog("Open...", "open", "Ctrl+O", _FIRST_TO_OPEN),
        replace(
            Command("New reel", partial(_new_reel, ui), before=_FIRST_TO_OPEN),
            synonyms=("cut", "sequence of shots", "playlist"),
        ),
        dialog("Open reference...", "reference", "Ctrl+Shift+O", _FIRST_TO_OPEN),
        replace(
            dialog("Add clean plate...", "behind", before=_FIRST_TO_OPEN),
            synonyms=("picture behind", "background"),
        ),
    )
    yield from in_group(
        *("File", "shot"),
        dialog("Open shot...", "shot", before="Reload"),
        Command("Save shot", partial(_save_shot, ui), "Ctrl+S", before="Reload"),
        dialog("Save shot as...", "save shot", "Ctrl+Shift+S", "Reload"),
    )
    yield from in_group(
        *("File", "write"),
        dialog("Save picture...", "save", "Ctrl+Shift+E", "Copy picture"),
        Command("Export...", partial(_show_export, ui), "Ctrl+E", before="Copy picture"),
        dialog("Pull sheet...", "sheet", before="Copy picture"),
    )
    yield from in_group(
        *("File", "imports"),
        dialog("Import camera...", "camera"),
        replace(dialog("Import grade...", "grade"), synonyms=("LUT", "CDL")),
        dialog("Import framing lines...", "framing"),
    )
    yield from in_group("File", "share", Command("Share with a tablet...", ui.sharing.share))
    yield from in_group("File", "quit", Command("Quit", ui.quit, "Ctrl+Q"))


def _other_shots(ui: UiState) -> Iterator[Command]:
    """Yield the commands that compare with another shot."""
    versions = Command("Compare with a version...", ui.files.documents.versions.offer)
    yield from in_group(
        *("Compare", "b"),
        _dialog(ui, "Compare with a shot...", "compare shot"),
        replace(versions, synonyms=("autosave", "history", "yesterday")),
    )


def _boxes(ui: UiState) -> Iterator[Command]:
    """Yield the commands that open a box over the window."""
    yield from in_group(
        "Play", "frames", Command("Rendered frames...", ui.timeline.open_frames_popup)
    )
    yield from in_group(
        "Play", "reel", Command("Save reel...", partial(save_reel, ui), before="Leave the reel")
    )
    pull = Command("Pull focus...", ui.open_pull, "Shift+M", before="Reverse the pull")
    yield from in_group("Animate", "marks", replace(pull, synonyms=("rack focus",)))


def _interface(ui: UiState) -> Iterator[Command]:
    """Yield the commands on the size and colors of the interface."""
    scale, theme = ui.scale, ui.theme
    yield from in_group(
        *("View", "size"),
        Command("Larger interface", partial(scale.step, 1), "Ctrl++"),
        Command("Smaller interface", partial(scale.step, -1), "Ctrl+-"),
        Command("Reset interface size", scale.reset),
    )
    light = Command("Light theme", theme.toggle, is_on=lambda: theme.current is Theme.LIGHT)
    yield from in_group("View", "interface", light)


def _window(ui: UiState) -> Iterator[Command]:
    """Yield the commands that show and hide parts of the window."""
    alone = partial(_switch, ui, is_alone=True)
    yield from in_group(
        *("Window", "picture"),
        alone("Picture alone", "is_bare", "Tab"),
        alone("Full screen", "is_full_screen", "F11"),
        alone("Second window with the picture", "has_feed", "F12"),
        _switch(ui, "Names of looks in the second window", "has_feed_labels"),
    )
    is_open: Callable[[str], bool] = lambda name: ui.panels[name]  # noqa: E731
    yield from in_group(
        *("Window", "panels"),
        *(
            Command(name, partial(ui.toggle_panel, name), is_on=partial(is_open, name))
            for name in PANELS
        ),
    )
    yield from in_group(
        *("Window", "layout"),
        Command("Speed", partial(_show_speed, ui), "T", synonyms=("frames per second", "GPU")),
        Command("Reset layout", ui.reset_layout),
    )


def _switch(ui: UiState, name: str, flag: str, key: str = "", is_alone: bool = False) -> Command:
    """Return the command that switches a flag of `UiState`."""
    is_on = partial(getattr, ui, flag)
    return Command(name, partial(ui.toggle, flag), key, is_on=is_on, is_alone=is_alone)


def _help(ui: UiState) -> Iterator[Command]:
    """Yield the commands that find other commands."""
    yield from in_group(
        *("Help", "help"),
        Command("Find a command...", ui.palette.open, "Ctrl+Shift+P"),
        Command("Search the manual...", ui.palette.open, "?"),
        Command("Go to the menus", ui.open_menus, "F10", is_alone=True),
        Command("Keys", partial(ui.toggle, "shows_keys"), "F1", is_alone=True),
    )


def _save_shot(ui: UiState) -> None:
    """Save the shot to its file, or ask for a file name if it has none."""
    if not ui.files.documents.save():
        ui.dialogs.ask("save shot")


def _new_reel(ui: UiState) -> None:
    """Begin a reel with the open shot; if nothing is open, ask for its shots."""
    if not ui.files.commands.reel_editing.begin():
        ui.dialogs.ask("reel shot")


def save_reel(ui: UiState) -> None:
    """Save the reel to its file, or ask for a file name if it has none."""
    if not ui.files.commands.reel_editing.save():
        ui.dialogs.ask("save reel")


def _show_speed(ui: UiState) -> None:
    """Show how fast pictures are made, in the last fold of the Lens panel."""
    ui.panels["Lens"] = True
    show_setting("Lens", SPEED)


def _show_export(ui: UiState) -> None:
    """Bring the Export panel to the front."""
    if ui.files.exports.why_not:
        ui.messages.notify(ui.files.exports.why_not)
    ui.panels["Export"] = True
    imgui.set_window_focus("Export")
