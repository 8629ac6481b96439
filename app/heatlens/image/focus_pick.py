"""The distance of what is seen at a pixel: what a click to focus asks for."""

import math

import numpy as np

from heatlens.errors import InputError
from heatlens.image.plate import Plate
from heatlens.model.boxes import Box

_RADIUS_PX = 2  # the median of 5 x 5 pixels: one noisy pixel does not decide


def depth_at_m(plate: Plate, x: int, y: int) -> float:
    """Median depth around a pixel, counted from the display window's corner as viewers show it.

    Raises InputError outside the picture, and for a plate without distances.
    """
    if not plate.has_distances:
        raise no_distances(plate)
    window, display = plate.data_window, plate.display_window
    column, row = x + display.x0 - window.x0, y + display.y0 - window.y0
    if not (0 <= column < window.width and 0 <= row < window.height):
        raise InputError(
            f"Pixel {x},{y} is outside the picture, which has pixels "
            f"{window.x0 - display.x0},{window.y0 - display.y0} to "
            f"{window.x1 - display.x0 - 1},{window.y1 - display.y0 - 1}."
        )
    reach = _RADIUS_PX
    around = Box(column - reach, row - reach, column + reach + 1, row + reach + 1)
    inside = around.intersection(Box(0, 0, window.width, window.height))
    ordered = np.sort(plate.pixels.depth_in(inside), axis=None)
    middle = float(ordered[len(ordered) // 2])  # np.median would make NaN between two infinities
    return middle if math.isfinite(middle) else math.inf


def no_distances(plate: Plate) -> InputError:
    """What to say where a distance is asked of a plate that brings its circle of confusion."""
    return InputError(
        f"{plate.path}: its depth channel is a circle of confusion, which has no distances to "
        "focus on."
    )
