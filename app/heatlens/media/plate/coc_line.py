"""Compute the depth and the blur of pixels of a plate, and the focus that makes one sharp.

The blur is the diameter of the circle of confusion (CoC), which is linear in dioptres: a CoC line.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import CocLine, coc_line, coc_px
from heatlens.core.model.focus.focus_offset import FocusOffset, focus_offset_of
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.media.plate.plate import FloatImage, Plate

_AT_INFINITY = 1e-4  # dioptres at or below which the focus is at infinity
_RADIUS_PX = 2  # take the median of 5 x 5 pixels, so that a noisy pixel does not matter
_REACH = (2, 96)  # px: a smaller blur radius hides nothing; a larger one is searched up to here
_DEPTH_RATIO = 1.05  # ratio of depths from which one thing lies in front of another
_LEAST_SHARE = 0.1  # least share of a pixel's light with which a nearer thing is listed at all
_MAIN_SHARE = 0.5  # least share of a pixel's light with which a nearer thing is listed first
_NUDGE = 1 / 250  # one notch, as a share of the length of the focus bar


def line_of(plate: Plate, lens: Lens) -> CocLine:
    """Return the CoC line of a lens for the pixels of a plate.

    The tilt of its focus plane counts pixels from the corner of the data window.
    """
    return replace(
        coc_line(lens, plate.display_window.width), focus_offset=focus_offset_in(plate, lens)
    )


def focus_offset_in(plate: Plate, lens: Lens) -> FocusOffset:
    """Return the tilt of the focus plane of a lens, as an offset of the focus at each pixel.

    Pixels count from the corner of the data window.
    """
    display, data = plate.display_window, plate.data_window
    tilt = focus_offset_of(lens, (display.width, display.height), plate.pixel_aspect_ratio)
    return tilt.moved(display.relative_to(data).corner)


def focused_at_pixel(plate: Plate, lens: Lens, x: int, y: int) -> Lens:
    """Return the lens focused on what pixel (x, y) of the display window shows.

    A lens with a tilted focus plane is focused at infinity if it cannot be sharp there. Raises
    InputError outside the picture, and for a plate without distances.
    """
    display, data, depth_m = plate.display_window, plate.data_window, depth_at_m(plate, x, y)
    pixel = x + display.x0 - data.x0, y + display.y0 - data.y0
    return sharp_at(lens, focus_offset_in(plate, lens), pixel, depth_m)


def sharp_at(lens: Lens, tilt: FocusOffset, pixel: tuple[float, float], depth_m: float) -> Lens:
    """Return the lens focused so that a depth is sharp at a pixel, or at infinity if it cannot be.

    `tilt`, that of the focus plane, counts pixels from the same corner as `pixel`.
    """
    if tilt.is_level:
        return replace(lens, focus_distance_m=depth_m)
    tilt_dioptres = float(tilt.dioptres_at(pixel[0] + 0.5, pixel[1] + 0.5))
    return focused_at(lens, 1.0 / depth_m - tilt_dioptres)


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
        raise no_distances_error(plate)
    return upper_median_m(
        plate.pixels.depth_in(area_at(x, y, plate.data_window, plate.display_window))
    )


def area_at(x: int, y: int, data: Box, display: Box) -> Box:
    """Return the area around pixel (x, y) of the display window that decides its depth.

    The area counts pixels from the corner of the data window. Raises InputError outside the
    picture.
    """
    shown = data.relative_to(display)
    if not shown.contains(x, y):
        raise InputError(
            f"Pixel {x},{y} is outside the picture, which has pixels "
            f"{shown.x0},{shown.y0} to {shown.x1 - 1},{shown.y1 - 1}."
        )
    reach = _RADIUS_PX
    square = Box(x - reach, y - reach, x + reach + 1, y + reach + 1)
    return square.intersection(shown).relative_to(shown)


def upper_median_m(depth_m: FloatImage) -> float:
    """Return the upper median of depths, which may be infinite."""
    ordered = np.sort(depth_m, axis=None)
    median_m = float(ordered[len(ordered) // 2])  # np.median would make NaN between two infinities
    return median_m if math.isfinite(median_m) else math.inf


def no_distances_error(plate: Plate) -> InputError:
    """Return the error for focusing on a plate that has a circle of confusion, not distances."""
    return InputError(
        f"{plate.path}: its depth channel is a circle of confusion, which has no distances to "
        "focus on. Leave the focus as it is, or give a depth with --depth."
    )


@dataclass(frozen=True)
class Surface:
    """A surface seen at a pixel: one pixel (x, y) in which the plate shows it, and its depth."""

    x: int
    y: int
    depth_m: float


def surfaces_at(plate: Plate, lens: Lens, x: int, y: int) -> tuple[Surface, ...]:
    """Return what is seen at pixel (x, y) of the display window through a lens, in order.

    The first one gives most of the light: that of the pixel itself, or something near whose blur
    covers the pixel. Raises InputError as `depth_at_m` does.
    """
    pixel_surface = Surface(x, y, depth_at_m(plate, x, y))
    blurred = _find_blurring_surface(plate, lens, pixel_surface)
    if blurred is None:
        return (pixel_surface,)
    surface, share = blurred
    return (surface, pixel_surface) if share >= _MAIN_SHARE else (pixel_surface, surface)


def _find_blurring_surface(
    plate: Plate, lens: Lens, pixel_surface: Surface
) -> tuple[Surface, float] | None:
    """Return the nearer thing whose blur covers a pixel, and its share of the light there.

    The share is 0 to 1. Returns None if no nearer thing reaches `_LEAST_SHARE`.
    """
    line = line_of(plate, lens)
    largest_radius = (
        abs(float(coc_px(plate.depth.near_m, line))) / 2 if plate.depth.near_m > 0 else 0.0
    )
    reach = int(min(largest_radius, _REACH[1]))
    if not reach >= _REACH[0]:
        return None
    data = plate.data_window.relative_to(plate.display_window)
    column, row = pixel_surface.x - data.x0, pixel_surface.y - data.y0
    square = Box(column - reach, row - reach, column + reach + 1, row + reach + 1)
    area = square.intersection(Box(0, 0, data.width, data.height))
    depth_m = plate.pixels.depth_in(area).astype(np.float64)
    rows, columns = np.mgrid[area.y0 : area.y1, area.x0 : area.x1]
    distance_px = np.hypot(columns - column, rows - row)
    radius = -coc_px(depth_m, line) / 2
    is_covering = (
        (depth_m * _DEPTH_RATIO < pixel_surface.depth_m)
        & (radius >= _REACH[0])
        & (radius >= distance_px)
    )
    # A disc spreads the light of its pixel evenly over its area, pi radius^2.
    share = float((1.0 / (np.pi * radius[is_covering] ** 2)).sum())
    if share < _LEAST_SHARE:
        return None
    median_m = float(np.median(depth_m[is_covering]))
    is_like = np.maximum(depth_m / median_m, median_m / depth_m) < _DEPTH_RATIO
    # Take a pixel whose 5 x 5 neighbors are mostly of the same thing, if there is one within reach.
    inside = np.lib.stride_tricks.sliding_window_view(np.pad(is_like, 2), (5, 5)).sum((2, 3))
    nearest = np.argmin(
        np.where(is_like, distance_px - np.where(inside > 12, 2.0 * reach, 0.0), np.inf)
    )
    x, y = int(columns.flat[nearest]) + data.x0, int(rows.flat[nearest]) + data.y0
    return Surface(x, y, median_m), min(share, 1.0)


def nudge_lens(lens: Lens, histogram: DepthHistogram, notches: float) -> Lens:
    """Return the lens focused nearer (positive) or farther by `notches` of the focus bar."""
    step = notches * _NUDGE * histogram.most_dioptres
    return focused_at(lens, max(1.0 / lens.focus_distance_m + step, 0.0))
