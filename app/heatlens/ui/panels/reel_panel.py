"""Draw the Reel panel: the shots of the cut, with the focus on both sides of each cut."""

import moderngl
import numpy as np
from imgui_bundle import ImVec2, imgui

from heatlens.base.printable import printable
from heatlens.model.shot.reel import Reel, ReelShot
from heatlens.model.units import format_distance
from heatlens.session.files.open_reel import CutFocus, OpenReel
from heatlens.ui import probe, widgets

_HEADS = {"": 4.6, "shot": 12.0, "frames": 7.5, "focus in": 6.0, "focus out": 6.0, "notes": 0.0}
_FLAGS = imgui.TableFlags_.row_bg | imgui.TableFlags_.scroll_y
_STILL_EM = 4.6, 2.6
_UPLOADS_MOST = 2  # in one frame of the window


class ReelTextures:
    """The stills of the rows that were seen, as textures; those of one reel at a time."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._reel: Reel | None = None
        self._textures: dict[int, moderngl.Texture] = {}
        self._uploads = 0

    def begin(self, reel: OpenReel) -> None:
        """Drop those of another reel; call this before the rows are drawn."""
        self._uploads = 0
        if reel.reel is not self._reel:
            for texture in self._textures.values():
                texture.release()
            self._textures, self._reel = {}, reel.reel

    def of(self, reel: OpenReel, number: int) -> moderngl.Texture | None:
        """Return the still of a shot; None if there is none yet."""
        if number not in self._textures and self._uploads < _UPLOADS_MOST:
            still = reel.still_of(number)
            if still is not None:
                self._uploads += 1
                height, width = still.shape[:2]
                pixels = np.dstack([still, np.full((height, width), 255, np.uint8)])
                self._textures[number] = self._ctx.texture((width, height), 4, pixels.data)
        return self._textures.get(number)


def reel_panel(reel: OpenReel, unit: str, textures: ReelTextures) -> None:
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
    textures.begin(reel)
    for number, shot in enumerate(reel.reel.shots):
        imgui.table_next_row()
        imgui.table_next_column()
        _still(reel, number, textures)
        imgui.table_next_column()
        if _name(shot, number == reel.at):
            reel.go(number)
        notes = printable(". ".join((*shot.marks, *shot.notes)))
        for text in (_frames(shot), *_focus(reel.focus_of(number), unit), notes):
            imgui.table_next_column()
            imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() + _below_top())
            imgui.text_disabled(text)
    imgui.end_table()


def _still(reel: OpenReel, number: int, textures: ReelTextures) -> None:
    """Draw the first picture of a shot as tall as it fits; an empty place if there is none."""
    em = imgui.get_font_size()
    width, height = _STILL_EM[0] * em, _STILL_EM[1] * em
    corner = imgui.get_cursor_screen_pos()
    imgui.dummy(ImVec2(width, height))
    if not imgui.is_item_visible():
        return
    texture = textures.of(reel, number)
    if texture is None:
        return
    scale = min(width / texture.width, height / texture.height)
    end = ImVec2(corner.x + scale * texture.width, corner.y + scale * texture.height)
    imgui.get_window_draw_list().add_image(imgui.ImTextureRef(texture.glo), corner, end)


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
