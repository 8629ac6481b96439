"""Draw the loupe: the pinhole picture under the pointer, enlarged, with the surfaces there.

For a mark's flag on the focus bar under the pointer, the loupe shows the position of the mark.
"""

from collections.abc import Callable, Sequence

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import measured_text
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view_geometry import Point
from heatlens.media.plate.coc_line import Surface
from heatlens.render.display.picture_pass import PlacedPicture
from heatlens.render.gpu.resources import Texture
from heatlens.studio.board.facts import Facts
from heatlens.studio.ui import rects, theme
from heatlens.studio.ui.picture.grid import Pictures

Pixel = tuple[int, int]
FindSurfaces = Callable[[Pixel], Sequence[Surface]]
NamesOf = Callable[[Sequence[Surface]], Sequence[str]]
MAGNIFICATION = 2.0  # scale of the loupe, relative to the picture
_SIDE_EM, _FLAG_SIDE_EM = 11.0, 7.0
_POINTER_GAP_EM = 1.5  # gap to the pointer, because the loupe must not cover what is pointed at
_CROSS_EM = 0.4
_SAME_RATIO = 1.02  # a mark as near as this to a surface names it


class Loupe:
    """Draws the loupe beside the pointer.

    `find_surfaces` returns the surfaces at a pixel, `names_of` the names of their mattes.
    """

    def __init__(self, find_surfaces: FindSurfaces, names_of: NamesOf) -> None:
        self._find_surfaces, self._names_of = find_surfaces, names_of

    def draw(
        self,
        facts: Facts,
        picture_view: PictureView,
        pictures: Pictures,
        pinhole: Texture,
        pixel: Pixel,
    ) -> PlacedPicture | None:
        """Draw frame and words; return the picture inside, or None where there is no surface."""
        surfaces = self._find_surfaces(pixel)
        if not surfaces:
            return None
        mouse = imgui.get_mouse_pos()
        corner = _loupe_corner(picture_view, (mouse.x, mouse.y))
        side = _SIDE_EM * imgui.get_font_size()
        end = corner[0] + side, corner[1] + side
        center = corner[0] + side / 2, corner[1] + side / 2
        _draw_frame(corner, end, center)
        _draw_lines(_surface_lines(facts, surfaces, self._names_of(surfaces)), (corner[0], end[1]))
        rects.note_at("loupe", (*corner, *end))
        return _place_enlarged(
            picture_view, pictures, pinhole, (mouse.x, mouse.y), center, (*corner, *end)
        )


def draw_flag_loupe(
    picture_view: PictureView, pictures: Pictures, pinhole: Texture, mark_point: Point
) -> PlacedPicture:
    """Draw the loupe of a mark over the focus bar, centered above the pointer.

    `mark_point` is the point of the mark in the window.
    """
    side = _FLAG_SIDE_EM * imgui.get_font_size()
    (x0, y0), (width, height) = picture_view.viewport.corner, picture_view.viewport.size
    x = min(max(imgui.get_mouse_pos().x - side / 2, x0), x0 + width - side)
    corner = x, y0 + height - side
    end, center = (x + side, y0 + height), (x + side / 2, y0 + height - side / 2)
    _draw_frame(corner, end, center)
    rects.note_at("place of the mark", (*corner, *end))
    return _place_enlarged(picture_view, pictures, pinhole, mark_point, center, (*corner, *end))


def _loupe_corner(picture_view: PictureView, pointer: Point) -> Point:
    """Return the upper left corner of the loupe: at the upper right of the pointer if it fits."""
    em = imgui.get_font_size()
    side, gap = _SIDE_EM * em, _POINTER_GAP_EM * em
    words_height = 2 * imgui.get_text_line_height_with_spacing()
    (x0, y0), (width, height) = picture_view.viewport.corner, picture_view.viewport.size
    fits_right = pointer[0] + gap + side <= x0 + width
    fits_above = pointer[1] - gap - side - words_height >= y0
    x = pointer[0] + gap if fits_right else pointer[0] - gap - side
    y = pointer[1] - gap - side - words_height if fits_above else pointer[1] + gap
    return max(x, x0), min(y, y0 + height - side - words_height)


def _place_enlarged(
    picture_view: PictureView,
    pictures: Pictures,
    pinhole: Texture,
    shown_point: Point,
    loupe_center: Point,
    rect: tuple[float, float, float, float],
) -> PlacedPicture:
    """Place the enlarged pinhole picture with `shown_point` in the middle of the loupe."""
    scale = picture_view.viewport.framebuffer_scale
    to_window = picture_view.geometry.window_at_picture
    data, display = pictures.data_window, pictures.display_window
    picture_center = to_window(pictures.shape.middle_px)

    def at(column: int, row: int) -> Point:
        """Return where a pixel of the frame lies in the target, in screen pixels."""
        point = to_window((column - display.x0, row - display.y0))
        x, y = (
            center + (value - center) / pictures.frame_ratio
            for value, center in zip(point, picture_center, strict=True)
        )
        return (
            scale * (loupe_center[0] + MAGNIFICATION * (x - shown_point[0])),
            scale * (loupe_center[1] + MAGNIFICATION * (y - shown_point[1])),
        )

    clip = Box(*(round(scale * side) for side in rect))
    return PlacedPicture(
        pinhole, at(data.x0, data.y0), at(data.x1, data.y1), clip, is_nearest=False, is_opaque=True
    )


def _draw_frame(corner: Point, end: Point, center: Point) -> None:
    """Draw the frame of the loupe with a cross in its middle."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    shadow = theme.OVER_PICTURE.shadow
    draw.add_rect(ImVec2(*corner), ImVec2(*end), shadow, thickness=0.3 * em)
    draw.add_rect(ImVec2(*corner), ImVec2(*end), theme.OVER_PICTURE.handle)
    for across, down in ((_CROSS_EM * em, 0.0), (0.0, _CROSS_EM * em)):
        first = ImVec2(center[0] - across, center[1] - down)
        last = ImVec2(center[0] + across, center[1] + down)
        draw.add_line(first, last, theme.OVER_PICTURE.handle)


def _surface_lines(facts: Facts, surfaces: Sequence[Surface], names: Sequence[str]) -> list[str]:
    """Return a line for the surface that a click focuses on, and one for the other surface."""
    lines = [
        _surface_words(facts, *surface_and_name)
        for surface_and_name in zip(surfaces, names, strict=True)
    ]
    return [lines[0], *(f"Y: {words}" for words in lines[1:])]


def _surface_words(facts: Facts, surface: Surface, matte_name: str) -> str:
    """Return the distance of a surface, with the name of a mark there or of its matte."""
    nearest_m, farthest_m = surface.depth_m / _SAME_RATIO, surface.depth_m * _SAME_RATIO
    names = [name for name, distance_m in facts.marks_m if nearest_m < distance_m < farthest_m]
    distance = measured_text(facts.lens, surface.depth_m, facts.unit)
    return printable(f"{(names or [matte_name])[0]} {distance}".strip())


def _draw_lines(lines: Sequence[str], corner: Point) -> None:
    """Draw lines on a dark background, the first one brighter."""
    draw, height = imgui.get_window_draw_list(), imgui.get_text_line_height_with_spacing()
    padding = 0.3 * imgui.get_font_size()
    width = max(imgui.calc_text_size(line).x for line in lines) + 2 * padding
    end = ImVec2(corner[0] + width, corner[1] + len(lines) * height)
    draw.add_rect_filled(ImVec2(*corner), end, theme.pack_color((0.0, 0.0, 0.0, 0.85)))
    colors = theme.OVER_PICTURE.handle, theme.OVER_PICTURE.text_dim
    for number, line in enumerate(lines):
        text_corner = ImVec2(corner[0] + padding, corner[1] + number * height)
        draw.add_text(text_corner, colors[min(number, 1)], line)
        rects.note_at(
            f"loupe {line}", (text_corner.x, text_corner.y, end.x, text_corner.y + height)
        )
