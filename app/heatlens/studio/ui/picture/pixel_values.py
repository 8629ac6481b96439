"""Draw over the picture: pixel grid, display window, wipe, ruler, RGB in the pixels.

The ruler has two ends, a line between them, and its length.
"""

import math
from dataclasses import dataclass

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import measured_text
from heatlens.core.model.units import format_distance
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import Compare
from heatlens.core.model.view.view_geometry import PictureShape, Pixel, Viewport
from heatlens.render.display.pixel_reading import read_texels
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.studio.board.controls import PictureControl
from heatlens.studio.board.facts import Facts
from heatlens.studio.ui import rects, theme
from heatlens.studio.ui.picture.grid import Pictures

_GRID_FROM = 8.0  # smallest size of a pixel on the screen, in screen pixels, for the grid


def visible_pixels(picture_view: PictureView, shape: PictureShape) -> tuple[int, int, int, int]:
    """Return the visible pixels, as half-open ranges of columns and rows."""
    (x, y), (width, height) = picture_view.viewport.corner, picture_view.viewport.size
    x0, y0 = picture_view.geometry.pixel_at_window((x, y))
    x1, y1 = picture_view.geometry.pixel_at_window((x + width, y + height))
    return max(x0, 0), max(y0, 0), min(x1 + 1, shape.width_px), min(y1 + 1, shape.height_px)


def draw_pixel_grid(picture_view: PictureView, shape: PictureShape) -> None:
    """Draw the grid in the current window if the pixels are large enough."""
    if picture_view.zoom < _GRID_FROM:
        return
    draw, to_window = imgui.get_window_draw_list(), picture_view.geometry.window_at_picture
    x0, y0, x1, y1 = visible_pixels(picture_view, shape)
    (left, top), (right, bottom) = to_window((x0, y0)), to_window((x1, y1))
    for x in range(x0, x1 + 1):
        line = to_window((x, 0))[0]
        draw.add_line(ImVec2(line, top), ImVec2(line, bottom), theme.OVER_PICTURE.pixel_grid)
    for y in range(y0, y1 + 1):
        line = to_window((0, y))[1]
        draw.add_line(ImVec2(left, line), ImVec2(right, line), theme.OVER_PICTURE.pixel_grid)


def draw_display_window(picture_view: PictureView, pictures: Pictures) -> None:
    """Draw the outline of the display window if the data window differs from it."""
    if pictures.data_window == pictures.display_window:
        return
    window, to_window = pictures.display_window, picture_view.geometry.window_at_picture
    first, last = ImVec2(*to_window((0, 0))), ImVec2(*to_window((window.width, window.height)))
    imgui.get_window_draw_list().add_rect(first, last, theme.OVER_PICTURE.window_line)


def draw_wipe_handle(x: float, viewport: Viewport, names: tuple[str, str]) -> None:
    """Draw the line of the wipe and its grip; `x` is the first column of B, in screen units."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    (_, y), (_, height) = viewport.corner, viewport.size
    middle_y, width = y + height / 2, 1.0 / viewport.framebuffer_scale
    draw.add_rect_filled(ImVec2(x, y), ImVec2(x + width, y + height), theme.OVER_PICTURE.handle)
    draw.add_circle_filled(ImVec2(x, middle_y), 0.55 * em, theme.OVER_PICTURE.shadow)
    draw.add_circle(ImVec2(x, middle_y), 0.55 * em, theme.OVER_PICTURE.handle)
    top, gap = y + 0.4 * em, 0.6 * em
    left = x - gap - imgui.calc_text_size(names[0]).x
    draw.add_text(ImVec2(left, top), theme.OVER_PICTURE.handle, names[0])
    draw.add_text(ImVec2(x + gap, top), theme.OVER_PICTURE.handle, names[1])


VALUES_FROM_EM = 2.6  # smallest size of a pixel on the screen that fits three lines of text
_HEIGHT_EM, _WIDTH_EM = 3.9, 3.1  # height and width of a pixel, divided by the font size
_MAX_PIXELS = 2000  # largest number of pixels to label; more would make the window slow
_LUMA = np.array([0.2126, 0.7152, 0.0722])
_DARK_TEXT_FROM = 0.45  # display luminance above which dark text is more readable


@dataclass(frozen=True, eq=False)
class _Texts:
    """The texts of a block of pixels."""

    key: object
    words: list[list[str]]


class PixelValues:
    """Draws the values; reads them from the GPU only when the picture or the view has changed."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._texts = _Texts(None, [])

    def draw(
        self,
        light: Texture | None,
        display_texture: Texture,
        pictures: Pictures,
        picture_view: PictureView,
    ) -> int:
        """Draw the values in the current window; return the number of labeled pixels.

        `light` is the scene-linear texture of a side, `display_texture` the same with the view
        transform.
        """
        em, per_px = imgui.get_font_size(), picture_view.geometry.per_px
        if light is None or min(per_px) < VALUES_FROM_EM * em:
            return 0
        box = _visible_box(pictures, picture_view)
        if box.is_empty or box.width * box.height > _MAX_PIXELS:
            return 0
        texts = self._texts_of(light, pictures.light_version, box)
        colors = read_texels(self._ctx, display_texture, box, "f1").astype(np.float64) / 255
        size = min(per_px[1] / _HEIGHT_EM, per_px[0] / _WIDTH_EM)
        _write_values(
            texts, colors[..., :3] @ _LUMA > _DARK_TEXT_FROM, box, pictures, picture_view, size
        )
        return box.width * box.height

    def _texts_of(self, light: Texture, version: object, box: Box) -> list[list[str]]:
        """Return the RGB texts of the pixels in `box`, in rows; read again if something changed."""
        key = (light, version, box)
        if self._texts.key != key:
            values = read_texels(self._ctx, light, box, "f4")
            self._texts = _Texts(
                key,
                [
                    ["\n".join(map(value_words, pixel[:3].tolist())) for pixel in row]
                    for row in values
                ],
            )
        return self._texts.words


class SideValues:
    """Draws the values of A, of B, or of each on its side of the wipe."""

    def __init__(self, ctx: Device) -> None:
        self.sides = PixelValues(ctx), PixelValues(ctx)

    def draw(
        self, pictures: Pictures, compare: Compare, line: float, picture_view: PictureView
    ) -> None:
        """Draw the values in the current window; `line` is the x of the wipe in screen units."""
        (x, y), (width, height) = picture_view.viewport.corner, picture_view.viewport.size
        ends = {Compare.OFF: x + width, Compare.WIPE: line, Compare.FLIP: x}
        if compare not in ends:
            return
        boundary, draw = ends[compare], imgui.get_window_draw_list()
        left = (pictures.light_a, pictures.a, x, boundary)
        right = (pictures.light_b, pictures.b, boundary, x + width)
        for values, (light, display_texture, x0, x1) in zip(self.sides, (left, right), strict=True):
            if x0 < x1:
                draw.push_clip_rect(ImVec2(x0, y), ImVec2(x1, y + height), True)
                values.draw(light, display_texture, pictures, picture_view)
                draw.pop_clip_rect()


def _visible_box(pictures: Pictures, picture_view: PictureView) -> Box:
    """Return the visible pixels of the data window, relative to its corner."""
    data = pictures.data_window.relative_to(pictures.display_window)
    visible = Box(*visible_pixels(picture_view, pictures.shape))
    return visible.intersection(data).relative_to(data)


def _write_values(
    texts: list[list[str]],
    is_bright: NDArray[np.bool_],
    box: Box,
    pictures: Pictures,
    picture_view: PictureView,
    size: float,
) -> None:
    """Write the texts into the pixels of `box`, dark on bright pixels, with font size `size`."""
    draw, font = imgui.get_window_draw_list(), imgui.get_font()
    dark_ink = theme.pack_color(theme.DARK_INK)
    light_ink = theme.pack_color(theme.LIGHT_INK)
    data = pictures.data_window.relative_to(pictures.display_window)
    per_px = picture_view.geometry.per_px
    origin = picture_view.geometry.window_at_picture((box.x0 + data.x0, box.y0 + data.y0))
    inset = per_px[0] * 0.06, (per_px[1] - 3.0 * size) / 2
    for row, words in enumerate(texts):
        y = origin[1] + row * per_px[1] + inset[1]
        for column, text in enumerate(words):
            text_corner = ImVec2(origin[0] + column * per_px[0] + inset[0], y)
            draw.add_text(
                font, size, text_corner, dark_ink if is_bright[row, column] else light_ink, text
            )


def value_words(value: float) -> str:
    """Format a value in about five characters: "0.184", "12.50", "4e+03"."""
    size = abs(value)
    if size < 9.9995:
        return f"{value:.3f}"
    return f"{value:.2f}" if size < 99.995 else f"{value:.1f}" if size < 999.95 else f"{value:.0e}"


_END_EM, _LINE_EM = 0.3, 0.13
_HINT = "Ruler: click two points, or drag from one to the other. Escape ends it."


def draw_ruler(control: PictureControl, facts: Facts, hovered: Pixel | None) -> None:
    """Draw the ruler in the current window; with one end set it follows the pointer."""
    ruler, view = control.commands.ruler, control.view
    if not ruler.is_on:
        return
    _draw_hint(view)
    ends = _ruler_ends(control, hovered)
    end_points = [ImVec2(*view.geometry.window_at_picture((x + 0.5, y + 0.5))) for x, y in ends]
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    if len(end_points) == 2:
        draw.add_line(end_points[0], end_points[1], theme.OVER_PICTURE.shadow, 2.0 * _LINE_EM * em)
        draw.add_line(end_points[0], end_points[1], theme.OVER_PICTURE.handle, _LINE_EM * em)
    for point in end_points:
        draw.add_circle_filled(point, _END_EM * em, theme.OVER_PICTURE.shadow)
        draw.add_circle(point, _END_EM * em, theme.OVER_PICTURE.handle, 0, _LINE_EM * em)
    measurement = ruler.measure(hovered) if len(end_points) == 2 else None
    if measurement is None:
        return
    unit = facts.unit
    is_far = math.isinf(measurement.distance_m) or math.isnan(measurement.distance_m)
    words = "infinitely far" if is_far else format_distance(measurement.distance_m, unit)
    for point, depth_m in zip(end_points, measurement.depths_m, strict=True):
        _draw_label(
            point, f"at {measured_text(facts.lens, depth_m, unit)}", theme.OVER_PICTURE.handle, 1.2
        )
    _draw_label(
        ImVec2((end_points[0].x + end_points[1].x) / 2, (end_points[0].y + end_points[1].y) / 2),
        words,
        theme.OVER_PICTURE.handle,
        -1.2,
    )
    rects.note_at(
        f"ruler {words}", (end_points[0].x, end_points[0].y, end_points[1].x, end_points[1].y)
    )


def _draw_hint(picture_view: PictureView) -> None:
    """Draw the hint about the mouse at the upper edge of the viewport."""
    viewport, em = picture_view.viewport, imgui.get_font_size()
    (x, y), (width, _) = viewport.corner, viewport.size
    _draw_label(ImVec2(x + width / 2, y + em), _HINT, theme.OVER_PICTURE.handle, 0.3)


def _ruler_ends(control: PictureControl, hovered: Pixel | None) -> tuple[Pixel, ...]:
    """Return the ends of the ruler, with the pixel under the pointer as the second one."""
    ruler = control.commands.ruler
    if len(ruler.points) != 1 or hovered is None or not ruler.is_inside(hovered):
        return ruler.points  # a line to a point beside the picture would have no length
    return (*ruler.points, hovered)


def _draw_label(point: ImVec2, words: str, color: int, below_em: float) -> None:
    """Draw text on a dark background, `below_em` em below a point."""
    em, text_size = imgui.get_font_size(), imgui.calc_text_size(words)
    corner = ImVec2(point.x - text_size.x / 2, point.y + below_em * em - text_size.y / 2)
    draw = imgui.get_window_draw_list()
    first = ImVec2(corner.x - 0.3 * em, corner.y - 0.1 * em)
    last = ImVec2(corner.x + text_size.x + 0.3 * em, corner.y + text_size.y + 0.1 * em)
    draw.add_rect_filled(first, last, theme.OVER_PICTURE.shadow, 3.0)
    draw.add_text(corner, color, words)
