"""Measure a scene and its objects, and place a camera to see them."""

import math

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import (
    CameraTrack,
    Pose,
    PoseKey,
    pose_looking_at,
    pose_of,
)
from heatlens.core.model.shot.framing import Framing
from heatlens.media.scene.scene import Array, Scene

# Of each of the eight corners, whether it takes the least (0) or greatest (1) value on each axis.
_PICKS = np.indices((2, 2, 2)).reshape(3, 8).T


def corners_of(boxes_m: Array) -> Array:
    """Return the corners (..., 8, 3) of boxes (..., 2, 3) of a least and a greatest corner."""
    return np.asarray(np.where(_PICKS == 0, boxes_m[..., :1, :], boxes_m[..., 1:, :]))


def transform_corners(boxes_m: Array, to_world: Array) -> Array:
    """Return the corners (N, 8, 3) of boxes (N, 2, 3) in the world.

    The matrices `to_world` (N, 4, 4) transform each box from its own axes.
    """
    rotated = corners_of(boxes_m) @ to_world[:, :3, :3].transpose(0, 2, 1)
    return np.asarray(rotated + to_world[:, None, :3, 3])


_MARGIN = 1.15  # factor for the space around the framed points
_CLOSEST_PART = 1e-3  # least distance of a camera from objects, relative to their size
_LARGE_M = 4.0  # a larger scene that is seen as a whole is sharp everywhere
_LEAST_PART, _MOST_PART = 0.05, 0.4  # size of a subject, as a part of the scene
_AROUND_SUBJECT = 1.0  # part of the subject's box that is framed, before the margin
_VIEW_FROM = (0.35, 0.25, 1.0)  # view direction: a little from the right and from above


def bounds_m(scene: Scene, frame: float, name: str | None = None) -> Array:
    """Return the least and the greatest corner (2, 3) of the scene at a frame.

    With `name`, return those of the objects of this name; NaN if there are none.
    """
    points = corners_m(scene, frame, name)
    return box_around(points) if len(points) else np.full((2, 3), np.nan)


def corners_m(scene: Scene, frame: float, name: str | None = None) -> Array:
    """Return the corners (N, 3) of the boxes around all objects, or around those called `name`."""
    if name is None:
        return box_corners_m(scene, frame).reshape(-1, 3)
    boxes, to_world = scene.boxes_at(frame), scene.transforms_at(frame)
    is_named = np.array([instance.name == name for instance in scene.instances])
    return transform_corners(boxes[is_named], to_world[is_named]).reshape(-1, 3)


def box_corners_m(scene: Scene, frame: float) -> Array:
    """Return the corners (N, 8, 3) of the box around each object at a frame."""
    return transform_corners(scene.boxes_at(frame), scene.transforms_at(frame))


def box_around(points_m: Array) -> Array:
    """Return the least and the greatest corner (2, 3) of points (..., 3)."""
    points = points_m.reshape(-1, 3)
    return np.stack([points.min(axis=0), points.max(axis=0)])


def object_names(scene: Scene) -> tuple[str, ...]:
    """Return the name of each object once, in the order of the file."""
    return tuple(dict.fromkeys(instance.name for instance in scene.instances))


def object_depth_m(scene: Scene, name: str, pose: Pose, frame: float) -> float:
    """Return the planar depth of the middle of the objects called `name`.

    Raises InputError for a name that no object has, and for an object behind the camera.
    """
    middle = bounds_m(scene, frame, name).mean(axis=0)
    row = pose.world_to_camera[2]
    depth_m = -float(row[:3] @ middle + row[3])
    if math.isnan(depth_m):
        raise InputError(f"{scene.path} has no object called {name!r}.")
    if depth_m <= 0:
        raise InputError(f"{name} is behind the camera at frame {frame:g}.")
    return depth_m


def frame_points(points_m: Array, lens: Lens, aspect: float, turn: Array | None = None) -> Pose:
    """Return the nearest pose from which all points (N, 3) are in the picture, with a margin.

    The camera looks along -z of `turn` at the middle of the box around the points. The default
    looks a little down and to the left.
    """
    if turn is None:
        turn = pose_looking_at(_VIEW_FROM, (0.0, 0.0, 0.0)).turn
    box = box_around(points_m)
    middle = box.mean(axis=0)
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    matrix[:3, 3] = middle + turn[:, 2] * _distance_m((points_m - middle) @ turn, lens, aspect)
    return pose_of(matrix)


def _distance_m(points: Array, lens: Lens, aspect: float) -> float:
    """Return the distance along z from which all points (N, 3), in camera axes, are visible."""
    half_width = lens.sensor_width_mm / (2 * lens.focal_length_mm)  # half the visible width at 1 m
    distances_m = _MARGIN / half_width * (np.abs(points[:, :2]) * (1.0, aspect)).max(axis=1)
    # Points on the axis have no width, so a least distance keeps the camera away from them.
    least_m = max(_CLOSEST_PART * float(np.ptp(points, axis=0).max()), 1e-6)
    return float((points[:, 2] + np.maximum(distances_m, least_m)).max())


def track_of(scene: Scene, framing: Framing, lens: Lens) -> CameraTrack:
    """Return the camera of a framing over its frames; raise InputError for an unknown name.

    A scene without cameras gets a view of all of it, or of its subject (see `subject_m`).
    """
    if framing.track is not None:
        return framing.track
    if framing.camera is not None:
        return scene.camera_named(framing.camera).track
    if scene.cameras:
        return scene.cameras[0].track
    first = scene.frames.first if scene.frames else 1
    aspect = framing.width_px / framing.height_px
    corners = corners_m(scene, first)
    whole_pose = frame_points(corners, lens, aspect)
    subject = subject_m(scene)
    if subject is None:
        return CameraTrack((PoseKey(first, whole_pose),))
    middle = subject.mean(axis=0)
    subject_points = middle + _AROUND_SUBJECT * (subject - middle)
    return CameraTrack(
        (PoseKey(first, frame_points(subject_points, lens, aspect, whole_pose.turn)),)
    )


def subject_m(scene: Scene) -> Array | None:
    """Return corners (8, 3) of the object to show first in a scene too large to show any blur.

    From a distance that shows a whole large scene, everything is sharp: the discs are about 0.8 w /
    (N L) of the picture's width for a scene of size L, a film back of width w and f-stop N. In that
    case the subject is the nearest object that is much smaller than the scene. Returns None if the
    scene is small enough to be seen as a whole, or no object is suitable.
    """
    first = scene.frames.first if scene.frames else 1
    corners = transform_corners(scene.boxes_at(first), scene.transforms_at(first)).reshape(-1, 8, 3)
    if not len(corners):
        return None
    low, high = corners.min(axis=1), corners.max(axis=1)
    scene_size, sizes = (high.max(axis=0) - low.min(axis=0)).max(), (high - low).max(axis=1)
    is_suitable = (sizes > _LEAST_PART * scene_size) & (sizes < _MOST_PART * scene_size)
    if not (scene_size > _LARGE_M and is_suitable.any()):
        return None
    view_axis = pose_looking_at(_VIEW_FROM, (0.0, 0.0, 0.0)).turn[:, 2]
    nearness = np.where(is_suitable, (low + high) @ view_axis, -np.inf)
    return np.asarray(corners[int(nearness.argmax())])


def first_framing(scene: Scene) -> Framing:
    """Return the first framing of a scene: the picture of its first camera."""
    return Framing(camera=scene.cameras[0].name) if scene.cameras else Framing()
