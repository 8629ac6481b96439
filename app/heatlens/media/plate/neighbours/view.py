"""A frame of a sequence with its camera, and the motion of its points to another frame.

A `NeighborFrame` tests points in space: whether the frame sees them, sees through them, or neither.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.media.plate.neighbours.nearby import filter_three_by_three
from heatlens.media.plate.plate import FloatImage, Plate

FloatMatrix = NDArray[np.float64]
FAR_M = 1e6  # meters; farther points, such as the sky, move as if they were here
NEAR_M = 0.01  # meters; nearer points, and those behind the camera, are invisible
Flags = NDArray[np.bool_]
MIXED = 1.1  # depth ratio of neighboring pixels from which one may be a mixture
SAME = 0.01  # relative depth difference within which two frames see the same surface
THROUGH = 1.02  # depth ratio from which a frame sees through a point
_LEAST_WEIGHT = 0.1  # least share of the four pixels around a point that must show its surface


@dataclass(frozen=True, eq=False)
class View:
    """One frame of a sequence with the camera that saw it.

    world_to_camera  4x4 in meters, acts on columns; the camera looks along -z, its y axis is up
    focal_px         focal length in pixels along x and y
    centre_px        where the optical axis meets the picture, (x, y) in pixels from the upper left
                     corner of the display window; the middle of it unless the film is offset
    """

    frame: int
    plate: Plate
    world_to_camera: FloatMatrix
    focal_px: tuple[float, float]
    centre_px: tuple[float, float]

    @property
    def rays(self) -> FloatMatrix:
        """Matrix (3, 3) from a pixel (x, y, 1) to the point of its ray at 1 m before the camera."""
        (fx, fy), (cx, cy) = self.focal_px, self.centre_px
        return np.array([[1 / fx, 0, -cx / fx], [0, -1 / fy, cy / fy], [0, 0, -1]])

    @property
    def corner(self) -> tuple[int, int]:
        """The upper left corner (x, y) of the data window, from that of the display window."""
        return self.plate.data_window.relative_to(self.plate.display_window).corner


def depth_of(plate: Plate) -> FloatImage:
    """Return the depth (H, W) of a plate that has distances, `FAR_M` at most."""
    assert plate.depth_m is not None
    return np.minimum(plate.depth_m, np.float32(FAR_M))


@dataclass(frozen=True, eq=False)
class Motion:
    """The map of points of one view to another: (x w, y w, w) = z turn (x', y', 1) + shift.

    In the first view a point is at pixel x', y' with depth z, in the second at pixel x, y with
    depth w. Depths are in meters.
    """

    turn: FloatMatrix  # 3x3
    shift: FloatMatrix  # (3,)

    def move_points(
        self, x: FloatImage, y: FloatImage, z: FloatImage
    ) -> tuple[FloatImage, FloatImage, FloatImage]:
        """Return x, y in pixels and the depth in meters of moved points; the arrays broadcast."""
        turn, shift = self.turn.astype(np.float32), self.shift.astype(np.float32)
        moved = [
            z * (row[0] * x + (row[1] * y + row[2])) + offset
            for row, offset in zip(turn, shift, strict=True)
        ]
        depth = np.maximum(
            moved[2], np.float32(1e-6)
        )  # x and y of points behind the camera are never used
        return moved[0] / depth, moved[1] / depth, moved[2]


def motion_between(source: View, target: View) -> Motion:
    """Return the map from pixels and depths in `source` to those in `target`."""
    move = target.world_to_camera @ np.linalg.inv(source.world_to_camera)
    project = np.linalg.inv(target.rays)
    turn: FloatMatrix = project @ move[:3, :3] @ source.rays
    return Motion(turn, np.asarray(project @ move[:3, 3], np.float64))


@dataclass(frozen=True, eq=False)
class NeighborFrame:
    """A frame, prepared to test points in space against its depth.

    depth_m   (H, W) over the data window
    near_m    (H, W) the nearest depth in the 3 x 3 pixels around each
    far_m     (H, W) the farthest depth there
    is_clean  (H, W) pixels that show one surface, and are no mixture of two
    """

    view: View
    depth_m: FloatImage
    near_m: FloatImage
    far_m: FloatImage
    is_clean: Flags

    def test_points(
        self, x: FloatImage, y: FloatImage, z: FloatImage
    ) -> tuple[FloatImage, Flags, Flags]:
        """Return colors (N, 4), a mask of the points that are seen, and one of those seen through.

        A point that is neither seen nor seen through is hidden or outside the picture.
        """
        height, width = self.depth_m.shape
        left, top = self.view.corner
        across, down = x - np.float32(left), y - np.float32(top)
        is_inside = (across >= 0) & (across < width) & (down >= 0) & (down < height) & (z > NEAR_M)
        pixel = np.where(is_inside, down, 0).astype(np.int32) * np.int32(width)
        pixel += np.where(is_inside, across, 0).astype(np.int32)
        near_m = self.near_m.ravel()[pixel]
        is_through = is_inside & (near_m > THROUGH * z)
        is_seen = (
            is_inside & (near_m < (1 + SAME) * z) & (self.far_m.ravel()[pixel] > (1 - SAME) * z)
        )
        seen_points = np.flatnonzero(is_seen)
        color = np.zeros((len(x), 4), np.float32)
        color[seen_points], total = self._interpolate_color(
            across[seen_points], down[seen_points], z[seen_points]
        )
        is_seen[seen_points] = total > _LEAST_WEIGHT
        return color, is_seen, is_through

    def _interpolate_color(
        self, x: FloatImage, y: FloatImage, z: FloatImage
    ) -> tuple[FloatImage, FloatImage]:
        """Return colors (N, 4) interpolated over the pixels that show the depth `z`, and weights.

        A weight (N,) is the share of the four pixels around a point that show its depth.
        """
        height, width = self.depth_m.shape
        x, y = x - np.float32(0.5), y - np.float32(0.5)
        column, row = np.floor(x), np.floor(y)
        right, down = x - column, y - row
        pixels, depth_m = self.view.plate.color.reshape(-1, 4), self.depth_m.ravel()
        total = np.zeros(len(x), np.float32)
        color = np.zeros((len(x), 4), np.float32)
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            pixel = np.clip(row + j, 0, height - 1).astype(np.int32) * np.int32(width)
            pixel += np.clip(column + i, 0, width - 1).astype(np.int32)
            is_same = (np.abs(depth_m[pixel] - z) < SAME * z) & self.is_clean.ravel()[pixel]
            weight = (right if i else 1 - right) * (down if j else 1 - down) * is_same
            total += weight
            color += weight[:, None] * pixels[pixel]
        color /= np.maximum(total, np.float32(_LEAST_WEIGHT))[:, None]
        return color, total


def prepare_neighbor(view: View) -> NeighborFrame:
    """Return the frame of `view`, prepared to test points against its depth."""
    depth_m = depth_of(view.plate)
    near_m = filter_three_by_three(depth_m, np.minimum)
    far_m = filter_three_by_three(depth_m, np.maximum)
    is_clean = far_m <= near_m * np.float32(MIXED)
    return NeighborFrame(view, depth_m, near_m, far_m, is_clean)
