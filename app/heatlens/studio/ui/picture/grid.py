"""Lay out and label the grid of looks: up to four pictures of one frame beside each other.

`Pictures` is the set of display-ready textures that the viewport draws.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.view_geometry import PictureShape, Point, Viewport
from heatlens.render.display.picture_pass import Detail
from heatlens.render.gpu.resources import Texture
from heatlens.studio.ui import rects, theme

_GAP_EM, _FRAME_EM = 0.15, 0.13


@dataclass(frozen=True, eq=False)
class Tile:
    """A picture of the grid.

    name      name of the look, "" for the current lens
    words     the label under it
    texture   display values; None before there is a picture
    is_proxy  whether the texture is smaller than the plate
    is_current_lens  whether its lens is that of the shot
    """

    name: str
    words: str
    texture: Texture | None
    is_proxy: bool
    is_current_lens: bool


def cells(whole: Viewport, count: int) -> list[Viewport]:
    """Return the cells for `count` pictures: the whole viewport, two columns, or 2 x 2."""
    column_count, row_count = (1 if count < 2 else 2), (1 if count < 3 else 2)
    (x, y), (width, height) = whole.corner, whole.size
    gap, scale = _GAP_EM * imgui.get_font_size(), whole.framebuffer_scale
    size = (
        (width - gap * (column_count - 1)) / column_count,
        (height - gap * (row_count - 1)) / row_count,
    )
    corners = [
        (
            round((x + column * (size[0] + gap)) * scale) / scale,
            round((y + row * (size[1] + gap)) * scale) / scale,
        )
        for row in range(row_count)
        for column in range(column_count)
    ]
    return [Viewport(corner, size, scale) for corner in corners[: max(count, 1)]]


def cell_at(viewports: Sequence[Viewport], point: Point) -> int | None:
    """Return the index of the cell at a window position; None outside of all."""
    for index, viewport in enumerate(viewports):
        (x, y), (width, height) = viewport.corner, viewport.size
        if x <= point[0] < x + width and y <= point[1] < y + height:
            return index
    return None


def draw_tiles(tiles: Sequence[Tile], viewports: Sequence[Viewport], hovered: int | None) -> None:
    """Draw labels and outlines over the pictures, in the current window."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    for index, (tile, viewport) in enumerate(zip(tiles, viewports, strict=True)):
        (x, y), (width, height) = viewport.corner, viewport.size
        corner, end = ImVec2(x, y), ImVec2(x + width, y + height)
        rects.note_at(f"grid {tile.name or 'now'}", (corner.x, corner.y, end.x, end.y))
        draw.push_clip_rect(corner, end, True)
        text_size = imgui.calc_text_size(tile.words)
        text_corner = ImVec2(x + 0.9 * em, end.y - text_size.y - 0.8 * em)
        pad = ImVec2(0.4 * em, 0.2 * em)
        box = (
            ImVec2(text_corner.x - pad.x, text_corner.y - pad.y),
            ImVec2(text_corner.x + text_size.x + pad.x, text_corner.y + text_size.y + pad.y),
        )
        draw.add_rect_filled(*box, theme.OVER_PICTURE.shadow, 3.0)
        draw.add_text(text_corner, theme.OVER_PICTURE.handle, tile.words)
        if tile.is_current_lens or index == hovered:
            color = theme.OVER_PICTURE.accent if tile.is_current_lens else theme.OVER_PICTURE.handle
            draw.add_rect(
                ImVec2(corner.x + 1, corner.y + 1),
                ImVec2(end.x - 1, end.y - 1),
                color,
                0.0,
                _FRAME_EM * em,
            )
        draw.pop_clip_rect()


@dataclass(frozen=True, eq=False)
class Pictures:
    """The textures that the viewport draws, and facts about them."""

    a: Texture
    b: Texture
    detail: Detail | None  # sharpens A while it is a preview
    overlay: Texture | None
    data_window: Box
    display_window: Box
    pixel_aspect: float
    is_proxy: bool  # A has fewer pixels than the plate
    is_b_proxy: bool = False  # B has fewer pixels than the plate
    has_camera: bool = False  # the right mouse button moves the camera of a scene
    has_mipmaps: bool = True  # the textures have mipmaps for drawing them small
    frame_ratio: float = 1.0  # share of the plate's width in view, below 1 if the lens breathes
    is_a_frame: bool = False  # A is the whole plate, still to be cropped by `frame_ratio`
    is_b_frame: bool = False
    light_a: Texture | None = None  # scene-linear values of A; None if not available
    light_b: Texture | None = None
    light_version: object = None  # changes with the scene-linear values
    tiles: tuple[Tile, ...] = ()  # the grid, shown instead of A and B
    names: tuple[str, str] = ("A", "B")  # labels of the two sides of the wipe

    @property
    def shape(self) -> PictureShape:
        """Size and pixel aspect of the display window."""
        window = self.display_window
        return PictureShape(window.width, window.height, self.pixel_aspect)
