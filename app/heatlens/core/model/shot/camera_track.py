"""The pose of the camera at each frame.

The world is right-handed with y up, in meters; the camera has x to the right, y up, and looks
along -z, as in glTF and USD.
"""

from bisect import bisect_right
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves import key_edits
from heatlens.core.model.curves.frames import check_frame

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Array = NDArray[np.float64]
_FAR_MOST_M = 1e9
_UNIT = 1e-12  # a length this near to 1 differs from it only by rounding


@dataclass(frozen=True, slots=True)
class Pose:
    """The position and the orientation of a camera.

    position_m   in the world
    orientation  unit quaternion w, x, y, z: turns the camera's axes into the world's

    Raises InputError for values that are not a position or a rotation.
    """

    position_m: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not np.abs(self.position_m).max() <= _FAR_MOST_M:
            raise InputError(
                f"A camera stands at a finite place within {_FAR_MOST_M:g} m of the origin, not "
                f"at {self.position_m} m: export it again, and look at its unit."
            )
        length = float(np.linalg.norm(self.orientation))
        if not 1e-6 < length < 1e6:
            raise InputError(
                f"The camera looks nowhere: its orientation, {self.orientation}, has no length. "
                "Export the camera again."
            )
        if abs(length - 1.0) < _UNIT:
            length = 1.0  # so that a pose made from the values of another is equal to the last bit
        unit = tuple(float(value) / length for value in self.orientation)
        object.__setattr__(self, "orientation", unit)
        object.__setattr__(self, "position_m", tuple(map(float, self.position_m)))

    @property
    def turn(self) -> Array:
        """The rotation matrix (3, 3) whose columns are the camera's axes in the world."""
        w, x, y, z = self.orientation
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    @property
    def camera_to_world(self) -> Array:
        """The matrix (4, 4) from camera to world, for points as columns."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self.turn, self.position_m
        return matrix

    @property
    def world_to_camera(self) -> Array:
        """The matrix (4, 4) from world to camera, for points as columns."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.turn.T
        matrix[:3, 3] = -self.turn.T @ np.array(self.position_m)
        return matrix


def pose_of(camera_to_world: Array) -> Pose:
    """Return the pose of a rigid (4, 4) matrix for columns; a scale in it is left out."""
    turn = camera_to_world[:3, :3] / np.linalg.norm(camera_to_world[:3, :3], axis=0)
    return Pose(_vector(camera_to_world[:3, 3]), _quaternion(turn))


def pose_looking_at(eye_m: Vector, target_m: Vector) -> Pose:
    """Return a camera at `eye_m` with `target_m` in the middle of its picture.

    Raises InputError if both are the same. Straight up or down, the picture's top is -z.
    """
    back = np.subtract(eye_m, target_m)
    if np.linalg.norm(back) < 1e-12:
        raise InputError("A camera cannot look at the place where it stands.")
    back = back / np.linalg.norm(back)
    side = np.cross((0.0, 1.0, 0.0), back)
    if np.linalg.norm(side) < 1e-6:
        side = np.cross((0.0, 0.0, -1.0 if back[1] > 0 else 1.0), back)
    side = side / np.linalg.norm(side)
    turn = np.stack([side, np.cross(back, side), back], axis=1)
    return Pose(_vector(eye_m), _quaternion(turn))


def _vector(values: ArrayLike) -> Vector:
    x, y, z = map(float, np.asarray(values))
    return x, y, z


def _quaternion(turn: Array) -> Quaternion:
    """Return the quaternion w, x, y, z of a rotation matrix (3, 3), by Shepperd's method.

    It takes the largest component first, so that nothing divides by a small number.
    """
    # Four times the squares of w, x, y and z. Row k below is the quaternion, times four times its
    # component k.
    trace = np.trace(turn)
    squares = np.array([trace, *(2 * turn[i, i] - trace for i in range(3))]) + 1.0
    k = int(np.argmax(squares))
    m = turn
    rows = (
        (squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]),
        (m[2, 1] - m[1, 2], squares[1], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2]),
        (m[0, 2] - m[2, 0], m[1, 0] + m[0, 1], squares[2], m[2, 1] + m[1, 2]),
        (m[1, 0] - m[0, 1], m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], squares[3]),
    )
    quaternion = np.array(rows[k]) / np.linalg.norm(rows[k])
    w, x, y, z = map(float, quaternion if quaternion[0] >= 0 else -quaternion)
    return w, x, y, z


@dataclass(frozen=True, slots=True)
class PoseKey:
    """The pose of a camera at a frame."""

    frame: float
    pose: Pose


@dataclass(frozen=True, slots=True)
class CameraTrack:
    """The pose of a camera over frames: through its keys, and constant before and after them.

    Raises InputError for keys out of order, or none at all.
    """

    keys: tuple[PoseKey, ...]

    def __post_init__(self) -> None:
        if not self.keys:
            raise InputError("A camera track needs at least one key.")
        for key in self.keys:
            check_frame(key.frame)
        frames = [key.frame for key in self.keys]
        if any(b <= a for a, b in pairwise(frames)):
            raise InputError(
                "The keys of a camera must be sorted by frame, with one key at each frame."
            )

    @property
    def is_moving(self) -> bool:
        """True for more than one key."""
        return len(self.keys) > 1

    def pose_at(self, frame: float) -> Pose:
        """Return the pose on a cubic through the keys without jumps of speed.

        Source: Catmull and Rom 1974, with uneven spacing. Orientations are interpolated by
        component and normalized, as is usual for rotations of less than a right angle between keys.
        """
        keys = self.keys
        next_index = bisect_right([key.frame for key in keys], frame)
        if next_index in (0, len(keys)):
            return keys[min(next_index, len(keys) - 1)].pose
        values = _align_signs(keys)
        values_at = _hermite([key.frame for key in keys], values, next_index, frame)
        x, y, z, *orientation = map(float, values_at)
        return Pose((x, y, z), (orientation[0], orientation[1], orientation[2], orientation[3]))

    def with_key(self, frame: float, pose: Pose) -> "CameraTrack":
        """Return the track with a key at a frame, which replaces one that is there."""
        return self.paste_keys([PoseKey(frame, pose)], 0.0)

    def without_key(self, frame: float) -> "CameraTrack":
        """Return the track without the key at a frame; the last key stays."""
        return self.without_keys((frame,)) if len(self.keys) > 1 else self

    def without_keys(self, frames: Collection[float]) -> "CameraTrack":
        """Return the track without these keys. Raises InputError if none would be left."""
        return CameraTrack(tuple(key for key in self.keys if key.frame not in frames))

    def move_keys(self, frames: Collection[float], by_frames: float) -> "CameraTrack":
        """Return the track with the keys at these frames moved; they replace those they land on."""
        return CameraTrack(key_edits.move_keys(self.keys, frames, by_frames))

    def ripple_keys(self, from_frame: float, by_frames: float) -> "CameraTrack":
        """Return the track with keys from `from_frame` on moved; they replace keys in between."""
        return CameraTrack(key_edits.ripple_keys(self.keys, from_frame, by_frames))

    def paste_keys(self, keys: Iterable[PoseKey], at_frame: float) -> "CameraTrack":
        """Return the track with copied keys from `at_frame` on.

        They replace those at their frames.
        """
        return CameraTrack(key_edits.paste_keys(self.keys, keys, at_frame))


def _align_signs(keys: Sequence[PoseKey]) -> Array:
    """Return the positions and quaternions of K keys (K, 7).

    A quaternion and its negative are the same rotation. Each has the sign with which it is nearer
    to the one before, so that interpolation takes the short way.
    """
    rows = np.array([(*key.pose.position_m, *key.pose.orientation) for key in keys])
    for i in range(1, len(rows)):
        if rows[i, 3:] @ rows[i - 1, 3:] < 0:
            rows[i, 3:] *= -1
    return rows


def _hermite(frames: list[float], values: Array, next_index: int, frame: float) -> Array:
    """Return the values at `frame` of the cubic that ends at the key `next_index`."""
    index = next_index - 1
    span = frames[next_index] - frames[index]
    t = (frame - frames[index]) / span
    first_slope, last_slope = (_slope(frames, values, i) * span for i in (index, next_index))
    a, b = values[index], values[next_index]
    return np.asarray(
        (1 + 2 * t) * (1 - t) ** 2 * a
        + t * (1 - t) ** 2 * first_slope
        + t * t * (3 - 2 * t) * b
        + t * t * (t - 1) * last_slope
    )


def _slope(frames: list[float], values: Array, i: int) -> Array:
    """Return the slope between the neighbors of key `i`; 0 at the ends, where the camera rests."""
    if i in (0, len(frames) - 1):
        return np.zeros_like(values[i])
    return np.asarray((values[i + 1] - values[i - 1]) / (frames[i + 1] - frames[i - 1]))
