"""Find closed meshes (their inside is never visible) and how to detect their back faces."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.scene import Array, Mesh

# The same numbers as in shaders/scene_gpu/scene_cover.frag.glsl.
BACK_NONE, BACK_BY_NORMAL, BACK_COUNTERCLOCKWISE, BACK_CLOCKWISE = range(4)
_AGREEING = 0.999  # share of the area with one winding from which the winding shows the back
_MOST_TRIANGLES = 2_000_000  # a mesh with more is not examined and counts as open

Rules = NDArray[np.uint32]


class ClosedMeshes:
    """The meshes of a scene, each examined once."""

    def __init__(self, meshes: Sequence[Mesh], boxes_m: Array) -> None:
        self._of_mesh = np.array([back_rule(mesh) for mesh in meshes], np.uint32)
        self._boxes_m = boxes_m

    def rules(
        self, meshes: NDArray[np.int64], to_world: Array, to_object: Array, eye_m: Array
    ) -> Rules:
        """Return (N,) the rules of instances of `meshes` (N,) at (N, 4, 4) `to_world`.

        `to_object` holds the inverse matrices column by column. A closed mesh around the camera,
        such as a room, counts as open.
        """
        rules = self._of_mesh[meshes]
        is_ordered = rules >= BACK_COUNTERCLOCKWISE
        is_mirrored = np.linalg.det(to_world[:, :3, :3]) < 0
        swapped = BACK_COUNTERCLOCKWISE + BACK_CLOCKWISE - rules
        rules = np.where(is_ordered & is_mirrored, swapped, rules)
        eye = (np.append(eye_m, 1.0) @ to_object)[:, :3]
        boxes = self._boxes_m[meshes]
        is_inside = ((eye >= boxes[:, 0]) & (eye <= boxes[:, 1])).all(axis=1)
        return np.where(is_inside, BACK_NONE, rules).astype(np.uint32)


def back_rule(mesh: Mesh) -> int:
    """Return how to recognise the back faces of a mesh; BACK_NONE for an open mesh.

    The picture's rows run down, so a face that is counterclockwise from outside appears clockwise,
    and its back counterclockwise.
    """
    if not is_closed(mesh):
        return BACK_NONE
    corners = mesh.positions_m[mesh.triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = mesh.normals[mesh.triangles].astype(np.float64).sum(axis=1)
    along = (across * outward).sum(axis=1)
    area = np.linalg.norm(across, axis=1)
    agreeing = float(area[along >= 0].sum()) / max(float(area.sum()), 1e-30)
    if agreeing >= _AGREEING:
        return BACK_COUNTERCLOCKWISE
    return BACK_CLOCKWISE if agreeing <= 1 - _AGREEING else BACK_BY_NORMAL


def is_closed(mesh: Mesh) -> bool:
    """Return whether an even number of triangles meets in every edge, joining equal positions."""
    if not 0 < len(mesh.triangles) <= _MOST_TRIANGLES:
        return False
    positions = np.ascontiguousarray(mesh.positions_m + np.float32(0.0))  # turns -0 into 0
    _, place = np.unique(positions.view(np.dtype((np.void, 12))).ravel(), return_inverse=True)
    corners = np.sort(place[mesh.triangles].reshape(-1, 3), axis=1)
    is_real = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
    edges = corners[is_real][:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2)
    keys = np.sort(edges[:, 0] * np.int64(len(place)) + edges[:, 1])
    begins = np.flatnonzero(np.append(True, keys[1:] != keys[:-1]))
    counts = np.diff(np.append(begins, len(keys)))
    return bool(len(keys)) and not (counts % 2).any()
