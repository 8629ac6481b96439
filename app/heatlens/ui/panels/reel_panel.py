"""Draw the Reel panel: the shots of the cut, with the focus on both sides of each cut."""

from imgui_bundle import ImVec2, imgui

from heatlens.base.outside_text import printable
from heatlens.model.shot.reel import ReelShot
from heatlens.model.units import format_distance
from heatlens.session.files.open_reel import CutFocus, OpenReel
from heatlens.ui import probe, widgets
from heatlens.ui.panels.reel_stills import ReelStills

_HEADS = {"": 4.6, "shot": 12.0, "frames": 7.5, "focus in": 6.0, "focus out": 6.0, "notes": 0.0}
_FLAGS = imgui.TableFlags_.row_bg | imgui.TableFlags_.scroll_y
_STILL_EM = 4.6, 2.6


def reel_panel(reel: OpenReel, unit: str, stills: ReelStills) -> None:
    """Draw the shots; a click opens one."""
    if reel.reel is None or reel.path is None:
        return
    if widgets.button("< previous", "previous shot"):
        reel.step(-1)
    imgui.same_line()
    if widgets.button("next >", "next shot"):
        reel.step(1)
    imgui.same_line()
    widgets.grey_text(f"{reel.at + 1} of {len(reel.reel.shots)}, {printable(reel.path.name)}")
    if not imgui.begin_table("shots", len(_HEADS), _FLAGS):
        return
    fixed, rest = imgui.TableColumnFlags_.width_fixed, imgui.TableColumnFlags_.width_stretch
    for head, width_em in _HEADS.items():
        imgui.table_setup_column(
            head, fixed if width_em else rest, width_em * imgui.get_font_size()
        )
    imgui.table_setup_scroll_freeze(0, 1)
    imgui.table_headers_row()
    for number, shot in enumerate(reel.reel.shots):
        imgui.table_next_row()
        imgui.table_next_column()
        _still(reel, number, stills)
        imgui.table_next_column()
        if _name(shot, number == reel.at):
            reel.go(number)
        notes = printable(". ".join((*shot.marks, *shot.notes)))
        for text in (_frames(shot), *_focus(reel.focus_of(number), unit), notes):
            imgui.table_next_column()
            imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() + _below_top())
            imgui.text_disabled(text)
    imgui.end_table()


def _still(reel: OpenReel, number: int, stills: ReelStills) -> None:
    """Draw the first picture of a shot as tall as it fits; an empty place if there is none."""
    em = imgui.get_font_size()
    width, height = _STILL_EM[0] * em, _STILL_EM[1] * em
    corner = imgui.get_cursor_screen_pos()
    imgui.dummy(ImVec2(width, height))
    if not imgui.is_item_visible():
        return
    texture = stills.of(reel, number)
    if texture is None:
        return
    scale = min(width / texture.width, height / texture.height)
    end = ImVec2(corner.x + scale * texture.width, corner.y + scale * texture.height)
    flipped = ImVec2(0, 1), ImVec2(1, 0)
    picture = imgui.ImTextureRef(texture.glo)
    imgui.get_window_draw_list().add_image(picture, corner, end, *flipped)


def _name(shot: ReelShot, is_open: bool) -> bool:
    """Draw the name of a shot over the whole row; return True if it is clicked."""
    flags = imgui.SelectableFlags_.span_all_columns
    size = ImVec2(0.0, _STILL_EM[1] * imgui.get_font_size())
    imgui.push_style_var(imgui.StyleVar_.selectable_text_align, ImVec2(0.0, 0.5))
    with widgets.disabled(not shot.source):
        clicked, _ = imgui.selectable(f"{printable(shot.name)}##shot", is_open, flags, size)
    imgui.pop_style_var()
    probe.note(f"shot {shot.name}")
    if shot.notes:
        widgets.tooltip("\n".join((*shot.marks, *shot.notes)))
    return bool(clicked)


def _below_top() -> float:
    """Return how far below the top of a row a line of text stands in its middle."""
    return (_STILL_EM[1] * imgui.get_font_size() - imgui.get_text_line_height()) / 2


def _frames(shot: ReelShot) -> str:
    return "all" if shot.frames is None else str(shot.frames)


def _focus(focus: CutFocus, unit: str) -> tuple[str, str]:
    return tuple(  # type: ignore[return-value]
        "-" if distance_m is None else format_distance(distance_m, unit)
        for distance_m in (focus.first_m, focus.last_m)
    )
