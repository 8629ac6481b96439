"""Move the pixels of a neighbouring frame into the view of this one."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.neighbours.look import Flags, Look
from heatlens.plate.neighbours.nearby import of_nine
from heatlens.plate.neighbours.view import NEAR_M, View, depth_of, motion
from heatlens.plate.plate import FloatImage

Numbers = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Canvas:
    """The visible surface; hidden points are searched for behind it.

    corner   left and top of its pixels, from the corner of the display window
    front_m  (H, W) depth of the visible surface
    """

    corner: tuple[int, int]
    front_m: FloatImage

    @property
    def width(self) -> int:
        """Pixels across."""
        return int(self.front_m.shape[1])

    @cached_property
    def nearest_m(self) -> FloatImage:
        """(H, W) the nearest depth within a pixel."""
        return of_nine(self.front_m, np.minimum)

    def middles(self, pixel: Numbers) -> tuple[FloatImage, FloatImage]:
        """Return x and y of the middles of pixels, from the corner of the display window."""
        row, column = np.divmod(pixel, self.width)
        left, top = self.corner
        return column + np.float32(left + 0.5), row + np.float32(top + 0.5)


def canvas_of(view: View) -> Canvas:
    return Canvas(view.corner, depth_of(view.plate))


@dataclass(frozen=True, eq=False)
class Arrived:
    """The pixels (H, W) of a frame moved into another view: their positions and depths."""

    look: Look
    x: FloatImage
    y: FloatImage
    z: FloatImage

    def over(self, canvas: Canvas) -> tuple[Numbers, Flags]:
        """Return the pixel (H, W) of the canvas that each has reached, 0 if none, and which did."""
        height, width = canvas.front_m.shape
        column = self.x - np.float32(canvas.corner[0])
        row = self.y - np.float32(canvas.corner[1])
        is_over = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        is_over &= self.z > NEAR_M
        np.multiply(column, is_over, out=column)
        np.multiply(row, is_over, out=row)
        pixel = row.astype(np.int32)
        pixel *= width
        pixel += column.astype(np.int32)
        return pixel, is_over


def arrived_in(here: View, look: Look) -> Arrived:
    """Move the pixels of a frame into a view."""
    left, top = look.view.corner
    height, width = look.depth_m.shape
    x = np.arange(width, dtype=np.float32)[None, :] + np.float32(left + 0.5)
    y = np.arange(height, dtype=np.float32)[:, None] + np.float32(top + 0.5)
    return Arrived(look, *motion(look.view, here).moved(x, y, look.depth_m))
