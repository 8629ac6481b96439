"""The points of a neighbouring frame that lie behind what this frame shows, or outside it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.model.boxes import Box
from heatlens.plate.neighbours.look import Look
from heatlens.plate.neighbours.view import View, motion
from heatlens.plate.plate import FloatImage

APART = 0.03  # of the depth: two surfaces are one behind the other
_LEAST_SHARE = 0.04  # of a pixel that a moved pixel covers


@dataclass(frozen=True, eq=False)
class Canvas:
    """The pixels over which is searched: those of a plate and a border around them.

    box      the box of the pixels, from the corner of the display window
    front_m  (H, W) depth of the visible surface; 0 in the border
    """

    box: Box
    front_m: FloatImage

    @property
    def width(self) -> int:
        """Pixels across."""
        return self.box.width


def canvas_of(view: View, border_px: int) -> Canvas:
    """Return the canvas of a view with `border_px` more on every side."""
    depth_m, (left, top) = view.depth_m(), view.corner
    height, width = depth_m.shape
    box = Box(left - border_px, top - border_px, left + width + border_px, top + height + border_px)
    return Canvas(box, np.pad(depth_m, border_px))


def hidden_points(canvas: Canvas, here: View, look: Look) -> NDArray[np.uint64]:
    """Return the points of a frame behind the canvas: the pixel and the depth of each, packed."""
    x, y, z = _arrived(here, look)
    column = np.floor(x - np.float32(canvas.box.x0 + 0.5))
    row = np.floor(y - np.float32(canvas.box.y0 + 0.5))
    is_near = (column >= -1) & (column < canvas.width) & (row >= -1) & (row < canvas.box.height)
    some = np.flatnonzero(is_near & look.is_clean & (z > 0.01))
    x, y, z = x.ravel()[some], y.ravel()[some], z.ravel()[some]
    found = [
        _at(canvas, x, y, z, column.ravel()[some], row.ravel()[some], step)
        for step in ((0, 0), (1, 0), (0, 1), (1, 1))
    ]
    return np.concatenate(found)


def _arrived(here: View, look: Look) -> tuple[FloatImage, FloatImage, FloatImage]:
    left, top = look.view.corner
    height, width = look.depth_m.shape
    x = np.arange(width, dtype=np.float32)[None, :] + np.float32(left + 0.5)
    y = np.arange(height, dtype=np.float32)[:, None] + np.float32(top + 0.5)
    return motion(look.view, here).moved(x, y, look.depth_m)


def _at(
    canvas: Canvas,
    x: FloatImage,
    y: FloatImage,
    z: FloatImage,
    column: FloatImage,
    row: FloatImage,
    step: tuple[int, int],
) -> NDArray[np.uint64]:
    """Return the points on one of the four pixels around each, where they lie behind the front."""
    column, row = column + step[0], row + step[1]
    is_inside = (column >= 0) & (column < canvas.width) & (row >= 0) & (row < canvas.box.height)
    share = (1 - np.abs(x - canvas.box.x0 - 0.5 - column)) * (
        1 - np.abs(y - canvas.box.y0 - 0.5 - row)
    )
    pixel = np.where(is_inside, row * canvas.width + column, 0).astype(np.int64)
    is_behind = z > canvas.front_m.ravel()[pixel] * np.float32(1 + APART)
    some = is_inside & is_behind & (share > _LEAST_SHARE)
    return packed(pixel[some], z[some])


def packed(pixel: NDArray[np.int64], z: FloatImage) -> NDArray[np.uint64]:
    """Return pixel and depth in one number, which sorts by pixel and then by depth."""
    bits = np.ascontiguousarray(z, np.float32).view(np.uint32).astype(np.uint64)
    return (pixel.astype(np.uint64) << np.uint64(32)) | bits


def surfaces(
    points: NDArray[np.uint64], most: int
) -> tuple[NDArray[np.int64], FloatImage, NDArray[np.int64]]:
    """Return pixel, mean depth and order of the nearest `most` surfaces of each pixel.

    Points of a pixel within `APART` of the nearest of them are one surface.
    """
    points = np.sort(points)
    pixel = (points >> np.uint64(32)).astype(np.int64)
    z = (points & np.uint64(0xFFFFFFFF)).astype(np.uint32).view(np.float32)
    found: list[tuple[NDArray[np.int64], FloatImage, NDArray[np.int64]]] = []
    for order in range(most):
        if not len(pixel):
            break
        begins = np.flatnonzero(np.diff(pixel, prepend=-1))
        counts = np.diff(begins, append=len(pixel))
        limit = np.repeat(z[begins] * np.float32(1 + APART), counts)
        is_first = z <= limit
        sums = np.add.reduceat(np.where(is_first, z.astype(np.float64), 0.0), begins)
        number = np.add.reduceat(is_first, begins, dtype=np.int64)
        found.append(
            (pixel[begins], (sums / number).astype(np.float32), np.full(len(begins), order))
        )
        pixel, z = pixel[~is_first], z[~is_first]
    if not found:
        return np.zeros(0, np.int64), np.zeros(0, np.float32), np.zeros(0, np.int64)
    pixels, depths, orders = zip(*found, strict=True)
    return np.concatenate(pixels), np.concatenate(depths), np.concatenate(orders)
