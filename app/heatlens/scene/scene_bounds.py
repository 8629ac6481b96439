"""How large a scene and its objects are, and where to stand to see them."""

import math
from dataclasses import replace

import numpy as np

from heatlens.errors import InputError
from heatlens.model.framing import CameraTrack, Framing, Pose, PoseKey, looking_at, pose_of
from heatlens.model.lens import Lens
from heatlens.scene.scene import Array, Scene

_MARGIN = 1.15  # room around what is looked at
_FROM = np.array([0.35, 0.25, 1.0])  # a little from the right and from above


def bounds_m(scene: Scene, frame: float, name: str | None = None) -> Array:
    """(2, 3): least and greatest corner of the scene at a frame, or of the objects called `name`.

    NaN where no object has that name.
    """
    corners = [
        _corners(scene, i) @ matrix[:3, :3].T + matrix[:3, 3]
        for i, matrix in enumerate(scene.transforms_at(frame))
        if name is None or scene.instances[i].name == name
    ]
    if not corners:
        return np.full((2, 3), np.nan)
    points = np.concatenate(corners)
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _corners(scene: Scene, instance: int) -> Array:
    """(8, 3) of the box around an instance's mesh, where it was made."""
    positions = scene.meshes[scene.instances[instance].mesh].positions_m
    low, high = positions.min(axis=0), positions.max(axis=0)
    picks = np.indices((2, 2, 2)).reshape(3, 8).T
    return np.asarray(np.where(picks == 0, low, high), np.float64)


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


def framed(box_m: Array, lens: Lens, aspect: float, turn: Array | None = None) -> Pose:
    """A place from which a box (2, 3) fills the picture, looked at along `turn`'s -z."""
    middle = box_m.mean(axis=0)
    radius = max(float(np.linalg.norm(box_m[1] - box_m[0])) / 2, 1e-6)
    half_width = lens.sensor_width_mm / (2 * lens.focal_length_mm)
    half_angle = np.arctan(half_width / max(aspect, 1.0))
    back = _FROM / np.linalg.norm(_FROM) if turn is None else turn[:, 2]
    eye = middle + back * _MARGIN * radius / np.sin(half_angle)
    if turn is not None:
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turn, eye
        return pose_of(matrix)
    return looking_at(_vector(eye), _vector(middle))


def _vector(values: Array) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


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
    return CameraTrack((PoseKey(first, framed(bounds_m(scene, first), lens, aspect)),))


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
