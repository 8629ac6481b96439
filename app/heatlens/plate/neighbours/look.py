"""Ask one frame about points in space: whether it sees them, sees through them, or neither."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.neighbours.nearby import of_nine
from heatlens.plate.neighbours.view import NEAR_M, View, depth_of
from heatlens.plate.plate import FloatImage

Flags = NDArray[np.bool_]
MIXED = 1.1  # depth ratio of neighbouring pixels from which one may be a mixture
SAME = 0.01  # relative depth difference within which two frames see the same surface
THROUGH = 1.02  # depth ratio from which a frame sees through a point
_LEAST_WEIGHT = 0.1  # least share of the four pixels around a point that must show its surface


@dataclass(frozen=True, eq=False)
class Look:
    """A frame, prepared for questions about points.

    depth_m   (H, W) over the data window
    near_m    (H, W) the nearest depth within a pixel
    far_m     (H, W) the farthest
    is_clean  (H, W) pixels that show one surface
    """

    view: View
    depth_m: FloatImage
    near_m: FloatImage
    far_m: FloatImage
    is_clean: Flags

    def answers(
        self, x: FloatImage, y: FloatImage, z: FloatImage
    ) -> tuple[FloatImage, Flags, Flags]:
        """Return colours (N, 4), which points are seen, and which are seen through.

        Where a point is neither seen nor seen through, it is hidden or outside the picture.
        """
        height, width = self.depth_m.shape
        left, top = self.view.corner
        across, down = x - np.float32(left), y - np.float32(top)
        is_inside = (across >= 0) & (across < width) & (down >= 0) & (down < height) & (z > NEAR_M)
        at = np.where(is_inside, down, 0).astype(np.int32) * np.int32(width)
        at += np.where(is_inside, across, 0).astype(np.int32)
        near_m = self.near_m.ravel()[at]
        is_through = is_inside & (near_m > THROUGH * z)
        is_seen = is_inside & (near_m < (1 + SAME) * z) & (self.far_m.ravel()[at] > (1 - SAME) * z)
        some = np.flatnonzero(is_seen)
        color = np.zeros((len(x), 4), np.float32)
        color[some], total = self._between(across[some], down[some], z[some])
        is_seen[some] = total > _LEAST_WEIGHT
        return color, is_seen, is_through

    def _between(
        self, x: FloatImage, y: FloatImage, z: FloatImage
    ) -> tuple[FloatImage, FloatImage]:
        """Return colours (N, 4) between pixels that show the depth, and the weight of these."""
        height, width = self.depth_m.shape
        x, y = x - np.float32(0.5), y - np.float32(0.5)
        column, row = np.floor(x), np.floor(y)
        right, down = x - column, y - row
        pixels, depth_m = self.view.plate.color.reshape(-1, 4), self.depth_m.ravel()
        total = np.zeros(len(x), np.float32)
        color = np.zeros((len(x), 4), np.float32)
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            at = np.clip(row + j, 0, height - 1).astype(np.int32) * np.int32(width)
            at += np.clip(column + i, 0, width - 1).astype(np.int32)
            is_same = (np.abs(depth_m[at] - z) < SAME * z) & self.is_clean.ravel()[at]
            weight = (right if i else 1 - right) * (down if j else 1 - down) * is_same
            total += weight
            color += weight[:, None] * pixels[at]
        color /= np.maximum(total, np.float32(_LEAST_WEIGHT))[:, None]
        return color, total


def look_of(view: View) -> Look:
    """Prepare a frame for questions about points."""
    depth_m = depth_of(view.plate)
    near_m, far_m = of_nine(depth_m, np.minimum), of_nine(depth_m, np.maximum)
    is_clean = far_m <= near_m * np.float32(MIXED)
    return Look(view, depth_m, near_m, far_m, is_clean)
