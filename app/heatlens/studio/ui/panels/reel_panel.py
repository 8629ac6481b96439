"""Draw the Reel panel: the shots of the cut, with the focus on both sides of each cut.

The stills of the shots are shown as the screen shows them.
"""

from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.shot.reel import CutFocus, Reel, ReelShot
from heatlens.core.model.units import label_distance
from heatlens.core.model.view.view import Compare
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.gpu.device import Texture
from heatlens.studio.board.board import Board
from heatlens.studio.board.controls import FileControl, PictureControl
from heatlens.studio.ui import rects, texts, widgets
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.picture.picture_alone import PictureAlone

_MAX_UPLOADS = 2  # in one frame of the window
_SCENE_STILL_PX = 128, 72


@dataclass
class _Still:
    """A still of a shot.

    light    the first plate, scene-linear; None for a scene, whose still is drawn
    texture  the still in the colors of the screen
    look     exposure, gamma and version of the view transform of `texture`
    """

    light: Texture | None
    texture: Texture
    look: tuple[object, ...]

    def release(self) -> None:
        self.texture.release()
        if self.light is not None:
            self.light.release()


# A still keeps scene-linear light and goes through the view transform of the window, so it looks
# like the shot on the screen; this is repeated when exposure, gamma or view change. At most two
# stills are uploaded in a frame, so that opening a long reel does not block the window.
class ReelStills:
    """Textures of the stills that were visible so far, of one reel at a time."""

    def __init__(self, board: Board, control: PictureControl, screen: ScreenPictures) -> None:
        self._board, self._control, self._screen = board, control, screen
        self._picture = PictureAlone(control.renderer.ctx)
        self._reel: Reel | None = None
        self._stills: dict[int, _Still] = {}
        self._uploads = 0

    def begin(self, files: FileControl, pictures: Pictures | None) -> None:
        """Drop the stills of another reel, and draw the still of an open scene.

        Call this before the rows are drawn; `pictures` are those in the viewport.
        """
        self._uploads, reel = 0, files.reel
        if reel.reel is not self._reel:
            for still in self._stills.values():
                still.release()
            self._stills, self._reel = {}, reel.reel
        picture = self._control.live.output
        is_shown = picture is not None and picture.is_whole and self._board.facts.is_live_alone
        if pictures is not None and is_shown and self._board.facts.has_camera and reel.is_open:
            self._draw_scene_still(reel.number, pictures)

    def texture_of(self, files: FileControl, number: int) -> Texture | None:
        """Return the still of a shot, the bottom row first; None if there is none yet."""
        still = self._stills.get(number)
        if still is None and self._uploads < _MAX_UPLOADS:
            still = self._upload(files, number)
        if still is None:
            return None
        if still.light is not None and still.look != self._look:
            self._screen.draw_still(still.texture, still.light, self._board.facts.view)
            still.look = self._look
        return still.texture

    def _upload(self, files: FileControl, number: int) -> _Still | None:
        """Upload the still of a shot and return it; None if it is not read yet."""
        pixels = files.reel.still_of(number)
        if pixels is None:
            return None
        self._uploads += 1
        height, width = pixels.shape[:2]
        ctx = self._control.renderer.ctx
        light = ctx.texture((width, height), 4, pixels[::-1].tobytes(), dtype="f2")
        texture = self._screen.draw_still(None, light, self._board.facts.view)
        self._stills[number] = still = _Still(light, texture, self._look)
        return still

    def _draw_scene_still(self, number: int, pictures: Pictures) -> None:
        """Draw the picture of the open scene as its still, once for each view transform."""
        old_still = self._stills.get(number)
        if old_still is not None and old_still.look == self._look:
            return
        plain_view = replace(self._board.facts.view, compare=Compare.OFF)
        self._picture.draw(replace(pictures, tiles=()), plain_view, _SCENE_STILL_PX)
        if old_still is not None:
            old_still.release()
        self._stills[number] = _Still(None, self._picture.detach_texture(), self._look)

    @property
    def _look(self) -> tuple[object, ...]:
        """Return what the colors of the stills depend on besides their light."""
        view = self._board.facts.view
        return view.exposure_stops, view.gamma, self._screen.transform_version


_HEADS = {"": 4.6, "shot": 12.0, "frames": 7.5, "focus in": 6.0, "focus out": 6.0, "notes": 0.0}
_FLAGS = imgui.TableFlags_.row_bg | imgui.TableFlags_.scroll_y
_STILL_EM = 4.6, 2.6


def reel_panel(files: FileControl, unit: str, stills: ReelStills) -> None:
    """Draw the shots; a click opens one."""
    reel = files.reel
    if reel.reel is None or reel.path is None:
        return
    if widgets.button("< previous", "previous shot"):
        reel.step(-1)
    imgui.same_line()
    if widgets.button("next >", "next shot"):
        reel.step(1)
    imgui.same_line()
    texts.gray_text(f"{reel.number + 1} of {len(reel.reel.shots)}, {printable(reel.path.name)}")
    if not imgui.begin_table("shots", len(_HEADS), _FLAGS):
        return
    fixed, stretch = imgui.TableColumnFlags_.width_fixed, imgui.TableColumnFlags_.width_stretch
    for title, width_em in _HEADS.items():
        imgui.table_setup_column(
            title, fixed if width_em else stretch, width_em * imgui.get_font_size()
        )
    imgui.table_setup_scroll_freeze(0, 1)
    imgui.table_headers_row()
    for number, shot in enumerate(reel.reel.shots):
        imgui.table_next_row()
        imgui.table_next_column()
        _draw_still(files, number, stills)
        imgui.table_next_column()
        if _draw_name(shot, number == reel.number):
            reel.go(number)
        notes = printable(". ".join((*shot.marks, *shot.notes)))
        for text in (_frames_text(shot), *_focus_texts(reel.focus_of(number), unit), notes):
            imgui.table_next_column()
            imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() + _text_offset())
            imgui.text_disabled(text)
    imgui.end_table()


def _draw_still(files: FileControl, number: int, stills: ReelStills) -> None:
    """Draw the first picture of a shot as large as it fits; leave the space empty without one."""
    em = imgui.get_font_size()
    width, height = _STILL_EM[0] * em, _STILL_EM[1] * em
    corner = imgui.get_cursor_screen_pos()
    imgui.dummy(ImVec2(width, height))
    if not imgui.is_item_visible():
        return
    texture = stills.texture_of(files, number)
    if texture is None:
        return
    scale = min(width / texture.width, height / texture.height)
    end = ImVec2(corner.x + scale * texture.width, corner.y + scale * texture.height)
    flipped_corners = ImVec2(0, 1), ImVec2(1, 0)
    picture = imgui.ImTextureRef(texture.handle)
    imgui.get_window_draw_list().add_image(picture, corner, end, *flipped_corners)


def _draw_name(shot: ReelShot, is_open: bool) -> bool:
    """Draw the name of a shot over the whole row; return True if it is clicked."""
    flags = imgui.SelectableFlags_.span_all_columns
    size = ImVec2(0.0, _STILL_EM[1] * imgui.get_font_size())
    imgui.push_style_var(imgui.StyleVar_.selectable_text_align, ImVec2(0.0, 0.5))
    with widgets.disabled(not shot.source):
        is_clicked, _ = imgui.selectable(f"{printable(shot.name)}##shot", is_open, flags, size)
    imgui.pop_style_var()
    rects.note(f"shot {shot.name}")
    if shot.notes:
        texts.tooltip("\n".join((*shot.marks, *shot.notes)))
    return bool(is_clicked)


def _text_offset() -> float:
    """Return how far below the top of a row a vertically centered line of text begins."""
    return (_STILL_EM[1] * imgui.get_font_size() - imgui.get_text_line_height()) / 2


def _frames_text(shot: ReelShot) -> str:
    return "all" if shot.frames is None else str(shot.frames)


def _focus_texts(focus: CutFocus, unit: str) -> tuple[str, str]:
    """Return the focus at both ends of a shot as text."""
    return tuple(  # type: ignore[return-value]
        "-" if distance_m is None else label_distance(distance_m, unit)
        for distance_m in (focus.first_m, focus.last_m)
    )
