"""Find the distance of the surface at a pixel, for focusing with a click."""

import math

import numpy as np

from heatlens.base.errors import InputError
from heatlens.model.boxes import Box
from heatlens.plate.plate import FloatImage, Plate

_RADIUS_PX = 2  # take the median of 5 x 5 pixels, so that a noisy pixel does not matter


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
