"""Draw the loupe: the pinhole picture under the pointer, enlarged, with what a click would take.

The flags of marks on the focus bar show the places of their marks with it too.
"""

from collections.abc import Callable, Sequence

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import measured_text
from heatlens.core.model.view.view_geometry import Point
from heatlens.media.plate.coc_line import Surface
from heatlens.render.display.picture_pass import PlacedPicture
from heatlens.render.gpu.device import Texture
from heatlens.studio.session.facts import Facts
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.ui import probe, theme
from heatlens.studio.ui.picture.grid import Pictures

Pixel = tuple[int, int]
LookAt = Callable[[Pixel], Sequence[Surface]]
NamesOf = Callable[[Sequence[Surface]], Sequence[str]]
TIMES = 2.0  # larger than the picture
_SIDE_EM, _FLAG_SIDE_EM = 11.0, 7.0
_AWAY_EM = 1.5  # from the pointer, which must not cover what it points at
_CROSS_EM = 0.4
_SAME_RATIO = 1.02  # a mark as near as this to a surface names it


class Loupe:
    """Draws the loupe beside the pointer.

    `look_at` returns what is seen at a pixel, `names_of` what mattes call that.
    """

    def __init__(self, look_at: LookAt, names_of: NamesOf) -> None:
        self._look_at, self._names_of = look_at, names_of

    def draw(
        self,
        facts: Facts,
        place: PictureView,
        pictures: Pictures,
        pinhole: Texture,
        pixel: Pixel,
    ) -> PlacedPicture | None:
        """Draw frame and words; return the picture inside. None where nothing is to be seen."""
        surfaces = self._look_at(pixel)
        if not surfaces:
            return None
        mouse = imgui.get_mouse_pos()
        corner, side = _corner(place, (mouse.x, mouse.y)), _SIDE_EM * imgui.get_font_size()
        end = corner[0] + side, corner[1] + side
        middle = corner[0] + side / 2, corner[1] + side / 2
        _draw_frame(corner, end, middle)
        _draw_words(_words(facts, surfaces, self._names_of(surfaces)), (corner[0], end[1]))
        probe.note_at("loupe", (*corner, *end))
        return _enlarged(place, pictures, pinhole, (mouse.x, mouse.y), middle, (*corner, *end))


def over_flag(
    place: PictureView, pictures: Pictures, pinhole: Texture, mark: Point
) -> PlacedPicture:
    """Draw the surroundings of a mark over the focus bar, in the middle above the pointer.

    `mark`: the point of the mark in the window.
    """
    side = _FLAG_SIDE_EM * imgui.get_font_size()
    (x0, y0), (width, height) = place.viewport.corner, place.viewport.size
    x = min(max(imgui.get_mouse_pos().x - side / 2, x0), x0 + width - side)
    corner = x, y0 + height - side
    end, middle = (x + side, y0 + height), (x + side / 2, y0 + height - side / 2)
    _draw_frame(corner, end, middle)
    probe.note_at("place of the mark", (*corner, *end))
    return _enlarged(place, pictures, pinhole, mark, middle, (*corner, *end))


def _corner(place: PictureView, pointer: Point) -> Point:
    """Return the upper left corner of the loupe: right above the pointer if there is room."""
    em = imgui.get_font_size()
    side, away = _SIDE_EM * em, _AWAY_EM * em
    words = 2 * imgui.get_text_line_height_with_spacing()
    (x0, y0), (width, height) = place.viewport.corner, place.viewport.size
    fits_right = pointer[0] + away + side <= x0 + width
    fits_above = pointer[1] - away - side - words >= y0
    x = pointer[0] + away if fits_right else pointer[0] - away - side
    y = pointer[1] - away - side - words if fits_above else pointer[1] + away
    return max(x, x0), min(y, y0 + height - side - words)


def _enlarged(
    place: PictureView,
    pictures: Pictures,
    pinhole: Texture,
    pointer: Point,
    middle: Point,
    rect: tuple[float, float, float, float],
) -> PlacedPicture:
    """Place the pinhole picture so that what is under the pointer is in the middle of the loupe."""
    scale, whole = place.viewport.framebuffer_scale, place.geometry.window_at_picture
    data, display = pictures.data_window, pictures.display_window
    centre = whole(pictures.shape.middle_px)

    def at(column: int, row: int) -> Point:
        seen = whole((column - display.x0, row - display.y0))
        x, y = (c + (p - c) / pictures.frame_ratio for p, c in zip(seen, centre, strict=True))
        return (
            scale * (middle[0] + TIMES * (x - pointer[0])),
            scale * (middle[1] + TIMES * (y - pointer[1])),
        )

    clip = Box(*(round(scale * side) for side in rect))
    return PlacedPicture(pinhole, at(data.x0, data.y0), at(data.x1, data.y1), clip, False, True)


def _draw_frame(corner: Point, end: Point, middle: Point) -> None:
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    edge = theme.OVER_PICTURE.shadow
    draw.add_rect(ImVec2(*corner), ImVec2(*end), edge, thickness=0.3 * em)
    draw.add_rect(ImVec2(*corner), ImVec2(*end), theme.OVER_PICTURE.handle)
    for across, down in ((_CROSS_EM * em, 0.0), (0.0, _CROSS_EM * em)):
        first = ImVec2(middle[0] - across, middle[1] - down)
        last = ImVec2(middle[0] + across, middle[1] + down)
        draw.add_line(first, last, theme.OVER_PICTURE.handle)


def _words(facts: Facts, surfaces: Sequence[Surface], names: Sequence[str]) -> list[str]:
    """Return a line for what a click takes, and one for the other surface."""
    lines = [_named(facts, *it) for it in zip(surfaces, names, strict=True)]
    return [lines[0], *(f"Y: {words}" for words in lines[1:])]


def _named(facts: Facts, surface: Surface, thing: str) -> str:
    """Return the distance of a surface, with the name of a mark that is there, or of its matte."""
    low, high = surface.depth_m / _SAME_RATIO, surface.depth_m * _SAME_RATIO
    names = [name for name, distance_m in facts.marks_m if low < distance_m < high]
    distance = measured_text(facts.lens, surface.depth_m, facts.unit)
    return printable(f"{(names or [thing])[0]} {distance}".strip())


def _draw_words(lines: Sequence[str], corner: Point) -> None:
    """Draw lines on a dark background; the first is what a click takes."""
    draw, height = imgui.get_window_draw_list(), imgui.get_text_line_height_with_spacing()
    pad = 0.3 * imgui.get_font_size()
    width = max(imgui.calc_text_size(line).x for line in lines) + 2 * pad
    end = ImVec2(corner[0] + width, corner[1] + len(lines) * height)
    draw.add_rect_filled(ImVec2(*corner), end, theme.packed((0.0, 0.0, 0.0, 0.85)))
    colors = theme.OVER_PICTURE.handle, theme.OVER_PICTURE.text_dim
    for number, line in enumerate(lines):
        at = ImVec2(corner[0] + pad, corner[1] + number * height)
        draw.add_text(at, colors[min(number, 1)], line)
        probe.note_at(f"loupe {line}", (at.x, at.y, end.x, at.y + height))
