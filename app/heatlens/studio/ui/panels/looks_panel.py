"""Draw the Looks panel: a still of each look, with buttons to use, compare and delete it."""

from dataclasses import replace

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from heatlens.core.base.outside_text import printable
from heatlens.core.model.shot.look import Look
from heatlens.core.model.view.compared_looks import grid_names, is_look_b
from heatlens.core.model.view.view import GRID_MOST, Compare
from heatlens.media.files.still_text import pixels_of_still, still_of
from heatlens.render.gpu.resources import Texture
from heatlens.studio.board.board import Board
from heatlens.studio.board.controls import PictureControl
from heatlens.studio.board.facts import Facts
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.picture.picture_alone import PictureAlone
from heatlens.studio.ui.segments import toggle_button

_STILL_PX = 256, 144
_STILL_EM = 9.6, 5.4
_NAME_EM = 4.0
_MAX_STILLS = 64


class LookStills:
    """Thumbnails of looks: stored in the looks, or taken while the whole picture shows a look."""

    def __init__(self, board: Board, control: PictureControl) -> None:
        self._board = board
        self._control = control
        self._ctx = control.renderer.ctx
        self._picture = PictureAlone(self._ctx)
        self._textures: dict[tuple[object, ...], Texture | None] = {}

    def thumbnail(self, look: Look) -> Texture | None:
        """Return the thumbnail of a look; None if there is none yet."""
        if look.still is None:
            return self._textures.get((self._board.facts.shot.source, look.lens, look.frame))
        key = (look.still,)
        if key not in self._textures:
            pixels = pixels_of_still(look.still)
            self._add(key, None if pixels is None else self._make_texture(pixels))
        return self._textures[key]

    def make_still(self, pictures: Pictures | None) -> str | None:
        """Return the present picture as a still for a look; None if another picture shows."""
        is_comparison = self._board.facts.view.compare in (Compare.DIFFERENCE, Compare.FLIP)
        if (
            pictures is None
            or is_comparison
            or self._board.facts.view.a_look
            or not self._board.facts.view.depth_of_field
        ):
            return None
        self._draw_thumbnail(pictures)
        texture = self._picture.texture
        assert texture is not None
        pixels = np.frombuffer(texture.read(), np.uint8)
        return still_of(pixels.reshape(texture.height, texture.width, 4)[::-1, :, :3])

    def take_thumbnail(self, pictures: Pictures | None) -> None:
        """Take a thumbnail if the picture shows a look without one; call this once a frame."""
        picture = self._control.live.output
        if (
            pictures is None
            or picture is None
            or not (picture.is_whole and self._board.facts.is_live_alone)
        ):
            return
        for look in self._board.facts.shot.looks:
            is_current_lens = (look.lens, look.frame) == (
                self._board.facts.lens,
                self._board.facts.frame,
            )
            is_of_frame = (
                picture.frame == look.frame and picture.shot == self._board.facts.seen_shot
            )
            if is_current_lens and is_of_frame and self.thumbnail(look) is None:
                self._draw_thumbnail(pictures)
                key = (self._board.facts.shot.source, look.lens, look.frame)
                self._add(key, self._picture.detach_texture())

    def _draw_thumbnail(self, pictures: Pictures) -> None:
        """Draw the picture through the lens, without comparison, as a thumbnail."""
        plain_view = replace(self._board.facts.view, compare=Compare.OFF)
        self._picture.draw(replace(pictures, tiles=()), plain_view, _STILL_PX)

    def _add(self, key: tuple[object, ...], texture: Texture | None) -> None:
        """Keep a thumbnail, and release the oldest one if there are too many."""
        if len(self._textures) >= _MAX_STILLS:
            oldest = self._textures.pop(next(iter(self._textures)))
            if oldest is not None:
                oldest.release()
        self._textures[key] = texture

    def _make_texture(self, pixels: NDArray[np.uint8]) -> Texture:
        """Return pixels (H, W, 3), top row first, as a texture."""
        height, width = pixels.shape[:2]
        rgba = np.dstack([pixels, np.full((height, width), 255, np.uint8)])
        return self._ctx.texture((width, height), 4, np.ascontiguousarray(rgba[::-1]).data)


def looks_panel(board: Board, control: PictureControl, stills: LookStills) -> None:
    """Draw the Looks panel in the current window."""
    tip = "Stores focal length, f-stop, focus and film back under a letter (Shift+L)."
    if widgets.button("Keep this look", "keep look", tip):
        board.do("Keep this look")
    facts = board.facts
    view, looks = facts.view, facts.shot.looks
    is_grid = view.compare is Compare.GRID
    imgui.same_line()
    with widgets.disabled(not looks):
        tip = "Up to four looks side by side (Shift+W); click one to take it."
        if widgets.button("Leave grid" if is_grid else "Grid", "look grid", tip):
            control.looks.toggle_grid()
    imgui.same_line()
    with widgets.disabled(not is_look_b(view)):
        if widgets.button("Wipe off", "look wipe off"):
            control.commands.change(compare=Compare.OFF)
    if not looks:
        imgui.text_wrapped("No looks yet. Set up the lens, then Shift+L keeps it as look A.")
    for index, look in enumerate(looks):
        _look_row(facts, control, stills, index, look)


def _look_row(
    facts: Facts, control: PictureControl, stills: LookStills, index: int, look: Look
) -> None:
    """Draw the thumbnail, the name, the lens values and the buttons of a look."""
    em = imgui.get_font_size()
    imgui.push_id(look.name)
    imgui.separator()
    corner = imgui.get_cursor_screen_pos()
    if _still_button(stills.thumbnail(look)):
        control.looks.use_number(index)
    rects.note(f"look {look.name}")
    texts.tooltip(f"Take this lens again{f' (Ctrl+{index + 1})' if index < 9 else ''}")
    if facts.lens == look.lens:
        size = imgui.get_item_rect_size()
        end = ImVec2(corner.x + size.x, corner.y + size.y)
        imgui.get_window_draw_list().add_rect(corner, end, theme.colors.accent, 2.0, 2.0)
    imgui.same_line()
    imgui.begin_group()
    imgui.set_next_item_width(_NAME_EM * em)
    name = widgets.text_field(
        f"look name {look.name}", look.name, look.name, str.strip, control.notify
    )
    lens = look.lens
    words = printable(f"{lens.focal_length_mm:.4g} mm  f/{lens.f_stop:.3g}")
    imgui.same_line()
    if imgui.get_content_region_avail().x < imgui.calc_text_size(words).x:
        imgui.new_line()
    imgui.text_disabled(words)
    rects.note(f"lens of look {look.name}")
    imgui.text_disabled(f"at {texts.measured_label(lens, lens.focus_distance_m, facts.view.unit)}")
    _look_buttons(facts, control, look)
    imgui.end_group()
    imgui.pop_id()
    if name != look.name:
        control.looks.rename(look, name)


def _look_buttons(facts: Facts, control: PictureControl, look: Look) -> None:
    """Draw buttons for the sides of the wipe, the grid, and to delete the look."""
    view = facts.view
    is_compared = is_look_b(view)
    tip = "Show this look on the left of the wipe"
    if toggle_button(
        "wipe left", f"left {look.name}", is_compared and view.a_look == look.name, tip
    ):
        control.looks.compare_as_a(look)
    imgui.same_line(0.0, 4.0)
    tip = "Show this look on the right of the wipe"
    if toggle_button(
        "wipe right", f"wipe {look.name}", is_compared and view.b_look == look.name, tip
    ):
        control.looks.compare(look)
    if len(facts.shot.looks) > GRID_MOST:
        is_in_grid = look.name in grid_names(view, facts.shot)
        tip = "Show this look in the grid"
        if toggle_button("grid", f"in grid {look.name}", is_in_grid, tip):
            control.looks.toggle_in_grid(look)
    imgui.same_line(0.0, 4.0)
    if widgets.button("x", f"delete look {look.name}", "Forget this look"):
        control.looks.delete(look)


def _still_button(texture: Texture | None) -> bool:
    """Draw the thumbnail as a button, or an empty frame if None; return True if it was pressed."""
    em = imgui.get_font_size()
    size = ImVec2(_STILL_EM[0] * em, _STILL_EM[1] * em)
    corner = imgui.get_cursor_screen_pos()
    is_pressed = imgui.invisible_button("still", size)
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    draw = imgui.get_window_draw_list()
    if texture is None:
        draw.add_rect_filled(corner, end, theme.colors.groove, 2.0)
        text = "not seen yet"
        text_size = imgui.calc_text_size(text)
        text_corner = ImVec2(
            corner.x + (size.x - text_size.x) / 2, corner.y + (size.y - text_size.y) / 2
        )
        draw.add_text(text_corner, theme.colors.text_dim, text)
    else:
        draw.add_image(imgui.ImTextureRef(texture.handle), corner, end, ImVec2(0, 1), ImVec2(1, 0))
    return bool(is_pressed)
