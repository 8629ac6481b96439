"""Convert camera matrices between our convention and those of files and programs.

Here p_camera = M p_world acts on columns, lengths are meters, and the camera has x to the right,
y up and looks along -z, as in USD, Nuke and Blender. Numbers that a file keeps in float32 become
the short decimals that were meant.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.plate.header.placement import are_rigid

Matrix = tuple[tuple[float, ...], ...]  # four rows of four
Array = NDArray[np.float64]

# From a world with y up to one with z up: a quarter turn about x, for columns.
_Y_TO_Z = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
# Cosine of the middle angle below which the other two angles rotate about the same axis.
_GIMBAL = 1e-7
_DIGITS_MOST = 9  # enough digits to distinguish any two float32


def matrix_of(rows: Iterable[Iterable[float]]) -> Matrix:
    """Return four rows of four plain floats; raise InputError for another shape."""
    matrix = tuple(tuple(map(float, row)) for row in rows)
    if [len(row) for row in matrix] != [4] * 4:
        raise InputError("The placement of a camera is a matrix: four rows of four numbers.")
    return matrix


def check_rigid(matrices: Sequence[Matrix], frames: Sequence[int]) -> None:
    """Raise InputError with the first frame whose matrix is not a rotation and translation."""
    for frame, is_rigid in zip(frames, are_rigid(np.array(matrices)), strict=True):
        if not is_rigid:
            raise InputError(
                f"Frame {frame}: the matrix that places the camera scales, shears, mirrors or is "
                "not finite: export position and rotation alone."
            )


def camera_to_world(matrices: Sequence[Matrix], up_axis: str, target_up_axis: str) -> Array:
    """Return the camera-to-world matrices, (N, 4, 4), with `target_up_axis` as the up axis.

    `up_axis` is the axis that points up in the world of `matrices`, which are world to camera.
    """
    camera_matrices: Array = np.linalg.inv(np.array(matrices, np.float64))
    if up_axis == target_up_axis:
        return camera_matrices
    return (_Y_TO_Z if target_up_axis == "z" else _Y_TO_Z.T) @ camera_matrices


def euler_deg(rotations: Array, order: str) -> Array:
    """Return angles (N, 3) in degrees about x, y and z for rotations (N, 3, 3).

    The angles do not jump from frame to frame. `order` is XYZ or ZXY; its first letter is the axis
    that is turned about first: XYZ is the matrix Rz Ry Rx.
    """
    axes = ["XYZ".index(letter) for letter in order]
    m = rotations[:, axes][
        :, :, axes
    ]  # the order is cyclic, so that renamed axes stay right-handed
    cosine = np.hypot(m[:, 0, 0], m[:, 1, 0])
    is_locked = cosine < _GIMBAL
    first = np.where(
        is_locked, np.arctan2(-m[:, 1, 2], m[:, 1, 1]), np.arctan2(m[:, 2, 1], m[:, 2, 2])
    )
    last = np.where(is_locked, 0.0, np.arctan2(m[:, 1, 0], m[:, 0, 0]))
    angles = np.empty((len(rotations), 3))
    angles[:, axes] = np.stack([first, np.arctan2(-m[:, 2, 0], cosine), last], axis=1)
    return np.unwrap(np.degrees(angles), axis=0, period=360.0)


def shortest_decimal(stored: float, unit: float = 1.0) -> float:
    """Return the shortest decimal that becomes the same float32 as `stored`: 1.3, not 1.29999995.

    `stored` is in the unit of the file, and the result is `stored` / `unit`.
    """
    value = stored / unit
    rounded = np.float32(stored)
    for digits in range(1, _DIGITS_MOST + 1):
        decimal = float(f"{value:.{digits}g}")
        if np.float32(decimal * unit) == rounded:
            return decimal
    return value
