"""Find closed meshes (their inside is never visible) and how to detect their back faces."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.scene import Array, Mesh

# Rules by which a back face is recognized: never, by the normals, or by the order of its vertices
# as they appear in the picture. The same numbers as in shaders/scene_gpu/scene_cover.frag.glsl.
BACK_NONE, BACK_BY_NORMAL, BACK_COUNTERCLOCKWISE, BACK_CLOCKWISE = range(4)
_AGREEING_SHARE = 0.999  # share of the area with one winding from which the winding shows the back
_TRIANGLES_MAX = 2_000_000  # a mesh with more is not examined and counts as open

Rules = NDArray[np.uint32]


class ClosedMeshes:
    """The rules for back faces of a scene's meshes, each of which is examined once."""

    def __init__(self, meshes: Sequence[Mesh], boxes_m: Array) -> None:
        self._mesh_rules = np.array([back_rule(mesh) for mesh in meshes], np.uint32)
        self._boxes_m = boxes_m

    def rules(
        self, meshes: NDArray[np.int64], to_world: Array, to_object: Array, eye_m: Array
    ) -> Rules:
        """Return (N,) the rules of instances of `meshes` (N,) at (N, 4, 4) `to_world`.

        `to_object` holds the inverse matrices column by column, and `eye_m` is the position of the
        camera in the world. A closed mesh around the camera, such as a room, counts as open.
        """
        rules = self._mesh_rules[meshes]
        is_ordered = rules >= BACK_COUNTERCLOCKWISE
        is_mirrored = np.linalg.det(to_world[:, :3, :3]) < 0
        swapped_rules = BACK_COUNTERCLOCKWISE + BACK_CLOCKWISE - rules
        rules = np.where(is_ordered & is_mirrored, swapped_rules, rules)
        eye = (np.append(eye_m, 1.0) @ to_object)[:, :3]
        boxes = self._boxes_m[meshes]
        is_inside = ((eye >= boxes[:, 0]) & (eye <= boxes[:, 1])).all(axis=1)
        return np.where(is_inside, BACK_NONE, rules).astype(np.uint32)


def back_rule(mesh: Mesh) -> int:
    """Return how to recognize the back faces of a mesh; BACK_NONE for an open mesh.

    The picture's rows run down, so a face that is counterclockwise from outside appears clockwise,
    and its back counterclockwise.
    """
    if not is_closed(mesh):
        return BACK_NONE
    corners = mesh.positions_m[mesh.triangles].astype(np.float64)
    face_normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    vertex_normals = mesh.normals[mesh.triangles].astype(np.float64).sum(axis=1)
    # positive where a face is counterclockwise as seen from the side that its normals point to
    agreement = (face_normals * vertex_normals).sum(axis=1)
    area = np.linalg.norm(face_normals, axis=1)
    agreeing_share = float(area[agreement >= 0].sum()) / max(float(area.sum()), 1e-30)
    if agreeing_share >= _AGREEING_SHARE:
        return BACK_COUNTERCLOCKWISE
    return BACK_CLOCKWISE if agreeing_share <= 1 - _AGREEING_SHARE else BACK_BY_NORMAL


def is_closed(mesh: Mesh) -> bool:
    """Return whether an even number of triangles meets in every edge of a mesh.

    Vertices at equal positions count as one. A mesh that is too large to examine counts as open.
    """
    if not 0 < len(mesh.triangles) <= _TRIANGLES_MAX:
        return False
    positions = np.ascontiguousarray(mesh.positions_m + np.float32(0.0))  # turns -0 into 0
    _, vertex_numbers = np.unique(
        positions.view(np.dtype((np.void, 12))).ravel(), return_inverse=True
    )
    corners = np.sort(vertex_numbers[mesh.triangles].reshape(-1, 3), axis=1)
    is_real = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
    edges = corners[is_real][:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2)
    keys = np.sort(edges[:, 0] * np.int64(len(vertex_numbers)) + edges[:, 1])
    edge_starts = np.flatnonzero(np.append(True, keys[1:] != keys[:-1]))
    counts = np.diff(np.append(edge_starts, len(keys)))
    return bool(len(keys)) and not (counts % 2).any()
