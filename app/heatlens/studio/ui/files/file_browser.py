"""Choose a file inside the window; a sequence of frames is one entry.

The dialogs of operating systems list a thousand frames as a thousand files, and need a desktop.
"""

import time
from collections.abc import Callable
from pathlib import Path

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Problem
from heatlens.core.base.outside_text import printable
from heatlens.media.sequence.folder_list import Entry
from heatlens.media.sequence.folder_walk import ChosenFile, FolderWalk
from heatlens.studio.board.controls import FileControl
from heatlens.studio.settings.file_purposes import PURPOSES
from heatlens.studio.ui import rects, texts, theme, topmost, widgets

_SIZE_EM = (56.0, 34.0)
_FRAMES_EM, _WRITTEN_EM, _BUTTON_EM = 13.0, 10.0, 6.5
_Key = imgui.Key


class FileDialogs:
    """A dialog over the window that asks for a file, and applies the choice."""

    def __init__(
        self, files: FileControl, notify: Callable[[str], None], wake: Callable[[], None]
    ) -> None:
        self._files, self._notify, self._wake = files.commands, notify, wake
        self.walk: FolderWalk | None = None
        self._is_new = False

    @property
    def is_open(self) -> bool:
        """True if the dialog is open or opens in the next frame."""
        return self.walk is not None

    def ask(self, key: str) -> None:
        """Ask for a file in the next frame; `key` is a key of PURPOSES."""
        if self._files.may_choose(key):
            folder, name = self._files.first_folder(key), self._files.first_name(key)
            self.walk = FolderWalk(PURPOSES[key], folder, name, self._wake)
            self._is_new = True

    def draw(self) -> None:
        """Draw the dialog if it is open, and apply the user's choice."""
        chosen_file = None if self.walk is None else self._draw_dialog(self.walk)
        if chosen_file is not None:
            self._files.apply_choice(chosen_file)

    def _draw_dialog(self, walk: FolderWalk) -> ChosenFile | None:
        """Draw the dialog, and close it at the end; return a file that was just chosen, or None."""
        title = f"{walk.purpose.title}###file browser"
        if self._is_new:
            imgui.open_popup(title)
        _set_size_and_position()
        flags = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_collapse
        is_visible, is_kept_open = topmost.begin_modal(title, can_close=True, flags=flags)
        chosen_file = None
        if is_visible:
            topmost.disable_key_navigation()
            chosen_file = self._draw_content(walk)
            is_done = chosen_file is not None and not walk.purpose.stays
            is_kept_open = is_kept_open and not is_done and self.walk is not None
            if not is_kept_open:
                imgui.close_current_popup()
            imgui.end_popup()
        if not is_visible or not is_kept_open:
            self.walk = None
        self._is_new = False
        return chosen_file

    def _draw_content(self, walk: FolderWalk) -> ChosenFile | None:
        """Draw path, list and footer; return the file typed, picked or confirmed, or None."""
        try:
            typed_file = walk.poll()
        except HeatlensError as error:
            typed_file = None
            self._notify(Problem(error))
        is_typing = imgui.get_io().want_text_input
        self._draw_path_row(walk)
        picked_file = _draw_list(walk)
        if not is_typing and not self._is_new:
            picked_file = _handle_keys(walk) or picked_file
        if topmost.is_escaped() and not self._is_new:
            self.walk = None
        return typed_file or picked_file or self._draw_footer(walk)

    def _draw_path_row(self, walk: FolderWalk) -> None:
        """Draw the buttons for other folders and the field for the path."""
        for name, target in (("Up", ".."), ("Home", "~")):
            if widgets.button(name, f"browser {name}"):
                walk.go(target)
            imgui.same_line()
        imgui.set_next_item_width(-1)
        is_entered, walk.typed_path = imgui.input_text(
            "##path",
            walk.typed_path,
            imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.elide_left,
        )
        rects.note("browser path")
        if is_entered:
            walk.go(walk.typed_path)

    def _draw_footer(self, walk: FolderWalk) -> ChosenFile | None:
        """Draw a field for the name, a text and the buttons; return the file chosen, or None."""
        if walk.existing_file is not None:
            return _overwrite_question(walk, walk.existing_file)
        is_entered = walk.purpose.is_save and self._draw_name_field(walk)
        texts.colored_text(_note(walk), theme.colors.bad if walk.problem else theme.colors.dim)
        if not walk.purpose.is_save:
            _single_files(walk)
        _align_right(2)
        if _browser_button("Done" if walk.purpose.stays else "Cancel"):
            self.walk = None
        imgui.same_line()
        with widgets.disabled(not walk.can_confirm):
            is_pressed = _browser_button(walk.purpose.verb)
        return walk.confirm() if is_pressed or is_entered else None

    def _draw_name_field(self, walk: FolderWalk) -> bool:
        """Draw the field for the name; return True if Enter was pressed in it."""
        widgets.label("name")
        if self._is_new:
            imgui.set_keyboard_focus_here()
        is_entered, name = imgui.input_text(
            "##name", walk.name, imgui.InputTextFlags_.enter_returns_true
        )
        rects.note("browser name")
        if name != walk.name:
            walk.type_name(name)
        return bool(is_entered)


def _set_size_and_position() -> None:
    """Centre the dialog and give it its usual size, or less in a small window."""
    em, screen = imgui.get_font_size(), imgui.get_main_viewport()
    width = min(_SIZE_EM[0] * em, 0.94 * screen.work_size.x)
    height = min(_SIZE_EM[1] * em, 0.9 * screen.work_size.y)
    imgui.set_next_window_size(ImVec2(width, height), imgui.Cond_.appearing)
    imgui.set_next_window_pos(screen.get_center(), imgui.Cond_.appearing, ImVec2(0.5, 0.5))


def _single_files(walk: FolderWalk) -> None:
    """Draw the checkbox that lists single files instead of sequences, left of the buttons."""
    is_single = widgets.check("single files", walk.is_single, "browser single files")
    if is_single != walk.is_single:
        walk.list_single(is_single)
    imgui.same_line()


def _note(walk: FolderWalk) -> str:
    """Return the line of text under the list."""
    return walk.problem or ("Reading ..." if walk.is_reading else walk.purpose.note)


def _footer_height(walk: FolderWalk) -> float:
    """Return the height of the field or question, the note and the buttons, in screen units."""
    rows = 2 if walk.purpose.is_save else 1
    text = imgui.calc_text_size(_note(walk), False, imgui.get_content_region_avail().x)
    gaps = 2 * imgui.get_style().item_spacing.y
    return float(rows * imgui.get_frame_height_with_spacing() + text.y + gaps)


def _draw_list(walk: FolderWalk) -> ChosenFile | None:
    """Draw the list of folders and files; return the entry that was double-clicked, or None."""
    em = imgui.get_font_size()
    flags = imgui.TableFlags_.scroll_y | imgui.TableFlags_.borders_outer
    if not imgui.begin_table("files", 3, flags, ImVec2(0, -_footer_height(walk))):
        return None
    columns = imgui.TableColumnFlags_
    imgui.table_setup_scroll_freeze(0, 1)
    imgui.table_setup_column("name", columns.width_stretch)
    imgui.table_setup_column("frames", columns.width_fixed, _FRAMES_EM * em)
    imgui.table_setup_column("written", columns.width_fixed, _WRITTEN_EM * em)
    imgui.table_headers_row()
    picked_file = None
    for index, entry in enumerate(list(walk.rows)):
        picked_file = _draw_row(walk, index, entry) or picked_file
    if not (walk.rows or walk.is_reading or walk.problem):
        imgui.table_next_column()
        imgui.text_disabled(f"No folder and no {' or '.join(walk.purpose.suffixes)} in here.")
    imgui.end_table()
    return picked_file


def _draw_row(walk: FolderWalk, index: int, entry: str | Entry) -> ChosenFile | None:
    """Draw a folder or a file of the list; return the file if it was double-clicked."""
    name = f"{entry}/" if isinstance(entry, str) else entry.name
    imgui.table_next_row()
    imgui.table_next_column()
    flags = imgui.SelectableFlags_.span_all_columns | imgui.SelectableFlags_.allow_double_click
    is_clicked, _ = imgui.selectable(f"##{index}", index == walk.row, flags)
    rects.note(f"file {name}")
    imgui.same_line(0.0, 0.0)
    imgui.text(printable(name))  # not as the label, which would end at the ## of a sequence
    if isinstance(entry, Entry):
        imgui.table_next_column()
        imgui.text_disabled(entry.frames_text)
        imgui.table_next_column()
        imgui.text_disabled(_time_text(entry.written_s))
    if is_clicked:
        walk.select(index)
    is_double = imgui.is_mouse_double_clicked(imgui.MouseButton_.left)
    return walk.confirm() if is_clicked and is_double else None


def _handle_keys(walk: FolderWalk) -> ChosenFile | None:
    """Handle keys: arrows move in the list, Enter returns a file, Backspace goes to the parent."""
    step = int(imgui.is_key_pressed(_Key.down_arrow)) - int(imgui.is_key_pressed(_Key.up_arrow))
    if step and walk.rows:
        walk.select(walk.row + step)
    if imgui.is_key_pressed(_Key.backspace, False):
        walk.go("..")
    is_enter = any(imgui.is_key_pressed(key, False) for key in (_Key.enter, _Key.keypad_enter))
    return walk.confirm() if is_enter and walk.existing_file is None else None


def _overwrite_question(walk: FolderWalk, path: Path) -> ChosenFile | None:
    """Draw the question whether to replace a file; return the file if the user agrees."""
    imgui.align_text_to_frame_padding()
    imgui.text_colored(theme.colors.bad, f"{printable(path.name)} already exists. Overwrite it?")
    imgui.text_disabled(walk.purpose.note)
    _align_right(2)
    chosen_file = walk.overwrite() if _browser_button("Overwrite") else None
    imgui.same_line()
    if _browser_button(
        "Keep it"
    ):  # at the place of Save, so that a second click there does no harm
        walk.existing_file = None
    return chosen_file


def _align_right(buttons: int) -> None:
    """Move the cursor so that this many buttons end at the right edge."""
    width = buttons * _BUTTON_EM * imgui.get_font_size()
    width += (buttons - 1) * imgui.get_style().item_spacing.x
    right = imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x
    imgui.set_cursor_pos_x(max(right - width, imgui.get_cursor_pos_x()))


def _browser_button(name: str) -> bool:
    return widgets.button(name, f"browser {name}", width=_BUTTON_EM * imgui.get_font_size())


def _time_text(seconds: float) -> str:
    return time.strftime("%Y-%m-%d  %H:%M", time.localtime(seconds)) if seconds else ""
