"""Orbit, pan and dolly of a camera, as in every 3D program.

All keep the world's y upright and take a pivot, the point the camera looks at, in metres.
"""

import math

import numpy as np

from heatlens.core.model.shot.framing import Array, Pose, Vector, looking_at, pose_of

_STEEPEST = math.radians(89.0)  # beyond it the picture would turn over
_NEAREST = 0.05  # smallest share of the way to the pivot that a step leaves


def orbited(pose: Pose, pivot_m: Vector, turn_rad: float, tilt_rad: float) -> Pose:
    """Orbit the pivot: `turn_rad` to the right about the vertical, `tilt_rad` upwards."""
    arm = np.subtract(pose.position_m, pivot_m)
    radius = float(np.linalg.norm(arm))
    if radius < 1e-9:
        return pose
    heading = math.atan2(arm[0], arm[2]) + turn_rad
    height = math.asin(np.clip(arm[1] / radius, -1.0, 1.0)) + tilt_rad
    height = min(max(height, -_STEEPEST), _STEEPEST)
    flat = radius * math.cos(height)
    eye = np.add(
        pivot_m, (flat * math.sin(heading), radius * math.sin(height), flat * math.cos(heading))
    )
    return looking_at((float(eye[0]), float(eye[1]), float(eye[2])), pivot_m)


def panned(pose: Pose, right_m: float, up_m: float) -> Pose:
    """Move the camera sideways or up without turning it."""
    return _moved(pose, pose.turn @ (right_m, up_m, 0.0))


def dollied(pose: Pose, pivot_m: Vector, share: float) -> Pose:
    """Move towards the pivot by a share of the way, or away from it if negative.

    The camera never passes through the pivot.
    """
    way = np.subtract(pivot_m, pose.position_m)
    return _moved(pose, way * min(share, 1.0 - _NEAREST))


def pivot_of(pose: Pose, distance_m: float) -> Vector:
    """Return the point straight ahead at a distance."""
    x, y, z = pose.position_m - pose.turn[:, 2] * distance_m
    return float(x), float(y), float(z)


def _moved(pose: Pose, by_m: Array) -> Pose:
    matrix = pose.camera_to_world
    matrix[:3, 3] += by_m
    return pose_of(matrix)
