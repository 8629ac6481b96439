"""Guides over the picture: mattes of other aspects, safe areas, thirds and the centre."""

from dataclasses import dataclass

from heatlens.errors import InputError

# Width over height, by the name that people use.
MATTES = {"2.39": 2.39, "1.85": 1.85, "16:9": 16 / 9, "4:3": 4 / 3, "1:1": 1.0, "9:16": 9 / 16}
# Parts of the picture that every screen shows. Source: EBU R 95.
ACTION_SAFE, TITLE_SAFE = 0.93, 0.90
_ASPECT_LEAST, _ASPECT_MOST = 0.1, 10.0

Rect = tuple[float, float, float, float]  # x0, y0, x1, y1


@dataclass(frozen=True, slots=True)
class Guides:
    """What is drawn over the picture.

    aspect      width over height of what the matte leaves, None for no matte
    safe_areas  frames of what is safe for action and for titles
    thirds      lines at the thirds
    centre      a cross in the middle
    """

    aspect: float | None = None
    safe_areas: bool = False
    thirds: bool = False
    centre: bool = False


NO_GUIDES = Guides()


def inner_rect(picture: Rect, aspect: float | None) -> Rect:
    """Return the largest rectangle of an aspect in the middle of the picture; all of it for None.

    Units are those of the screen, in which a pixel is as wide as it is high.
    """
    x0, y0, x1, y1 = picture
    width, height = x1 - x0, y1 - y0
    if aspect is None:
        return picture
    inner = min(width, height * aspect), min(height, width / aspect)
    return scaled_rect(picture, inner[0] / max(width, 1e-9), inner[1] / max(height, 1e-9))


def scaled_rect(rect: Rect, across: float, down: float) -> Rect:
    """Return the rectangle around the same middle, so many times as wide and as high."""
    x0, y0, x1, y1 = rect
    middle, half = ((x0 + x1) / 2, (y0 + y1) / 2), ((x1 - x0) / 2 * across, (y1 - y0) / 2 * down)
    return middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1]


def parse_aspect(text: str) -> float:
    """Return width over height of "2.2", "2,2", "2.2:1" or "16:9". Raises InputError."""
    across, _, down = text.strip().replace(",", ".").partition(":")
    try:
        aspect = float(across) / float(down or 1)
    except (ValueError, ZeroDivisionError):
        aspect = 0.0
    if not _ASPECT_LEAST <= aspect <= _ASPECT_MOST:
        raise InputError(f"{text!r} is not an aspect. Examples: 2.2, 2.2:1, 16:9.")
    return aspect
