"""How large a scene and its objects are, and where to stand to see them."""

import math
from dataclasses import replace

import numpy as np

from heatlens.errors import InputError
from heatlens.model.framing import CameraTrack, Framing, Pose, PoseKey, looking_at, pose_of
from heatlens.model.lens import Lens
from heatlens.scene.corners import placed_corners
from heatlens.scene.scene import Array, Scene

_MARGIN = 1.15  # room around what is looked at
_CLOSEST = 1e-3  # of its size: as near as a camera comes to what is looked at
_FROM = (0.35, 0.25, 1.0)  # a little from the right and from above


def bounds_m(scene: Scene, frame: float, name: str | None = None) -> Array:
    """(2, 3): least and greatest corner of the scene at a frame, or of the objects called `name`.

    NaN where no object has that name.
    """
    points = corners_m(scene, frame, name)
    return _box(points) if len(points) else np.full((2, 3), np.nan)


def corners_m(scene: Scene, frame: float, name: str | None = None) -> Array:
    """(N, 3): the corners of the boxes around all things at a frame, or those called `name`."""
    boxes, places = scene.boxes_m, scene.transforms_at(frame)
    if name is not None:
        chosen = np.array([instance.name == name for instance in scene.instances])
        boxes, places = boxes[chosen], places[chosen]
    return placed_corners(boxes, places).reshape(-1, 3)


def _box(points: Array) -> Array:
    return np.stack([points.min(axis=0), points.max(axis=0)])


def object_names(scene: Scene) -> tuple[str, ...]:
    """Each once, in the order of the file."""
    return tuple(dict.fromkeys(instance.name for instance in scene.instances))


def object_depth_m(scene: Scene, name: str, pose: Pose, frame: float) -> float:
    """Planar depth of the middle of the objects called `name`.

    Raises InputError for a name that no object has, and for what lies behind the camera.
    """
    middle = bounds_m(scene, frame, name).mean(axis=0)
    row = pose.world_to_camera[2]
    depth_m = -float(row[:3] @ middle + row[3])
    if math.isnan(depth_m):
        raise InputError(f"{scene.path} has no object called {name!r}.")
    if depth_m <= 0:
        raise InputError(f"{name} is behind the camera at frame {frame:g}.")
    return depth_m


def framed(points_m: Array, lens: Lens, aspect: float, turn: Array | None = None) -> Pose:
    """The nearest place from which points (N, 3) all lie in the picture but for a margin.

    The camera looks along `turn`'s -z, without one a little down and to the left, at the middle of
    the box around the points.
    """
    if turn is None:
        turn = looking_at(_FROM, (0.0, 0.0, 0.0)).turn
    box = _box(points_m)
    middle = box.mean(axis=0)
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    matrix[:3, 3] = middle + turn[:, 2] * _distance_m((points_m - middle) @ turn, lens, aspect)
    return pose_of(matrix)


def _distance_m(points: Array, lens: Lens, aspect: float) -> float:
    """From the origin back along z, for points (N, 3) in the camera's axes."""
    across = lens.sensor_width_mm / (2 * lens.focal_length_mm)  # half of what is seen at 1 m
    away = _MARGIN / across * (np.abs(points[:, :2]) * (1.0, aspect)).max(axis=1)
    # What is seen end-on has no width to keep the camera out of it.
    least = max(_CLOSEST * float(np.ptp(points, axis=0).max()), 1e-6)
    return float((points[:, 2] + np.maximum(away, least)).max())


def track_of(scene: Scene, framing: Framing, lens: Lens) -> CameraTrack:
    """The camera that a framing means; raises InputError for a name the scene does not have."""
    if framing.track is not None:
        return framing.track
    if framing.camera is not None:
        return scene.camera_named(framing.camera).track
    if scene.cameras:
        return scene.cameras[0].track
    first = scene.frames.first if scene.frames else 1
    aspect = framing.width_px / framing.height_px
    return CameraTrack((PoseKey(first, framed(corners_m(scene, first), lens, aspect)),))


def started_framing(scene: Scene, size: tuple[int, int] | None = None) -> Framing:
    """What of a scene is seen first: its first camera's picture."""
    framing = Framing() if size is None else Framing(*size)
    return replace(framing, camera=scene.cameras[0].name) if scene.cameras else framing


def camera_lens(scene: Scene, framing: Framing, lens: Lens) -> Lens:
    """`lens` with the angle of view of the scene's camera that is looked through."""
    if framing.camera is None:
        return lens
    camera = scene.camera_named(framing.camera)
    return replace(
        lens, focal_length_mm=camera.focal_length_mm, sensor_width_mm=camera.sensor_width_mm
    )
