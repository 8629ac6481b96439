"""Orbit, pan and dolly of a camera, as in every 3D program.

All keep the world's y upright and take a pivot, the point the camera looks at, in meters.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from heatlens.core.model.shot.camera_track import Array, Pose, Vector, pose_looking_at, pose_of

_STEEPEST = math.radians(89.0)  # beyond it the picture would turn over
_NEAREST = 0.05  # smallest share of the distance to the pivot that a step leaves


def orbit_camera(pose: Pose, pivot_m: Vector, turn_rad: float, tilt_rad: float) -> Pose:
    """Return the camera after an orbit of the pivot by `turn_rad` to the right, `tilt_rad` up."""
    pivot_to_camera = np.subtract(pose.position_m, pivot_m)
    radius = float(np.linalg.norm(pivot_to_camera))
    if radius < 1e-9:
        return pose
    heading = math.atan2(pivot_to_camera[0], pivot_to_camera[2]) + turn_rad
    elevation = math.asin(np.clip(pivot_to_camera[1] / radius, -1.0, 1.0)) + tilt_rad
    elevation = min(max(elevation, -_STEEPEST), _STEEPEST)
    horizontal_radius = radius * math.cos(elevation)
    eye = np.add(
        pivot_m,
        (
            horizontal_radius * math.sin(heading),
            radius * math.sin(elevation),
            horizontal_radius * math.cos(heading),
        ),
    )
    return pose_looking_at((float(eye[0]), float(eye[1]), float(eye[2])), pivot_m)


def pan_camera(pose: Pose, right_m: float, up_m: float) -> Pose:
    """Return the camera moved sideways and up without turning it."""
    return _translate(pose, pose.turn @ (right_m, up_m, 0.0))


def dolly_camera(pose: Pose, pivot_m: Vector, share: float) -> Pose:
    """Return the camera moved towards the pivot by a share of the distance; away if negative.

    The camera never passes through the pivot.
    """
    camera_to_pivot = np.subtract(pivot_m, pose.position_m)
    return _translate(pose, camera_to_pivot * min(share, 1.0 - _NEAREST))


def pivot_of(pose: Pose, distance_m: float) -> Vector:
    """Return the point straight ahead at a distance."""
    x, y, z = pose.position_m - pose.turn[:, 2] * distance_m
    return float(x), float(y), float(z)


def _translate(pose: Pose, by_m: Array) -> Pose:
    """Return the pose, moved by a vector in the world."""
    matrix = pose.camera_to_world
    matrix[:3, 3] += by_m
    return pose_of(matrix)


@dataclass(frozen=True, slots=True)
class CameraDrag:
    """A mouse movement, right and down as shares of the picture's height, or in notches."""

    kind: Literal["orbit", "truck", "dolly"]
    right: float = 0.0
    down: float = 0.0
