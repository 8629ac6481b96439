"""Convert camera matrices between our convention and those of files and programs.

Here p_camera = M p_world acts on columns, lengths are metres, and the camera has x to the right,
y up and looks along -z, as in USD, Nuke and Blender.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from heatlens.base.errors import InputError

Matrix = tuple[tuple[float, ...], ...]  # four rows of four
Array = NDArray[np.float64]

_RIGID = 1e-3  # tolerance of lengths and right angles for matrices in float32 or short decimals
_Z_BACKWARD = np.diag([1.0, 1.0, -1.0, 1.0])
# From a world with y up to one with z up: a quarter turn about x, for columns.
_Y_TO_Z = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
_GIMBAL = 1e-7  # cosine below which two of the three angles rotate about the same axis


def matrix_of(rows: Iterable[Iterable[float]]) -> Matrix:
    """Return four rows of four plain floats; raise InputError for another shape."""
    matrix = tuple(tuple(map(float, row)) for row in rows)
    if [len(row) for row in matrix] != [4] * 4:
        raise InputError("A placement has four rows of four numbers.")
    return matrix


def check_rigid(matrices: Sequence[Matrix], frames: Sequence[int]) -> None:
    """Raise InputError that names the first frame whose matrix is no rotation and translation."""
    for frame, is_one in zip(frames, are_rigid(np.array(matrices)), strict=True):
        if not is_one:
            raise InputError(
                f"Frame {frame}: the placement cannot be a camera's: it scales, shears, mirrors "
                "or is not finite."
            )


def is_rigid(matrix: Array) -> bool:
    """Return whether a (4, 4) matrix keeps lengths, angles and right-handedness."""
    return bool(are_rigid(matrix[None])[0])


def are_rigid(matrices: Array) -> NDArray[np.bool_]:
    """Return a mask (F,) of the matrices (F, 4, 4) that keep lengths, angles and handedness."""
    matrices = matrices.reshape(-1, 4, 4)
    turns = matrices[:, :3, :3]
    is_usable = np.asarray(np.isfinite(matrices).all((1, 2)) & (np.abs(turns).max((1, 2)) <= 2))
    turns = np.where(is_usable[:, None, None], turns, 0.0)
    is_turn = (np.abs(turns @ turns.swapaxes(1, 2) - np.eye(3)) < _RIGID).all((1, 2))
    is_turn &= np.linalg.det(turns) > 0
    last = np.where(is_usable[:, None], matrices[:, 3], 0.0)
    return np.asarray(is_turn & (np.abs(last - (0, 0, 0, 1)) < _RIGID).all(1))


def from_exr(attribute: Array, scene_unit_m: float) -> tuple[Array, bool]:
    """Return world to camera for an attribute `worldToCamera`, and whether it was left-handed.

    In OpenEXR's standard attributes points are rows and the camera looks along +z, so that a
    right-handed world is mirrored on its way into the camera. If the matrix does not mirror, the
    world is left-handed, as RenderMan's can be; its z axis is then reversed. The result is in
    metres and acts on columns.
    """
    matrix = _Z_BACKWARD @ np.asarray(attribute, np.float64).T
    is_left_handed = bool(np.linalg.det(matrix[:3, :3]) < 0)
    if is_left_handed:
        matrix = matrix @ _Z_BACKWARD
    matrix[:3, 3] *= scene_unit_m
    return matrix, is_left_handed


def camera_to_world(matrices: Sequence[Matrix], up_axis: str, wanted_up: str) -> Array:
    """Return the camera-to-world matrices, (N, 4, 4), with `wanted_up` as the up axis.

    `up_axis` is the axis that points up in the world of `matrices`, which are world to camera.
    """
    placed: Array = np.linalg.inv(np.array(matrices, np.float64))
    if up_axis == wanted_up:
        return placed
    return (_Y_TO_Z if wanted_up == "z" else _Y_TO_Z.T) @ placed


def euler_deg(turns: Array, order: str) -> Array:
    """Return angles (N, 3) in degrees about x, y and z for rotations (N, 3, 3).

    The angles do not jump from frame to frame. `order` is XYZ or ZXY and begins with the axis that
    is turned about first: XYZ is Rz Ry Rx.
    """
    axes = ["XYZ".index(letter) for letter in order]
    m = turns[:, axes][:, :, axes]  # the order is cyclic, so that renamed axes stay right-handed
    cosine = np.hypot(m[:, 0, 0], m[:, 1, 0])
    locked = cosine < _GIMBAL
    first = np.where(
        locked, np.arctan2(-m[:, 1, 2], m[:, 1, 1]), np.arctan2(m[:, 2, 1], m[:, 2, 2])
    )
    last = np.where(locked, 0.0, np.arctan2(m[:, 1, 0], m[:, 0, 0]))
    angles = np.empty((len(turns), 3))
    angles[:, axes] = np.stack([first, np.arctan2(-m[:, 2, 0], cosine), last], axis=1)
    return np.unwrap(np.degrees(angles), axis=0, period=360.0)
