"""Draw the window that lists all shortcuts and mouse gestures."""

from collections.abc import Sequence
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from heatlens.studio.board.command import Command, keys_by_menu
from heatlens.studio.ui import rects, texts, topmost, widgets

Rows = tuple[tuple[str, str], ...]  # (keys or gesture, what it does)
_COLUMNS = 4  # largest number of columns
_HEAD_ROWS = 1.6  # height of a section title, in rows
_EDGE_EM = 2.0  # free width beside the window, both sides together
_KEYS_EM = 8.0  # smallest width of the keys
_TITLE = "Keys"
_GAP = "   "  # spaces after a description
_KEYS_GAP_EM = 1.3  # gap between keys and description

_MOUSE: Rows = (
    ("click, drag", "focus there; the sky is infinity"),
    ("Ctrl+Shift+click", "set a mark at that point"),
    ("wheel", "zoom at the pointer"),
    ("wheel over the focus bar", "focus"),
    ("Shift+wheel", "focus, over the picture"),
    ("Alt held a moment", "depth of field off, to compare"),
    ("Ctrl+click on a number", "type it"),
)
_MOUSE_OF_TIME: Rows = (
    ("drag on the ruler", "scrub"),
    ("F, Alt+wheel on a curve", "bring marks in, zoom values"),
    ("wheel, middle drag", "zoom, pan"),
    ("Shift+click on keys, box", "select several"),
    ("Ctrl+drag of a key", "move all later keys as well"),
)
_PAN_PLATE: Rows = (("middle or right drag", "pan"),)
_PAN_SCENE: Rows = (("middle drag", "pan the picture"),)
_MOUSE_OF_SCENE: Rows = (
    ("right drag", "orbit round what is in focus"),
    ("Ctrl+right drag", "move the camera sideways"),
    ("Ctrl+wheel", "dolly to what is in focus"),
)


@dataclass(frozen=True)
class Section:
    """A group of shortcuts or gestures with its title."""

    title: str
    rows: Rows


def sections(commands: Sequence[Command], has_camera: bool) -> list[Section]:
    """Return the sections: the mouse, then each menu's shortcuts; `has_camera` adds gestures."""
    of_menus = [Section(*of_menu) for of_menu in keys_by_menu(commands).items()]
    return mouse_sections(has_camera) + of_menus


def mouse_sections(has_camera: bool) -> list[Section]:
    """Return what the mouse does; `has_camera` adds the gestures of a scene."""
    pan = _PAN_SCENE if has_camera else _PAN_PLATE
    in_scene = [Section("Mouse in the scene", _MOUSE_OF_SCENE)] if has_camera else []
    on_timeline = Section("Mouse on the timeline", _MOUSE_OF_TIME)
    return [Section("Mouse", _MOUSE + pan), *in_scene, on_timeline]


def distribute_in_columns(sections: Sequence[Section], count: int) -> list[list[Section]]:
    """Distribute sections, in order, over columns of about equal height."""
    columns: list[list[Section]] = [[] for _ in range(count)]
    for section in sorted(sections, key=lambda section: -len(section.rows)):
        lowest = min(
            columns, key=lambda column: sum(_HEAD_ROWS + len(section.rows) for section in column)
        )
        lowest.append(section)
    ordered = [sorted(column, key=sections.index) for column in columns if column]
    return sorted(ordered, key=lambda column: sections.index(column[0]))


def keys_window(commands: Sequence[Command], has_camera: bool) -> bool:
    """Draw the window in the middle of the screen; return False when the user closed it."""
    screen, edge = imgui.get_main_viewport(), _EDGE_EM * imgui.get_font_size()
    max_size = ImVec2(max(screen.work_size.x - edge, 1.0), max(screen.work_size.y - edge, 1.0))
    imgui.set_next_window_size_constraints(ImVec2(1.0, 1.0), max_size)
    imgui.set_next_window_size(ImVec2(0, 0))
    middle = screen.get_work_center()
    imgui.set_next_window_pos(middle, imgui.Cond_.always, ImVec2(0.5, 0.5))
    if not imgui.is_popup_open(_TITLE):
        imgui.open_popup(_TITLE)
    is_visible, is_open = topmost.begin_modal(
        _TITLE, can_close=True, flags=imgui.WindowFlags_.no_saved_settings
    )
    if not is_visible:
        return False
    corner, size = imgui.get_window_pos(), imgui.get_window_size()
    rects.note_at("keys window", (corner.x, corner.y, corner.x + size.x, corner.y + size.y))
    width = max_size.x - 2 * imgui.get_style().window_padding.x
    _draw_columns(_fit_columns(sections(commands, has_camera), width))
    if is_closed := not is_open or topmost.is_escaped() or _is_key_pressed_again():
        imgui.close_current_popup()
    imgui.end_popup()
    return not is_closed


def _fit_columns(sections: Sequence[Section], width: float) -> list[list[Section]]:
    """Return the sections in as many columns as fit into `width`, at least one."""
    width += imgui.calc_text_size(_GAP).x  # the last column needs no gap
    for count in range(_COLUMNS, 1, -1):
        columns = distribute_in_columns(sections, count)
        if sum(max(map(_section_width, column)) for column in columns) <= width:
            return columns
    return distribute_in_columns(sections, 1)


def _section_width(section: Section) -> float:
    """Return the width of a section with the gap behind it."""
    texts = [imgui.calc_text_size(f"{what}{_GAP}").x for _, what in section.rows]
    return _keys_width(section) + max(texts) + 2 * imgui.get_style().cell_padding.x


def _keys_width(section: Section) -> float:
    """Return the width of the column of keys of a section."""
    em = imgui.get_font_size()
    widest = max(imgui.calc_text_size(texts.named_keys(keys)).x for keys, _ in section.rows)
    return float(max(widest + _KEYS_GAP_EM * em, _KEYS_EM * em))


def _is_key_pressed_again() -> bool:
    """Return True if the key that opened the window was pressed again."""
    return imgui.is_key_pressed(imgui.Key.f1, False) and not imgui.is_window_appearing()


def _draw_columns(columns: Sequence[Sequence[Section]]) -> None:
    """Draw the columns of sections side by side."""
    if imgui.begin_table("keys", len(columns), imgui.TableFlags_.sizing_fixed_fit):
        for column in columns:
            imgui.table_next_column()
            for section in column:
                _draw_section(section)
        imgui.end_table()


def _draw_section(section: Section) -> None:
    """Draw the title and the rows of a section."""
    imgui.separator_text(section.title)
    text_x = _keys_width(section)
    for keys, what in section.rows:
        imgui.text_disabled(texts.named_keys(keys))
        imgui.same_line(text_x)  # measured from the left of the column
        imgui.text(f"{what}{_GAP}")
    widgets.spacer()
