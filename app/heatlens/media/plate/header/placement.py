"""Read the position and direction of the camera from an EXR header.

Here p_camera = M p_world acts on columns, lengths are meters, and the camera has x to the right,
y up and looks along -z.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heatlens.media.plate.header.channels import Header

Array = NDArray[np.float64]

PLACEMENT = "worldToCamera"
_RIGID_TOLERANCE = (
    1e-3  # tolerance of lengths and right angles for matrices in float32 or short decimals
)
_Z_BACKWARD = np.diag([1.0, 1.0, -1.0, 1.0])


def find_placement(headers: Sequence[Header]) -> Array | None:
    """Return the first finite 4 x 4 attribute `worldToCamera` in the headers of a file, or None."""
    for header in headers:
        value = np.asarray(header.get(PLACEMENT, ()))
        if value.shape == (4, 4) and value.dtype.kind == "f" and np.isfinite(value).all():
            return value.astype(np.float64)
    return None


def read_rigid_placement(attributes: Header, scene_unit_m: float) -> Array | None:
    """Return the world-to-camera matrix in meters from a header; None if it has no rigid one."""
    attribute = find_placement([attributes])
    if attribute is None:
        return None
    matrix, _ = convert_from_exr(attribute, scene_unit_m)
    return matrix if is_rigid(matrix) else None


def is_rigid(matrix: Array) -> bool:
    """Return whether a (4, 4) matrix keeps lengths, angles and right-handedness."""
    return bool(are_rigid(matrix[None])[0])


def are_rigid(matrices: Array) -> NDArray[np.bool_]:
    """Return a mask (F,) of the matrices (F, 4, 4) that keep lengths, angles and handedness."""
    matrices = matrices.reshape(-1, 4, 4)
    rotations = matrices[:, :3, :3]
    is_usable = np.asarray(np.isfinite(matrices).all((1, 2)) & (np.abs(rotations).max((1, 2)) <= 2))
    rotations = np.where(is_usable[:, None, None], rotations, 0.0)
    is_rotation = (np.abs(rotations @ rotations.swapaxes(1, 2) - np.eye(3)) < _RIGID_TOLERANCE).all(
        (1, 2)
    )
    is_rotation &= np.linalg.det(rotations) > 0
    last_rows = np.where(is_usable[:, None], matrices[:, 3], 0.0)
    return np.asarray(is_rotation & (np.abs(last_rows - (0, 0, 0, 1)) < _RIGID_TOLERANCE).all(1))


def convert_from_exr(attribute: Array, scene_unit_m: float) -> tuple[Array, bool]:
    """Return world to camera for an attribute `worldToCamera`, and whether it was left-handed.

    In OpenEXR's standard attributes points are rows and the camera looks along +z, so that a
    right-handed world is mirrored on its way into the camera. If the matrix does not mirror, the
    world is left-handed, as RenderMan's can be; its z axis is then reversed. The result is in
    meters and acts on columns.
    """
    matrix = _Z_BACKWARD @ np.asarray(attribute, np.float64).T
    is_left_handed = bool(np.linalg.det(matrix[:3, :3]) < 0)
    if is_left_handed:
        matrix = matrix @ _Z_BACKWARD
    matrix[:3, 3] *= scene_unit_m
    return matrix, is_left_handed
