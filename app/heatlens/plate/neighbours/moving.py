"""Find moving objects, whose pixels must not be taken from one frame alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from heatlens.plate.neighbours.look import THROUGH, Flags, Look
from heatlens.plate.neighbours.moved import Arrived, Canvas, Numbers
from heatlens.plate.neighbours.nearby import BLOCK, around, blocks
from heatlens.plate.neighbours.view import View, motion
from heatlens.plate.plate import FloatImage

_REACH = 1 / 24  # share of the width: pixels of similar depth this close moved too
_BESIDE = 1 / 80  # share of the width: how far a moving object may extend
_LIKE = 0.1  # relative difference


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
