"""Collect points of neighbouring frames behind the visible surface, and sort them by surface."""

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.neighbours.moved import Arrived, Canvas, Numbers
from heatlens.plate.neighbours.nearby import BLOCK, around, blocks, of_nine
from heatlens.plate.neighbours.view import MIXED, Flags
from heatlens.plate.plate import FloatImage

APART = 0.03  # relative depth difference between two separate surfaces
_BAND = 1 / 40  # share of the width, inside near silhouettes: about what wide discs uncover
_LEAST_SHARE = 0.04  # share of a pixel that a moved pixel covers
Points = NDArray[np.uint64]  # pixel of the canvas in the upper half, depth in the lower half


def hidden_points(canvas: Canvas, arrived: Arrived, pixel: Numbers, is_over: Flags) -> Points:
    """Return the points of a frame behind the canvas, each in the four pixels around it.

    `pixel` and `is_over` are the results of `Arrived.over`.
    """
    least_m = canvas.nearest_m * np.float32(1 + APART)
    some = np.flatnonzero(is_over & arrived.look.is_clean & (arrived.z > least_m.ravel()[pixel]))
    left, top = canvas.corner
    x = arrived.x.ravel()[some] - np.float32(left + 0.5)
    y = arrived.y.ravel()[some] - np.float32(top + 0.5)
    z = arrived.z.ravel()[some]
    steps = ((0, 0), (1, 0), (0, 1), (1, 1))
    return np.concatenate([_beside(canvas, x, y, z, *step) for step in steps])


def _beside(
    canvas: Canvas, x: FloatImage, y: FloatImage, z: FloatImage, right: int, down: int
) -> Points:
    """Return the points that lie behind the visible surface, in one of the four pixels."""
    column, row = np.floor(x) + right, np.floor(y) + down
    is_inside = (column >= 0) & (column < canvas.width) & (row >= 0)
    is_inside &= row < canvas.front_m.shape[0]
    share = (1 - np.abs(x - column)) * (1 - np.abs(y - row))
    pixel = np.where(is_inside, row * canvas.width + column, 0).astype(np.int64)
    is_behind = z > canvas.front_m.ravel()[pixel] * np.float32(1 + APART)
    some = is_inside & is_behind & (share > _LEAST_SHARE)
    return packed(pixel[some], z[some])


def packed(pixel: NDArray[np.integer], z: FloatImage) -> Points:
    """Combine pixel and depth in one number that sorts by pixel, then by depth."""
    bits = np.ascontiguousarray(z, np.float32).view(np.uint32).astype(np.uint64)
    return (pixel.astype(np.uint64) << np.uint64(32)) | bits


def surfaces(points: Points, most: int) -> list[tuple[Numbers, FloatImage]]:
    """Return the pixels and depths of the nearest surface of each pixel, of the next, and so on.

    Points of a pixel within `APART` of the nearest of them are one surface, with their mean depth.
    """
    points = np.sort(points)
    pixel = (points >> np.uint64(32)).astype(np.int32)
    z = points.astype(np.uint32).view(np.float32)
    found: list[tuple[Numbers, FloatImage]] = []
    while len(pixel) and len(found) < most:
        begins = np.flatnonzero(np.append(True, pixel[1:] != pixel[:-1]))
        counts = np.diff(begins, append=len(pixel))
        is_first = z <= np.repeat(z[begins] * np.float32(1 + APART), counts)
        sums = np.add.reduceat(np.where(is_first, z, 0), begins, dtype=np.float64)
        number = np.add.reduceat(is_first, begins, dtype=np.int64)
        found.append((pixel[begins], (sums / number).astype(np.float32)))
        pixel, z = pixel[~is_first], z[~is_first]
    return found


def could_be_seen(front_m: FloatImage) -> Flags:
    """Return which pixels hide something that a lens could see: those inside near silhouettes.

    One of each block of pixels is told.
    """
    is_rim = of_nine(front_m, np.maximum) > front_m * np.float32(MIXED)
    rim_m = blocks(np.where(is_rim, front_m, np.float32(0)), np.maximum)
    reach = max(1, round(_BAND * front_m.shape[1] / BLOCK))
    inside: Flags = front_m[::BLOCK, ::BLOCK] <= around(rim_m, reach, np.maximum) * (1 + APART)
    return inside
