"""How far two points of a picture are from each other in the world that it shows."""

import math
from dataclasses import dataclass

from heatlens.model.view_geometry import PictureShape

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole camera: its lens, and the shape of its picture."""

    focal_length_mm: float
    sensor_width_mm: float
    shape: PictureShape

    def point_m(self, pixel: tuple[int, int], depth_m: float) -> Vector:
        """Return where the middle of a pixel lies: right of, below and in front of the camera.

        `depth_m` is measured along the axis. The sensor is as wide as the picture.
        """
        pitch_x = self.sensor_width_mm / self.shape.width_px / self.focal_length_mm
        pitch_y = pitch_x / self.shape.pixel_aspect
        middle_x, middle_y = self.shape.middle_px
        across = (pixel[0] + 0.5 - middle_x) * pitch_x
        down = (pixel[1] + 0.5 - middle_y) * pitch_y
        return across * depth_m, down * depth_m, depth_m


def distance_m(a: Vector, b: Vector) -> float:
    """Return the distance of two points in metres."""
    return math.dist(a, b)
