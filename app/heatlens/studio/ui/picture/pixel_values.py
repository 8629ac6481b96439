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
from heatlens.core.model.view.view import Compare
from heatlens.core.model.view.view_geometry import PictureShape, Viewport
from heatlens.render.display.probe import read_texels
from heatlens.render.gpu.device import Device, Texture
from heatlens.studio.session.facts import Facts
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.session.pictures.ruler import Pixel, Ruler
from heatlens.studio.ui import probe, theme
from heatlens.studio.ui.picture.grid import Pictures

_GRID_FROM = 8.0  # smallest size of a pixel on the screen, in screen pixels, for the grid


def seen_pixels(place: PictureView, shape: PictureShape) -> tuple[int, int, int, int]:
    """Return the visible pixels, as half-open ranges of columns and rows."""
    (x, y), (width, height) = place.viewport.corner, place.viewport.size
    x0, y0 = place.geometry.pixel_at_window((x, y))
    x1, y1 = place.geometry.pixel_at_window((x + width, y + height))
    return max(x0, 0), max(y0, 0), min(x1 + 1, shape.width_px), min(y1 + 1, shape.height_px)


def draw_pixel_grid(place: PictureView, shape: PictureShape) -> None:
    """Draw the grid in the current window if the pixels are large enough."""
    if place.zoom < _GRID_FROM:
        return
    draw, at = imgui.get_window_draw_list(), place.geometry.window_at_picture
    x0, y0, x1, y1 = seen_pixels(place, shape)
    (left, top), (right, bottom) = at((x0, y0)), at((x1, y1))
    for x in range(x0, x1 + 1):
        line = at((x, 0))[0]
        draw.add_line(ImVec2(line, top), ImVec2(line, bottom), theme.OVER_PICTURE.pixel_grid)
    for y in range(y0, y1 + 1):
        line = at((0, y))[1]
        draw.add_line(ImVec2(left, line), ImVec2(right, line), theme.OVER_PICTURE.pixel_grid)


def draw_display_window(place: PictureView, pictures: Pictures) -> None:
    """Draw the outline of the display window if the data window differs from it."""
    if pictures.data_window == pictures.display_window:
        return
    window, at = pictures.display_window, place.geometry.window_at_picture
    first, last = ImVec2(*at((0, 0))), ImVec2(*at((window.width, window.height)))
    imgui.get_window_draw_list().add_rect(first, last, theme.OVER_PICTURE.window_line)


def draw_wipe_handle(x: float, place: Viewport, names: tuple[str, str]) -> None:
    """Draw the line of the wipe and its grip; `x` is the first column of B, in screen units."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    (_, y), (_, height) = place.corner, place.size
    middle, width = y + height / 2, 1.0 / place.framebuffer_scale
    draw.add_rect_filled(ImVec2(x, y), ImVec2(x + width, y + height), theme.OVER_PICTURE.handle)
    draw.add_circle_filled(ImVec2(x, middle), 0.55 * em, theme.OVER_PICTURE.shadow)
    draw.add_circle(ImVec2(x, middle), 0.55 * em, theme.OVER_PICTURE.handle)
    top, gap = y + 0.4 * em, 0.6 * em
    left = x - gap - imgui.calc_text_size(names[0]).x
    draw.add_text(ImVec2(left, top), theme.OVER_PICTURE.handle, names[0])
    draw.add_text(ImVec2(x + gap, top), theme.OVER_PICTURE.handle, names[1])


VALUES_FROM_EM = 2.6  # smallest size of a pixel on the screen that fits three lines of text
_LINES, _LETTERS = 3.9, 3.1  # height and width of a pixel, divided by the font size
_MOST = 2000  # largest number of pixels to label; more would make the window slow
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
        shown: Texture,
        pictures: Pictures,
        place: PictureView,
    ) -> int:
        """Draw the values in the current window; return the number of labelled pixels.

        `light` is the scene-linear texture of a side, `shown` the same with the view transform.
        """
        em, per_px = imgui.get_font_size(), place.geometry.per_px
        if light is None or min(per_px) < VALUES_FROM_EM * em:
            return 0
        box = _seen_box(pictures, place)
        if box.is_empty or box.width * box.height > _MOST:
            return 0
        texts = self._texts_of(light, pictures.light_version, box)
        colors = read_texels(self._ctx, shown, box, "f1").astype(np.float64) / 255
        size = min(per_px[1] / _LINES, per_px[0] / _LETTERS)
        _write(texts, colors[..., :3] @ _LUMA > _DARK_TEXT_FROM, box, pictures, place, size)
        return box.width * box.height

    def _texts_of(self, light: Texture, version: object, box: Box) -> list[list[str]]:
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

    def draw(self, pictures: Pictures, compare: Compare, line: float, place: PictureView) -> None:
        """Draw the values in the current window; `line` is the x of the wipe in screen units."""
        (x, y), (width, height) = place.viewport.corner, place.viewport.size
        ends = {Compare.OFF: x + width, Compare.WIPE: line, Compare.FLIP: x}
        if compare not in ends:
            return
        end, draw = ends[compare], imgui.get_window_draw_list()
        left = (pictures.light_a, pictures.a, x, end)
        right = (pictures.light_b, pictures.b, end, x + width)
        for values, (light, shown, x0, x1) in zip(self.sides, (left, right), strict=True):
            if x0 < x1:
                draw.push_clip_rect(ImVec2(x0, y), ImVec2(x1, y + height), True)
                values.draw(light, shown, pictures, place)
                draw.pop_clip_rect()


def _seen_box(pictures: Pictures, place: PictureView) -> Box:
    """Return the visible pixels of the data window, relative to its corner."""
    data, display = pictures.data_window, pictures.display_window
    x0, y0, x1, y1 = seen_pixels(place, pictures.shape)
    aside, below = display.x0 - data.x0, display.y0 - data.y0
    return Box(
        max(x0 + aside, 0),
        max(y0 + below, 0),
        min(x1 + aside, data.width),
        min(y1 + below, data.height),
    )


def _write(
    texts: list[list[str]],
    is_bright: NDArray[np.bool_],
    box: Box,
    pictures: Pictures,
    place: PictureView,
    size: float,
) -> None:
    draw, font = imgui.get_window_draw_list(), imgui.get_font()
    dark = theme.packed(theme.DARK_INK)
    light = theme.packed(theme.LIGHT_INK)
    data, display, per_px = pictures.data_window, pictures.display_window, place.geometry.per_px
    origin = place.geometry.window_at_picture(
        (box.x0 + data.x0 - display.x0, box.y0 + data.y0 - display.y0)
    )
    inset = per_px[0] * 0.06, (per_px[1] - 3.0 * size) / 2
    for row, words in enumerate(texts):
        y = origin[1] + row * per_px[1] + inset[1]
        for column, text in enumerate(words):
            at = ImVec2(origin[0] + column * per_px[0] + inset[0], y)
            draw.add_text(font, size, at, dark if is_bright[row, column] else light, text)


def value_words(value: float) -> str:
    """Format a value in about five characters: "0.184", "12.50", "4e+03"."""
    size = abs(value)
    if size < 9.9995:
        return f"{value:.3f}"
    return f"{value:.2f}" if size < 99.995 else f"{value:.1f}" if size < 999.95 else f"{value:.0e}"


_END_EM, _LINE_EM = 0.3, 0.13
_HINT = "Ruler: click two points, or drag from one to the other. Escape ends it."


def draw_ruler(ruler: Ruler, view: PictureView, facts: Facts, hovered: Pixel | None) -> None:
    """Draw the ruler in the current window; with one end set it follows the pointer."""
    if not ruler.is_on:
        return
    _draw_hint(view)
    ends = _ends(ruler, hovered)
    at = [ImVec2(*view.geometry.window_at_picture((x + 0.5, y + 0.5))) for x, y in ends]
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    if len(at) == 2:
        draw.add_line(at[0], at[1], theme.OVER_PICTURE.shadow, 2.0 * _LINE_EM * em)
        draw.add_line(at[0], at[1], theme.OVER_PICTURE.handle, _LINE_EM * em)
    for end in at:
        draw.add_circle_filled(end, _END_EM * em, theme.OVER_PICTURE.shadow)
        draw.add_circle(end, _END_EM * em, theme.OVER_PICTURE.handle, 0, _LINE_EM * em)
    measured = ruler.measured(hovered) if len(at) == 2 else None
    if measured is None:
        return
    unit = facts.unit
    is_far = math.isinf(measured.distance_m) or math.isnan(measured.distance_m)
    words = "infinitely far" if is_far else format_distance(measured.distance_m, unit)
    for end, depth_m in zip(at, measured.depths_m, strict=True):
        _draw_label(
            end, f"at {measured_text(facts.lens, depth_m, unit)}", theme.OVER_PICTURE.handle, 1.2
        )
    _draw_label(
        ImVec2((at[0].x + at[1].x) / 2, (at[0].y + at[1].y) / 2),
        words,
        theme.OVER_PICTURE.handle,
        -1.2,
    )
    probe.note_at(f"ruler {words}", (at[0].x, at[0].y, at[1].x, at[1].y))


def _draw_hint(place: PictureView) -> None:
    """Draw at the upper edge of the viewport what the mouse does now."""
    viewport, em = place.viewport, imgui.get_font_size()
    (x, y), (width, _) = viewport.corner, viewport.size
    _draw_label(ImVec2(x + width / 2, y + em), _HINT, theme.OVER_PICTURE.handle, 0.3)


def _ends(ruler: Ruler, hovered: Pixel | None) -> tuple[Pixel, ...]:
    if len(ruler.points) != 1 or hovered is None or not ruler.is_inside(hovered):
        return ruler.points  # a line to a place beside the picture would have no length
    return (*ruler.points, hovered)


def _draw_label(at: ImVec2, words: str, color: int, below_em: float) -> None:
    """Draw text on a dark background, so many em below a point."""
    em, wide = imgui.get_font_size(), imgui.calc_text_size(words)
    corner = ImVec2(at.x - wide.x / 2, at.y + below_em * em - wide.y / 2)
    draw = imgui.get_window_draw_list()
    first = ImVec2(corner.x - 0.3 * em, corner.y - 0.1 * em)
    last = ImVec2(corner.x + wide.x + 0.3 * em, corner.y + wide.y + 0.1 * em)
    draw.add_rect_filled(first, last, theme.OVER_PICTURE.shadow, 3.0)
    draw.add_text(corner, color, words)
