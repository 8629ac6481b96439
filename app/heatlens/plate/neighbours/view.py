"""A frame of a sequence with its camera, and the motion of its points to another frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.plate import FloatImage, Plate

FloatMatrix = NDArray[np.float64]
FAR_M = 1e6  # metres; farther points, such as the sky, move as if they were here
NEAR_M = 0.01  # metres; nearer points, and those behind the camera, are invisible


@dataclass(frozen=True, eq=False)
class View:
    """One frame of a sequence with the camera that saw it.

    world_to_camera  4x4 in metres, acts on columns; the camera looks along -z, its y axis is up
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
        """3x3: from a pixel (x, y, 1) to the point of its ray that lies 1 m before the camera."""
        (fx, fy), (cx, cy) = self.focal_px, self.centre_px
        return np.array([[1 / fx, 0, -cx / fx], [0, -1 / fy, cy / fy], [0, 0, -1]])

    @property
    def corner(self) -> tuple[int, int]:
        """The upper left corner of the data window, from that of the display window."""
        data, shown = self.plate.data_window, self.plate.display_window
        return data.x0 - shown.x0, data.y0 - shown.y0


def depth_of(plate: Plate) -> FloatImage:
    """Return the depth (H, W) of a plate that has distances, `FAR_M` at most."""
    assert plate.depth_m is not None
    return np.minimum(plate.depth_m, np.float32(FAR_M))


@dataclass(frozen=True, eq=False)
class Motion:
    """Where the points of one view are in another: (x w, y w, w) = z turn (x', y', 1) + shift.

    Here z is the depth in the first view and w that in the second, in metres.
    """

    turn: FloatMatrix  # 3x3
    shift: FloatMatrix  # (3,)

    def moved(
        self, x: FloatImage, y: FloatImage, z: FloatImage
    ) -> tuple[FloatImage, FloatImage, FloatImage]:
        """Return x, y in pixels and the depth in metres of points, which broadcast."""
        turn, shift = self.turn.astype(np.float32), self.shift.astype(np.float32)
        moved = [
            z * (row[0] * x + (row[1] * y + row[2])) + by
            for row, by in zip(turn, shift, strict=True)
        ]
        depth = np.maximum(
            moved[2], np.float32(1e-6)
        )  # x and y of points behind the camera are never used
        return moved[0] / depth, moved[1] / depth, moved[2]


def motion(source: View, target: View) -> Motion:
    """Return how points seen from `source` appear from `target`."""
    move = target.world_to_camera @ np.linalg.inv(source.world_to_camera)
    project = np.linalg.inv(target.rays)
    turn: FloatMatrix = project @ move[:3, :3] @ source.rays
    return Motion(turn, np.asarray(project @ move[:3, 3], np.float64))
