"""Move the pixels of a neighbouring frame into the view of this one.

Things that move themselves are found, because their pixels must not be taken from one frame alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heatlens.media.plate.neighbours.nearby import BLOCK, around, blocks, of_nine
from heatlens.media.plate.neighbours.view import (
    NEAR_M,
    THROUGH,
    Flags,
    Look,
    View,
    depth_of,
    motion,
)
from heatlens.media.plate.plate import FloatImage

Numbers = NDArray[np.int32]
_REACH = 1 / 24  # share of the width: pixels of similar depth this close moved too
_BESIDE = 1 / 80  # share of the width: how far a moving object may extend
_LIKE = 0.1  # relative difference


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


@dataclass(frozen=True, eq=False)
class Moving:
    """The depths of moving objects around each block of pixels: (H, W) nearest and farthest."""

    corner: tuple[int, int]
    near_m: FloatImage
    far_m: FloatImage

    def holds(self, x: FloatImage, y: FloatImage, z: FloatImage) -> Flags:
        """Return which points may belong to a moving object."""
        rows, columns = self.near_m.shape
        column = np.clip((x - np.float32(self.corner[0])) / BLOCK, 0, columns - 1).astype(np.int32)
        row = np.clip((y - np.float32(self.corner[1])) / BLOCK, 0, rows - 1).astype(np.int32)
        at = row * columns + column
        is_behind = z > self.near_m.ravel()[at] * (1 - _LIKE)
        moved: Flags = is_behind & (z < self.far_m.ravel()[at] * (1 + _LIKE))
        return moved


# The reverse of `moving`: that finds what a neighbour shows and this frame sees through; this finds
# what this frame shows and a neighbour sees through. Both moved by themselves, but only the first
# can be left out of what is taken; of the second nobody knows where it goes on.
def moved_here(here: View, looks: Sequence[Look], canvas: Canvas) -> FloatImage:
    """Return the farthest depth that this frame shows and another sees through; 0 if none.

    Such an object moved, so no other frame shows how it continues behind whatever hides it
    here. The depth is that around each block of pixels.
    """
    rows, columns = (np.arange(0, side, BLOCK) for side in canvas.front_m.shape)
    pixel = (rows[:, None] * canvas.width + columns).ravel()
    x, y = canvas.middles(pixel)
    z = canvas.front_m.ravel()[pixel]
    is_moved = np.zeros(len(pixel), bool)
    for look in looks:
        is_moved |= look.answers(*motion(here, look.view).moved(x, y, z))[2]
    far_m = np.where(is_moved, z, np.float32(0)).reshape(len(rows), len(columns))
    return around(far_m, max(1, round(_BESIDE * canvas.width / BLOCK)), np.maximum)


def moving(canvas: Canvas, arrived: Arrived, pixel: Numbers, is_over: Flags) -> Moving:
    """Return the moving objects of a frame: its pixels that this frame sees through.

    `pixel` and `is_over` are the results of `Arrived.over`.
    """
    look = arrived.look
    is_moved = is_over & look.is_clean
    is_moved &= canvas.nearest_m.ravel()[pixel] > THROUGH * arrived.z
    near_m = blocks(np.where(is_moved, look.depth_m, np.float32(np.inf)), np.minimum)
    far_m = blocks(np.where(is_moved, look.depth_m, np.float32(0)), np.maximum)
    reach = max(1, round(_REACH * look.depth_m.shape[1] / BLOCK))
    return Moving(
        look.view.corner, around(near_m, reach, np.minimum), around(far_m, reach, np.maximum)
    )
