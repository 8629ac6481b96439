"""Arrange the docked panels, restore a saved arrangement, and draw the menu bar."""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.view.ui_sizes import scaled_layout
from heatlens.studio.board.command import MENUS, Command
from heatlens.studio.board.controls import FileControl
from heatlens.studio.ui import rects, texts, topmost
from heatlens.studio.ui.state import UiState
from heatlens.studio.ui.timeline.view import TimelineView

PICTURE = "Picture"
_TITLES = tuple(MENUS)
PICTURE_ALONE = "Picture alone"
_PANEL_EM = 24.8  # width of the column of panels, with six tabs side by side
_MAX_COLUMN_SHARE, _MAX_TIMELINE_SHARE = 0.45, 0.54  # largest shares of the window
_TIMELINE_EM, _CURVE_EM = 16.5, 25.2  # height of the timeline under the picture; with a curve
_STRIP_EM, _MAX_STRIP_SHARE = 5.6, 0.13  # height of the strip of a reel; with its largest share
_MAX_CURVE_SHARE = 0.5  # largest share of the window that the timeline grows to for the curve
_OTHER_PANELS = (
    "This version has other panels, so they begin in their first places: arrange them again."
)
_LEFT, _RIGHT = imgui.Key.left_arrow, imgui.Key.right_arrow
_RECENT_EM, _FOLDER_LETTERS = 42.0, 44  # width of a recent file, and length of its folder's text


def menu_bar(files: FileControl, ui: UiState, commands: Sequence[Command]) -> Command | None:
    """Draw the menus; return the command that was chosen in this frame, or None."""
    picked_action = None
    if not imgui.begin_main_menu_bar():
        return None
    if ui.menu_to_open:
        imgui.open_popup(ui.menu_to_open)
        ui.menu_to_open = ""
    for menu in _TITLES:
        if imgui.begin_menu(menu):
            ui.menu_to_open = _neighbor_menu(menu)
            in_menu = [command for command in commands if command.menu == menu]
            picked_action = _menu_content(files, ui, in_menu) or picked_action
            imgui.end_menu()
        rects.note(f"menu {menu}")
    ui.sharing.draw_in_menu_bar()
    imgui.end_main_menu_bar()
    return picked_action


def _menu_content(files: FileControl, ui: UiState, commands: Sequence[Command]) -> Command | None:
    """Draw the groups of a menu and its submenus; return the command that was chosen, or None."""
    picked_action: Command | None = None
    last_submenu: str | None = None
    for (_, submenu), group in groupby(commands, key=lambda it: (it.group, it.submenu)):
        if last_submenu is not None and not (last_submenu and submenu):
            imgui.separator()
        last_submenu = submenu
        for command in () if submenu else group:
            picked_action = command if _menu_item(command) else picked_action
            if command.name == "Open...":
                picked_action = _open_recent(files, ui) or picked_action
        if submenu:
            picked_action = _submenu(ui, submenu, tuple(group)) or picked_action
    return picked_action


def _submenu(ui: UiState, title: str, commands: Sequence[Command]) -> Command | None:
    """Draw a submenu; return the command that was chosen in it, or None."""
    picked_action = None
    is_open = imgui.begin_menu(title)
    rects.note(f"menu {title}")
    if is_open:
        ui.menu_to_open = ""  # the arrow keys lead into and out of this one
        for command in commands:
            picked_action = command if _menu_item(command) else picked_action
        imgui.end_menu()
    return picked_action


def _menu_item(command: Command) -> bool:
    """Draw an item of a menu; return True if it was clicked."""
    is_on = bool(command.is_on is not None and command.is_on())
    reason = command.why_not()
    label = f"{printable(command.shown)}###{command.name}"
    is_clicked, _ = imgui.menu_item(label, texts.named_keys(command.key), is_on, not reason)
    rects.note(f"item {command.name}")
    texts.disabled_tip(reason)
    return bool(is_clicked)


def _neighbor_menu(menu: str) -> str:
    """Return the menu that an arrow key opens next to `menu`, which is being drawn; else ""."""
    right, left = imgui.is_key_pressed(_RIGHT), imgui.is_key_pressed(_LEFT)
    if not (right or left) or not topmost.last_popup_depth():
        return ""
    return _TITLES[(_TITLES.index(menu) + (1 if right else -1)) % len(_TITLES)]


def _open_recent(files: FileControl, ui: UiState) -> Command | None:
    """Draw the submenu of recent files that still exist; return a command that opens the chosen."""
    if imgui.is_window_appearing():
        files.recent.check()
    recent_names, picked_action = files.recent.existing_names, None
    is_open = imgui.begin_menu("Open recent", bool(recent_names))
    rects.note("menu Open recent")
    if is_open:
        ui.menu_to_open = ""  # the arrow keys lead into and out of this one
        for text in recent_names:
            if _recent_item(Path(text)):
                picked_action = Command(text, partial(files.commands.open, text))
        imgui.end_menu()
    return picked_action


def _recent_item(path: Path) -> bool:
    """Draw a recent file; return True if clicked.

    The text is drawn beside an item without label: ImGui would cut a label at the ## of a sequence.
    """
    em, corner = imgui.get_font_size(), imgui.get_cursor_pos_x()
    width = ImVec2(_RECENT_EM * em, 0)
    label = f"##{printable(str(path))}"
    is_clicked, _ = imgui.selectable(label, False, imgui.SelectableFlags_.none, width)
    rects.note(f"recent {path.name}")
    imgui.same_line(corner)
    imgui.text(printable(path.name))
    imgui.same_line()
    imgui.set_cursor_pos_x(max(corner + 0.4 * _RECENT_EM * em, imgui.get_cursor_pos_x()))
    imgui.text_disabled(printable(shortened(path.parent)))
    return bool(is_clicked)


def shortened(folder: Path) -> str:
    """Return the path, cut at its beginning if it is long, since its end identifies it best."""
    text = str(folder)
    return text if len(text) <= _FOLDER_LETTERS else f"...{text[3 - _FOLDER_LETTERS :]}"


def restore_layout(ui: UiState, layout: str, em: float = 0.0) -> None:
    """Restore the saved panel arrangement `layout`; call before the first frame.

    `em` is the font size in pixels when it was saved; 0 for the present font size.
    """
    if lists_all_panels(layout, ui.panels):
        factor = ui.scale.em / em if em else 1.0
        imgui.load_ini_settings_from_memory(scaled_layout(layout, factor))
        ui.wants_layout = False
    elif layout:
        ui.messages.notify(_OTHER_PANELS)


def lists_all_panels(layout: str, panels: Iterable[str]) -> bool:
    """Return True if a layout has every panel; a missing panel would cover the picture."""
    return all(f"[Window][{name}]" in layout.splitlines() for name in (PICTURE, *panels))


def dock_panels(is_new: bool, size: ImVec2, is_hidden: bool = False) -> None:
    """Draw the space that panels dock in; `is_new` resets their arrangement.

    `is_hidden` draws nothing and only keeps the arrangement, while the picture is shown alone.
    """
    dock = imgui.get_id("heatlens dock")
    if is_new:
        _arrange(dock, size)
    flags = imgui.DockNodeFlags_.keep_alive_only if is_hidden else imgui.DockNodeFlags_.none
    imgui.dock_space(dock, size, flags)


def _arrange(dock: int, size: ImVec2) -> None:
    """Dock all panels in their original places."""
    docking = imgui.internal
    docking.dock_builder_remove_node(dock)
    docking.dock_builder_add_node(dock, docking.DockNodeFlagsPrivate_.dock_space)
    docking.dock_builder_set_node_size(dock, size)
    column_share = min(_MAX_COLUMN_SHARE, _PANEL_EM * imgui.get_font_size() / max(size.x, 1.0))
    _, right, centre = docking.dock_builder_split_node_py(dock, imgui.Dir.right, column_share)
    timeline_share = min(
        _MAX_TIMELINE_SHARE, _TIMELINE_EM * imgui.get_font_size() / max(size.y, 1.0)
    )
    _, below, centre = docking.dock_builder_split_node_py(centre, imgui.Dir.down, timeline_share)
    strip_share = min(_MAX_STRIP_SHARE, _STRIP_EM * imgui.get_font_size() / max(size.y, 1.0))
    _, strip, centre = docking.dock_builder_split_node_py(
        centre, imgui.Dir.down, strip_share / (1.0 - timeline_share)
    )
    docking.dock_builder_dock_window(PICTURE, centre)
    docking.dock_builder_dock_window("Timeline", below)
    docking.dock_builder_dock_window("Reel strip", strip)
    for name in ("Lens", "Marks", "Looks", "Display", "Export", "Source"):
        docking.dock_builder_dock_window(name, right)
    for node in (centre, strip):
        _set_flag(node, docking.DockNodeFlagsPrivate_.no_tab_bar)
    for node in (right, below):  # each tab has its own close button
        _set_flag(node, docking.DockNodeFlagsPrivate_.no_close_button)
    docking.dock_builder_finish(dock)


def grow_for_curve(view: TimelineView, shows_curve: bool, window_height: float) -> None:
    """Make the timeline higher while it shows a curve, and restore its height afterwards."""
    window = imgui.internal.find_window_by_name("Timeline")
    node = None if window is None else window.dock_node
    if node is None or shows_curve == (view.height_before is not None):
        return
    height = min(_CURVE_EM * imgui.get_font_size(), _MAX_CURVE_SHARE * window_height)
    height = max(height, node.size.y) if view.height_before is None else view.height_before
    view.height_before = node.size.y if view.height_before is None else None
    imgui.internal.dock_builder_set_node_size(node.id_, ImVec2(node.size.x, height))


def shrink_large_panels(panels: Iterable[str]) -> None:
    """Shrink panels that take more than their share of the window.

    Call this after the panels are drawn, when the font has become larger and the panels with it.
    """
    picture_nodes = {node.id_ for node in _nodes_of(PICTURE)}
    for name in panels:
        for node in _nodes_of(name):
            parent = node.parent_node
            if parent is not None and parent.id_ in picture_nodes and node.id_ not in picture_nodes:
                _limit_node(node, parent)


def _nodes_of(name: str) -> Iterator[imgui.internal.DockNode]:
    """Return the dock node of a window, its parent node, and so on."""
    window = imgui.internal.find_window_by_name(name)
    node = None if window is None else window.dock_node
    while node is not None:
        yield node
        node = node.parent_node


def _limit_node(node: imgui.internal.DockNode, parent: imgui.internal.DockNode) -> None:
    """Shrink a dock node to its largest share of its parent."""
    width, height = node.size.x, node.size.y
    if parent.split_axis == imgui.internal.Axis.x:
        width = min(width, _MAX_COLUMN_SHARE * parent.size.x)
    else:
        height = min(height, _MAX_TIMELINE_SHARE * parent.size.y)
    if (width, height) != (node.size.x, node.size.y):
        imgui.internal.dock_builder_set_node_size(node.id_, ImVec2(width, height))


def _set_flag(node_id: int, flag: imgui.internal.DockNodeFlagsPrivate_) -> None:
    """Set a flag of a dock node, if it exists."""
    node = imgui.internal.dock_builder_get_node(node_id)
    if node is not None:
        node.local_flags |= flag
