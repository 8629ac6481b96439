"""Guides over the picture: mattes of other aspects, safe areas, thirds, the center, desqueeze.

`guide_shapes` is the only description of them: the window draws it with ImGui, exports draw it into
their pixels. Focus peaking colors what is in focus, as camera monitors do.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from heatlens.core.base.errors import InputError
from heatlens.core.model.option import check_range, option_field

# Width over height, by the name that people use.
MATTES = {"2.39": 2.39, "1.85": 1.85, "16:9": 16 / 9, "4:3": 4 / 3, "1:1": 1.0, "9:16": 9 / 16}
# Squeezes of existing anamorphic lenses.
SQUEEZES = {"1.25": 1.25, "1.33": 4 / 3, "1.5": 1.5, "1.65": 1.65, "1.8": 1.8, "2": 2.0}
# Parts of the picture that every screen shows. Source: EBU R 95.
ACTION_SAFE, TITLE_SAFE = 0.93, 0.90
LINE_OPACITY = 0.55  # opacity of the white lines
_ASPECT_LEAST, _ASPECT_MOST = 0.1, 10.0
_PIXEL_LEAST, _PIXEL_MOST = 0.25, 4.0
_ARM_SHARE = 0.05  # length of an arm of a cross or a corner, as a part of the height

Rect = tuple[float, float, float, float]  # x0, y0, x1, y1
Part = tuple[float, float, float, float]  # x0, y0, x1, y1 as parts of the canvas
_SAME_SHAPE = 0.005  # relative difference of two aspects up to which they count as the same
Rgb = tuple[float, float, float]
# Display values by name; the first is a color that is rare in scenes.
PEAKING_COLORS: dict[str, Rgb] = {
    "magenta": (1.0, 0.2, 0.75),
    "red": (1.0, 0.15, 0.1),
    "yellow": (1.0, 0.9, 0.1),
    "green": (0.2, 1.0, 0.3),
    "blue": (0.2, 0.55, 1.0),
    "white": (1.0, 1.0, 1.0),
}
STOPS_RANGE = 0.05, 3.0  # contrast of an edge, in stops
BLUR_RANGE = 0.1, 4.0  # unit: acceptable circles of confusion


def parse_aspect(text: str) -> float:
    """Return width over height of "2.2", "2,2", "2.2:1" or "16:9". Raises InputError."""
    return _parse_ratio(text, _ASPECT_LEAST, _ASPECT_MOST, "an aspect. Examples: 2.2, 2.2:1, 16:9")


def parse_desqueeze(text: str) -> float:
    """Return a pixel's width over its height, from "2", "1,33" or "4:3". Raises InputError."""
    expected = f"a desqueeze from {_PIXEL_LEAST:g} to {_PIXEL_MOST:g}. Examples: 2, 1.33, 4:3"
    return _parse_ratio(text, _PIXEL_LEAST, _PIXEL_MOST, expected)


def _parse_ratio(text: str, least: float, most: float, expected: str) -> float:
    """Return the ratio of "2,2" or "16:9"; raise InputError with `expected` outside the limits."""
    width_text, _, height_text = text.strip().replace(",", ".").partition(":")
    try:
        ratio = float(width_text) / float(height_text or 1)
    except (ValueError, ZeroDivisionError):
        ratio = 0.0
    if not least <= ratio <= most:
        raise InputError(f"{text!r} is not {expected}.")
    return ratio


@dataclass(frozen=True, slots=True)
class FrameLine:
    """A frame of a framing decision list (ASC FDL) by its name.

    `protection` is the area around it that must be kept clean; None for no such area.
    """

    name: str
    frame: Part
    protection: Part | None = None


@dataclass(frozen=True, slots=True)
class Canvas:
    """An area of a camera's or a file's pixels, of this width and height, and its lines."""

    width: float
    height: float
    lines: tuple[FrameLine, ...]


def frame_lines_for(
    canvases: Iterable[Canvas], width: float, height: float
) -> tuple[FrameLine, ...]:
    """Return the lines of the canvas of a picture's size, else of the first of its shape."""
    by_size = (it for it in canvases if (it.width, it.height) == (width, height))
    by_shape = (it for it in canvases if _has_shape(it, width / height))
    canvas = next(by_size, None) or next(by_shape, None)
    return () if canvas is None else canvas.lines


def _has_shape(canvas: Canvas, aspect: float) -> bool:
    return abs(canvas.width / canvas.height / aspect - 1.0) < _SAME_SHAPE


@dataclass(frozen=True, slots=True)
class Guides:
    """The guides over the picture, and the width of its pixels.

    Raises InputError for numbers beyond what the options take.

    aspect      width over height of the open part of the matte, None for no matte
    opacity     of the matte: 1 is black
    safe_areas  outlines of the action-safe and title-safe areas
    thirds      lines at the thirds
    centre      a cross in the middle
    desqueeze   width of a pixel over its height; None: that of the file
    canvases    the lines of a framing decision list, for each shape of a picture
    """

    aspect: float | None = option_field(
        None,
        "matte",
        "darken what a picture of this aspect cuts off: 2.39, 1.85, 16:9",
        metavar="ASPECT",
        parse=parse_aspect,
    )
    opacity: float = option_field(
        0.72,
        "matte opacity",
        "opacity of the matte, 1 is black (default 0.72)",
        metavar="PART",
        least=0.0,
        most=1.0,
    )
    safe_areas: bool = option_field(
        False, "safe areas", "draw the safe areas for action and titles"
    )
    thirds: bool = option_field(False, "thirds", "draw lines at the thirds")
    centre: bool = option_field(False, "centre cross", "draw a cross in the middle")
    desqueeze: float | None = option_field(
        None,
        "desqueeze",
        "widen an anamorphic picture by this factor, to square pixels: 2, 1.33",
        metavar="N",
        parse=parse_desqueeze,
    )
    canvases: tuple[Canvas, ...] = ()

    def __post_init__(self) -> None:
        """Check the ranges of the numbers."""
        check_range("aspect", self.aspect, _ASPECT_LEAST, _ASPECT_MOST)
        check_range("opacity", self.opacity, 0.0, 1.0)
        check_range("desqueeze", self.desqueeze, _PIXEL_LEAST, _PIXEL_MOST)


NO_GUIDES = Guides()


@dataclass(frozen=True, slots=True)
class GuideShapes:
    """The shapes to draw: axis-aligned rectangles and lines.

    shades  rectangles that are darkened
    frames  rectangles of which the outline is drawn
    lines   from x0, y0 to x1, y1
    """

    shades: tuple[Rect, ...]
    frames: tuple[Rect, ...]
    lines: tuple[Rect, ...]


def guide_shapes(guides: Guides, picture: Rect, lines: Iterable[FrameLine] = ()) -> GuideShapes:
    """Return the shapes to draw over a picture in the rectangle `picture`, in units of the screen.

    `lines` are its framing lines. What they protect is drawn as four corners.
    """
    inner = inner_rect(picture, guides.aspect)
    frames = [inner] if inner != picture else []
    if guides.safe_areas:
        frames += [scaled_rect(inner, part, part) for part in (ACTION_SAFE, TITLE_SAFE)]
    guide_lines = [*_thirds(inner)] if guides.thirds else []
    guide_lines += _cross(inner) if guides.centre else ()
    for line in lines:
        frames.append(_rect_of_part(line.frame, picture))
        if line.protection is not None:
            guide_lines += _corners(_rect_of_part(line.protection, picture))
    return GuideShapes(_border_rects(picture, inner), tuple(frames), tuple(guide_lines))


def _rect_of_part(part: Part, picture: Rect) -> Rect:
    """Return the rectangle on the screen of a part of the picture's canvas."""
    left, top, right, bottom = picture
    width, height = right - left, bottom - top
    x0, y0, x1, y1 = part
    return left + x0 * width, top + y0 * height, left + x1 * width, top + y1 * height


def _corners(rect: Rect) -> list[Rect]:
    """Return the lines, to the right or down, that mark the four corners of a rectangle."""
    x0, y0, x1, y1 = rect
    length = _ARM_SHARE * (y1 - y0)
    # Both ends of a line, then the corner.
    columns = (x0, x0 + length, x0), (x1 - length, x1, x1)
    rows = (y0, y0 + length, y0), (y1 - length, y1, y1)
    return [
        line
        for left, right, x in columns
        for top, bottom, y in rows
        for line in ((left, y, right, y), (x, top, x, bottom))
    ]


def _border_rects(outer: Rect, inner: Rect) -> tuple[Rect, ...]:
    """Return the rectangles of `outer` around `inner`: above, below, left and right."""
    x0, y0, x1, y1 = outer
    inner_x0, inner_y0, inner_x1, inner_y1 = inner
    rects = (
        (x0, y0, x1, inner_y0),
        (x0, inner_y1, x1, y1),
        (x0, inner_y0, inner_x0, inner_y1),
        (inner_x1, inner_y0, x1, inner_y1),
    )
    return tuple(rect for rect in rects if rect[2] > rect[0] and rect[3] > rect[1])


def _thirds(rect: Rect) -> list[Rect]:
    """Return the two vertical and the two horizontal lines at the thirds of a rectangle."""
    x0, y0, x1, y1 = rect
    columns = [x0 + part * (x1 - x0) for part in (1 / 3, 2 / 3)]
    rows = [y0 + part * (y1 - y0) for part in (1 / 3, 2 / 3)]
    return [*((x, y0, x, y1) for x in columns), *((x0, y, x1, y) for y in rows)]


def _cross(rect: Rect) -> list[Rect]:
    """Return the two lines of a cross in the middle of a rectangle."""
    x, y = (rect[0] + rect[2]) / 2, (rect[1] + rect[3]) / 2
    length = _ARM_SHARE * (rect[3] - rect[1])
    return [(x - length, y, x + length, y), (x, y - length, x, y + length)]


def inner_rect(picture: Rect, aspect: float | None) -> Rect:
    """Return the largest centered rectangle of an aspect; the whole picture for None.

    Units are those of the screen, in which a pixel is as wide as it is high.
    """
    x0, y0, x1, y1 = picture
    width, height = x1 - x0, y1 - y0
    if aspect is None:
        return picture
    inner = min(width, height * aspect), min(height, width / aspect)
    return scaled_rect(picture, inner[0] / max(width, 1e-9), inner[1] / max(height, 1e-9))


def scaled_rect(rect: Rect, scale_x: float, scale_y: float) -> Rect:
    """Return the rectangle scaled about its center."""
    x0, y0, x1, y1 = rect
    middle = ((x0 + x1) / 2, (y0 + y1) / 2)
    half = ((x1 - x0) / 2 * scale_x, (y1 - y0) / 2 * scale_y)
    return middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1]


class PeakingOn(StrEnum):
    """Where focus peaking draws its color."""

    PICTURE = "edges of the picture"  # seen through the lens, and the silhouettes
    DEPTH = "all at the distance"  # with or without edges


@dataclass(frozen=True, slots=True)
class Peaking:
    """How peaking is drawn.

    on     edges alone, or everything in focus
    stops  contrast of an edge that is colored, in stops of its light
    blur   how large a blur still counts as in focus, in acceptable circles of confusion
    color  name of the color

    Raises InputError for numbers out of range and for unknown colors.
    """

    on: PeakingOn = PeakingOn.PICTURE
    stops: float = 0.5
    blur: float = 1.0
    color: str = next(iter(PEAKING_COLORS))

    def __post_init__(self) -> None:
        """Check the numbers and the name of the color."""
        check_range("stops", self.stops, *STOPS_RANGE)
        check_range("blur", self.blur, *BLUR_RANGE)
        if self.color not in PEAKING_COLORS:
            names = ", ".join(PEAKING_COLORS)
            raise InputError(f"{self.color!r} is not a peaking colour; known are {names}.")

    @property
    def rgb(self) -> Rgb:
        """Its color as display values."""
        return PEAKING_COLORS[self.color]


USUAL_PEAKING = Peaking()
