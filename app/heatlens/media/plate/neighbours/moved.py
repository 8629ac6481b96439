"""Move the pixels of a neighboring frame into the view of this one.

Moving objects are found as well, because their pixels must not be taken from one frame alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heatlens.media.plate.neighbours.nearby import (
    BLOCK,
    filter_three_by_three,
    filter_within,
    reduce_blocks,
)
from heatlens.media.plate.neighbours.view import (
    NEAR_M,
    THROUGH,
    Flags,
    NeighborFrame,
    View,
    depth_of,
    motion_between,
)
from heatlens.media.plate.plate import FloatImage

Numbers = NDArray[np.int32]
_REACH = 1 / 24  # share of the width within which pixels of similar depth count as moving, too
_EXTENT = 1 / 80  # share of the width: how far an object that moved may extend from its pixels
_DEPTH_TOLERANCE = 0.1  # relative difference within which two depths are similar


@dataclass(frozen=True, eq=False)
class Canvas:
    """The visible surface of a view; hidden points are searched for behind it.

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
        return filter_three_by_three(self.front_m, np.minimum)

    def pixel_centers(self, pixel: Numbers) -> tuple[FloatImage, FloatImage]:
        """Return x and y of the middles of pixels, from the corner of the display window."""
        row, column = np.divmod(pixel, self.width)
        left, top = self.corner
        return column + np.float32(left + 0.5), row + np.float32(top + 0.5)


def canvas_of(view: View) -> Canvas:
    """Return the visible surface of a view."""
    return Canvas(view.corner, depth_of(view.plate))


@dataclass(frozen=True, eq=False)
class MovedFrame:
    """The pixels (H, W) of a frame moved into another view: x, y in pixels, depth z in meters."""

    neighbor: NeighborFrame
    x: FloatImage
    y: FloatImage
    z: FloatImage

    def pixels_on(self, canvas: Canvas) -> tuple[Numbers, Flags]:
        """Return the canvas pixel (H, W) of each pixel, and a mask of those inside the canvas.

        The canvas pixel is 0 outside.
        """
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


def move_into_view(view: View, neighbor: NeighborFrame) -> MovedFrame:
    """Return the pixels of the frame of `neighbor` with their positions and depths in `view`."""
    left, top = neighbor.view.corner
    height, width = neighbor.depth_m.shape
    x = np.arange(width, dtype=np.float32)[None, :] + np.float32(left + 0.5)
    y = np.arange(height, dtype=np.float32)[:, None] + np.float32(top + 0.5)
    motion = motion_between(neighbor.view, view)
    return MovedFrame(neighbor, *motion.move_points(x, y, neighbor.depth_m))


@dataclass(frozen=True, eq=False)
class MovingDepths:
    """The nearest and the farthest depth of moving objects around each block of pixels, (H, W).

    `corner` is the left and top of the first block, from the corner of the display window.
    """

    corner: tuple[int, int]
    near_m: FloatImage
    far_m: FloatImage

    def may_contain(self, x: FloatImage, y: FloatImage, z: FloatImage) -> Flags:
        """Return a mask of the points (x, y in pixels, z in meters) that may be moving."""
        rows, columns = self.near_m.shape
        column = np.clip((x - np.float32(self.corner[0])) / BLOCK, 0, columns - 1).astype(np.int32)
        row = np.clip((y - np.float32(self.corner[1])) / BLOCK, 0, rows - 1).astype(np.int32)
        block = row * columns + column
        is_behind = z > self.near_m.ravel()[block] * (1 - _DEPTH_TOLERANCE)
        may_move: Flags = is_behind & (z < self.far_m.ravel()[block] * (1 + _DEPTH_TOLERANCE))
        return may_move


# The reverse of `find_moving_depths`, which finds objects that a neighbor shows and this frame
# sees through. This finds objects that this frame shows and a neighbor sees through. Both moved,
# but only the pixels of the first can be left out; how the second continues is unknown.
def farthest_moved_m(view: View, neighbors: Sequence[NeighborFrame], canvas: Canvas) -> FloatImage:
    """Return the farthest depth around each block of pixels that another frame sees through.

    It is 0 where there is none. An object at this depth moved, so no other frame shows how it
    continues behind the surface that hides a part of it here.
    """
    rows, columns = (np.arange(0, side, BLOCK) for side in canvas.front_m.shape)
    pixel = (rows[:, None] * canvas.width + columns).ravel()
    x, y = canvas.pixel_centers(pixel)
    z = canvas.front_m.ravel()[pixel]
    is_moved = np.zeros(len(pixel), bool)
    for neighbor in neighbors:
        moved_points = motion_between(view, neighbor.view).move_points(x, y, z)
        is_moved |= neighbor.test_points(*moved_points)[2]  # seen through
    far_m = np.where(is_moved, z, np.float32(0)).reshape(len(rows), len(columns))
    return filter_within(far_m, max(1, round(_EXTENT * canvas.width / BLOCK)), np.maximum)


def find_moving_depths(
    canvas: Canvas, moved_frame: MovedFrame, pixel: Numbers, is_over: Flags
) -> MovingDepths:
    """Return the depths of what moved in another frame.

    These are its pixels where the shown frame sees something farther, by the factor THROUGH, so
    that nothing can have stood there. `pixel` and `is_over` are the results of
    `MovedFrame.pixels_on`: the pixel of the canvas, and whether it is on the canvas.
    """
    neighbor = moved_frame.neighbor
    is_moved = is_over & neighbor.is_clean
    is_moved &= canvas.nearest_m.ravel()[pixel] > THROUGH * moved_frame.z
    near_m = reduce_blocks(np.where(is_moved, neighbor.depth_m, np.float32(np.inf)), np.minimum)
    far_m = reduce_blocks(np.where(is_moved, neighbor.depth_m, np.float32(0)), np.maximum)
    reach = max(1, round(_REACH * neighbor.depth_m.shape[1] / BLOCK))
    return MovingDepths(
        neighbor.view.corner,
        near_m=filter_within(near_m, reach, np.minimum),
        far_m=filter_within(far_m, reach, np.maximum),
    )
