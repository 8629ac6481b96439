"""Draw parts of the timeline's rows: the background of a name, and the shape of a key."""

from imgui_bundle import ImVec2, imgui

from heatlens.session.keys.key_rows import Row
from heatlens.session.session import Session
from heatlens.ui import probe, theme

_LEFT_EM, _RIGHT_EM = 1.1, 0.3  # room for the dot left of the name, and for a gap to the keys


def row_name(
    session: Session, row: Row, corner: ImVec2, keys_x: float, height: float, tip: str
) -> None:
    """Draw the background of a row's name, from `corner` to `keys_x`.

    It is lighter for the selected row, and a click selects the row. The caller draws the name over
    it.
    """
    em = imgui.get_font_size()
    first = ImVec2(corner.x + _LEFT_EM * em, corner.y)
    size = ImVec2(max(keys_x - _RIGHT_EM * em - first.x, 1.0), height - 2)
    imgui.set_cursor_screen_pos(first)
    if imgui.invisible_button(f"row {row}", size):
        session.keys.rows.choose(row)
    probe.note(f"row {row}")
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip(tip)
    if session.keys.rows.chosen is row:
        end = ImVec2(first.x + size.x, first.y + size.y)
        imgui.get_window_draw_list().add_rect_filled(first, end, theme.colors.played, 3.0)


def diamond(middle: ImVec2, reach: float) -> tuple[ImVec2, ImVec2, ImVec2, ImVec2]:
    """Return the corners of a diamond, `reach` from its middle, in screen units."""
    x, y = middle.x, middle.y
    return (
        ImVec2(x, y - reach),
        ImVec2(x + reach, y),
        ImVec2(x, y + reach),
        ImVec2(x - reach, y),
    )
