"""What one frame shows at points in space: which of them it sees, sees through, or has hidden."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.neighbours.nearby import of_nine
from heatlens.plate.neighbours.view import NEAR_M, View
from heatlens.plate.plate import FloatImage

Flags = NDArray[np.bool_]
MIXED = 1.05  # a pixel beside one this many times as far may be a mixture of both
SAME = 0.01  # of the depth: two frames see the same surface
THROUGH = 1.02  # times as far: a frame sees what lies behind a point, which cannot be there
_LEAST_WEIGHT = 0.3  # of the four pixels around a point, those that show its surface


@dataclass(frozen=True, eq=False)
class Look:
    """A frame made ready to be asked.

    depth_m   (H, W) over the data window
    near_m    (H, W) the nearest depth within a pixel
    is_clean  (H, W) pixels that show one surface
    """

    view: View
    depth_m: FloatImage
    near_m: FloatImage
    is_clean: Flags

    def answers(
        self, x: FloatImage, y: FloatImage, z: FloatImage
    ) -> tuple[FloatImage, Flags, Flags]:
        """Return what is seen at points of this view: colours (N, 4), where, where through them.

        Where a point is neither seen nor seen through, it is hidden or outside the picture.
        """
        column, row, right, down = self._cells(x, y)
        height, width = self.depth_m.shape
        total = np.zeros(len(x), np.float32)
        color = np.zeros((len(x), 4), np.float32)
        pixels = self.view.plate.color.reshape(-1, 4)
        is_inside = (column >= -1) & (column < width) & (row >= -1) & (row < height) & (z > NEAR_M)
        for up, left in ((0, 0), (0, 1), (1, 0), (1, 1)):
            at = np.clip(row + up, 0, height - 1) * width + np.clip(column + left, 0, width - 1)
            is_same = np.abs(self.depth_m.ravel()[at] - z) < SAME * z
            is_same &= is_inside & self.is_clean.ravel()[at]
            weight = (right if left else 1 - right) * (down if up else 1 - down) * is_same
            total += weight
            color += weight[:, None] * pixels[at]
        is_seen = total > _LEAST_WEIGHT
        color /= np.maximum(total, _LEAST_WEIGHT)[:, None]
        nearest = np.clip((row + (down >= 0.5)), 0, height - 1) * width + np.clip(
            column + (right >= 0.5), 0, width - 1
        )
        is_through = is_inside & (self.near_m.ravel()[nearest] > THROUGH * z)
        return color, is_seen, is_through

    def _cells(self, x: FloatImage, y: FloatImage) -> tuple[NDArray[np.int64], ...]:
        """Return the pixel whose middle lies left above each point, and how far the point is."""
        left, top = self.view.corner
        column, row = x - np.float32(left + 0.5), y - np.float32(top + 0.5)
        whole_column = np.floor(np.clip(column, -2, 1e6)).astype(np.int64)
        whole_row = np.floor(np.clip(row, -2, 1e6)).astype(np.int64)
        return whole_column, whole_row, column - whole_column, row - whole_row


def look_of(view: View) -> Look:
    """Make a frame ready to be asked."""
    depth_m = view.depth_m()
    near_m, far_m = of_nine(depth_m, np.minimum), of_nine(depth_m, np.maximum)
    is_clean = far_m <= near_m * np.float32(MIXED)
    return Look(view, depth_m, near_m, is_clean)
