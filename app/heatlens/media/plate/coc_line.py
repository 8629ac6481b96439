"""How far and how blurred each pixel of a plate is, and the focus with which one is sharp."""

import math
from dataclasses import dataclass, replace

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import CocLine, Lean, coc_line, coc_px, lean_of
from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.plate import FloatImage, Plate

_AT_INFINITY = 1e-4  # dioptres
_RADIUS_PX = 2  # take the median of 5 x 5 pixels, so that a noisy pixel does not matter
_REACH = (2, 96)  # px: a smaller blur hides nothing; a larger one is looked at up to here
_APART = 1.05  # ratio of depths from which one thing lies in front of another
_SHOWN, _COVERS = 0.1, 0.5  # shares of the light from which a near thing is told, and is meant


def line_of(plate: Plate, lens: Lens) -> CocLine:
    """Return the line of a lens, whose lean counts pixels from the corner of the data window."""
    return replace(coc_line(lens, plate.display_window.width), lean=lean_in(plate, lens))


def lean_in(plate: Plate, lens: Lens) -> Lean:
    """Return where the focus is nearer, in pixels from the corner of the data window."""
    shown, data = plate.display_window, plate.data_window
    lean = lean_of(lens, (shown.width, shown.height), plate.pixel_aspect_ratio)
    return lean.moved((shown.x0 - data.x0, shown.y0 - data.y0))


def focused_at_pixel(plate: Plate, lens: Lens, x: int, y: int) -> Lens:
    """Return the lens focused on what pixel (x, y) of the display window shows.

    A lens that leans focuses at infinity where it cannot be sharp there. Raises InputError outside
    the picture, and for a plate without distances.
    """
    shown, data, depth_m = plate.display_window, plate.data_window, depth_at_m(plate, x, y)
    pixel = x + shown.x0 - data.x0, y + shown.y0 - data.y0
    return sharp_at(lens, lean_in(plate, lens), pixel, depth_m)


def sharp_at(lens: Lens, lean: Lean, pixel: tuple[float, float], depth_m: float) -> Lens:
    """Return the lens focused so that a depth is sharp at a pixel, or at infinity if it cannot be.

    `lean` counts pixels from the same corner.
    """
    if lean.is_level:
        return replace(lens, focus_distance_m=depth_m)
    nearer = float(lean.dioptres_at(pixel[0] + 0.5, pixel[1] + 0.5))
    return focused_at(lens, 1.0 / depth_m - nearer)


def focused_at(lens: Lens, dioptres: float) -> Lens:
    """Return the lens focused at `dioptres` (1/m); 0 is infinity.

    The focus distance always stays beyond the focal length.
    """
    if dioptres <= _AT_INFINITY:
        return replace(lens, focus_distance_m=float("inf"))
    least_m = 1.02e-3 * lens.focal_length_mm
    return replace(lens, focus_distance_m=max(1.0 / dioptres, least_m))


def depth_at_m(plate: Plate, x: int, y: int) -> float:
    """Return the median depth around pixel (x, y) of the display window.

    Raises InputError outside the picture, and for a plate without distances.
    """
    if not plate.has_distances:
        raise no_distances(plate)
    return middle_m(plate.pixels.depth_in(area_at(x, y, plate.data_window, plate.display_window)))


def area_at(x: int, y: int, data: Box, display: Box) -> Box:
    """Return the area around pixel (x, y) of the display window that decides its depth.

    The area counts pixels from the corner of the data window. Raises InputError outside the
    picture.
    """
    column, row = x + display.x0 - data.x0, y + display.y0 - data.y0
    whole = Box(0, 0, data.width, data.height)
    if not whole.contains(column, row):
        raise InputError(
            f"Pixel {x},{y} is outside the picture, which has pixels "
            f"{data.x0 - display.x0},{data.y0 - display.y0} to "
            f"{data.x1 - display.x0 - 1},{data.y1 - display.y0 - 1}."
        )
    reach = _RADIUS_PX
    around = Box(column - reach, row - reach, column + reach + 1, row + reach + 1)
    return around.intersection(whole)


def middle_m(depth_m: FloatImage) -> float:
    """Return the upper median of depths, which may be infinite."""
    ordered = np.sort(depth_m, axis=None)
    middle = float(ordered[len(ordered) // 2])  # np.median would make NaN between two infinities
    return middle if math.isfinite(middle) else math.inf


def no_distances(plate: Plate) -> InputError:
    """Return the error for focusing on a plate that has a circle of confusion, not distances."""
    return InputError(
        f"{plate.path}: its depth channel is a circle of confusion, which has no distances to "
        "focus on."
    )


@dataclass(frozen=True)
class Surface:
    """Something at a pixel: a pixel (x, y) in which the plate shows it, and how far it is."""

    x: int
    y: int
    depth_m: float


def surfaces_at(plate: Plate, lens: Lens, x: int, y: int) -> tuple[Surface, ...]:
    """Return what is seen at pixel (x, y) of the display window through a lens, in order.

    The first one gives most of the light: that of the pixel itself, or something near whose blur
    covers the pixel. Raises InputError as `depth_at_m` does.
    """
    own = Surface(x, y, depth_at_m(plate, x, y))
    near = _near(plate, lens, own)
    if near is None:
        return (own,)
    surface, share = near
    return (surface, own) if share >= _COVERS else (own, surface)


def _near(plate: Plate, lens: Lens, own: Surface) -> tuple[Surface, float] | None:
    """Return the nearer thing that blurs over a pixel, and its share of the light there."""
    line = line_of(plate, lens)
    widest = abs(float(coc_px(plate.depth.near_m, line))) / 2 if plate.depth.near_m > 0 else 0.0
    reach = int(min(widest, _REACH[1]))
    if not reach >= _REACH[0]:
        return None
    shown, data = plate.display_window, plate.data_window
    column, row = own.x + shown.x0 - data.x0, own.y + shown.y0 - data.y0
    around = Box(column - reach, row - reach, column + reach + 1, row + reach + 1)
    area = around.intersection(Box(0, 0, data.width, data.height))
    depth_m = plate.pixels.depth_in(area).astype(np.float64)
    rows, columns = np.mgrid[area.y0 : area.y1, area.x0 : area.x1]
    away = np.hypot(columns - column, rows - row)
    radius = -coc_px(depth_m, line) / 2
    covers = (depth_m * _APART < own.depth_m) & (radius >= _REACH[0]) & (radius >= away)
    share = float((1.0 / (np.pi * radius[covers] ** 2)).sum())
    if share < _SHOWN:
        return None
    middle = float(np.median(depth_m[covers]))
    is_like = np.maximum(depth_m / middle, middle / depth_m) < _APART
    inside = np.lib.stride_tricks.sliding_window_view(np.pad(is_like, 2), (5, 5)).sum((2, 3))
    at = np.argmin(np.where(is_like, away - np.where(inside > 12, 2.0 * reach, 0.0), np.inf))
    x, y = int(columns.flat[at] - shown.x0 + data.x0), int(rows.flat[at] - shown.y0 + data.y0)
    return Surface(x, y, middle), min(share, 1.0)
