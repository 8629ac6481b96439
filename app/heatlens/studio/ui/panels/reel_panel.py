"""Draw the Reel panel: the shots of the cut, with the focus on both sides of each cut.

The stills of the shots are shown as the screen shows them.
"""

from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.units import format_distance
from heatlens.core.model.view.view import Compare
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.gpu.device import Texture
from heatlens.studio.session.desks import PictureDesk
from heatlens.studio.session.facts import Facts
from heatlens.studio.session.files.open_reel import CutFocus, OpenReel
from heatlens.studio.ui import probe, texts, widgets
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.picture.picture_alone import PictureAlone

_UPLOADS_MOST = 2  # in one frame of the window
_DRAWN_PX = 128, 72


@dataclass
class _Still:
    """A still, and what it shows.

    light   the first plate, scene-linear; None in the still of a scene, which was drawn
    shown   what the screen shows
    look    exposure, gamma and version of the view transform of `shown`
    """

    light: Texture | None
    shown: Texture
    look: tuple[object, ...]

    def release(self) -> None:
        self.shown.release()
        if self.light is not None:
            self.light.release()


# A still keeps scene-linear light and goes through the view transform of the window, so that a reel
# is seen as the screen shows its shots; it does so again when exposure, gamma or view change. Two
# are uploaded in a frame at most, so that a long reel does not hold up the window when it is
# opened.
class ReelStills:
    """Textures of the rows that were seen; those of one reel at a time."""

    def __init__(self, facts: Facts, desk: PictureDesk, screen: ScreenPictures) -> None:
        self._facts, self._desk, self._screen = facts, desk, screen
        self._alone = PictureAlone(desk.renderer.ctx)
        self._reel: Reel | None = None
        self._stills: dict[int, _Still] = {}
        self._uploads = 0

    def begin(self, reel: OpenReel, pictures: Pictures | None) -> None:
        """Drop those of another reel, and take the picture of an open scene.

        Call this before the rows are drawn; `pictures` are those in the viewport.
        """
        self._uploads = 0
        if reel.reel is not self._reel:
            for still in self._stills.values():
                still.release()
            self._stills, self._reel = {}, reel.reel
        seen = self._desk.live.shown
        is_seen = seen is not None and seen.is_whole and self._facts.is_plain
        if pictures is not None and is_seen and self._facts.has_camera and reel.is_open:
            self._take(reel.at, pictures)

    def of(self, reel: OpenReel, number: int) -> Texture | None:
        """Return the still of a shot, the bottom row first; None if there is none yet."""
        still = self._stills.get(number)
        if still is None and self._uploads < _UPLOADS_MOST:
            still = self._uploaded(reel, number)
        if still is None:
            return None
        if still.light is not None and still.look != self._look:
            self._screen.still(still.shown, still.light, self._facts.view)
            still.look = self._look
        return still.shown

    def _uploaded(self, reel: OpenReel, number: int) -> _Still | None:
        pixels = reel.still_of(number)
        if pixels is None:
            return None
        self._uploads += 1
        height, width = pixels.shape[:2]
        ctx = self._desk.renderer.ctx
        light = ctx.texture((width, height), 4, pixels[::-1].tobytes(), dtype="f2")
        shown = self._screen.still(None, light, self._facts.view)
        self._stills[number] = still = _Still(light, shown, self._look)
        return still

    def _take(self, number: int, pictures: Pictures) -> None:
        """Draw the picture of the open scene as its still, once for each view transform."""
        before = self._stills.get(number)
        if before is not None and before.look == self._look:
            return
        plain = replace(self._facts.view, compare=Compare.OFF)
        self._alone.draw(replace(pictures, tiles=()), plain, _DRAWN_PX)
        if before is not None:
            before.release()
        self._stills[number] = _Still(None, self._alone.hand_over(), self._look)

    @property
    def _look(self) -> tuple[object, ...]:
        view = self._facts.view
        return view.exposure_stops, view.gamma, self._screen.transform_version


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
    texts.grey_text(f"{reel.at + 1} of {len(reel.reel.shots)}, {printable(reel.path.name)}")
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
    picture = imgui.ImTextureRef(texture.handle)
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
        texts.tooltip("\n".join((*shot.marks, *shot.notes)))
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
