"""Give lines and points of a glTF mesh the thickness with which they are drawn."""

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.point_cloud import POINTS_MOST, make_point_solids
from heatlens.media.scene.primitives import make_tubes

POINTS, LINES, LOOP, STRIP, TRIANGLES = range(5)  # modes of a primitive, the last the usual one
# Positions (V, 3), triangles (T, 3), and the vertex of the file of each position (V,).
Solids = tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.uint32]]


_THINNESS = 1 / 600  # radius of a line or a point, as a part of the size of its mesh
_SIDES = 4


def count_thin_corners(gltf: GltfFile) -> int:
    """Return how many points and ends of lines all meshes of the file have."""
    return sum(
        _corner_count(gltf, primitive)
        for mesh in gltf.top_level("meshes")
        for primitive in mesh.records("primitives")
        if primitive.whole_number("mode", TRIANGLES) <= STRIP
    )


def _corner_count(gltf: GltfFile, primitive: Record) -> int:
    """Return the number of corners of a primitive: that of its indices, or else its vertices."""
    index = gltf.index(primitive, "indices", "accessors")
    if index is None:
        index = gltf.index(primitive.object_at("attributes"), "POSITION", "accessors")
    return 0 if index is None else gltf.top_level("accessors")[index].whole_number("count", 0)


# Each primitive gets a share of the triangles, because all points and lines of a file together have
# the same limit of two million as a scan of points. A file of 1.9 MB becomes 1.7 million triangles
# instead of 6.3, and is read in a third of the time. Lines become crossed bands if tubes would be
# too many triangles.
def make_thin_solids(
    vertex_positions: NDArray[np.float64], corners: NDArray[np.uint32], mode: int, corner_total: int
) -> Solids:
    """Return thin solids for points or lines: balls for points, tubes or crossed bands for lines.

    They are positions (V, 3), triangles (T, 3) and the vertex of the file of each position (V,).
    `corners` are the vertices of the points or lines in the order of `mode`, and `corner_total` is
    the number of points and ends of lines of the whole file, which share the triangles.
    """
    if not len(corners):
        return np.zeros((0, 3)), np.zeros((0, 3), np.uint32), np.zeros(0, np.uint32)
    radius_m = max(_THINNESS * float(np.linalg.norm(np.ptp(vertex_positions, axis=0))), 1e-6)
    triangles_most = int(POINTS_MOST * len(corners) / max(corner_total, len(corners)))
    if mode == POINTS:
        solids = make_point_solids(
            vertex_positions[corners], np.full(len(corners), radius_m), None, triangles_most
        )
        return solids.positions, solids.triangles, corners[solids.point]
    corners, counts = _split_curves(_thin_out(corners, mode, triangles_most), mode)
    piece_count = len(corners) - len(counts)
    radii = np.full(len(corners), radius_m)
    is_crossed = 2 * piece_count > triangles_most
    positions, _, triangles, corner_number = make_tubes(
        vertex_positions[corners], radii, counts, _SIDES, is_crossed
    )
    return positions, triangles, corners[corner_number]


def _thin_out(corners: NDArray[np.uint32], mode: int, corners_most: int) -> NDArray[np.uint32]:
    """Return about `corners_most` corners at most; lines or points are left out evenly."""
    step = -(-len(corners) // max(corners_most, 1))
    if mode == LINES:
        return corners[: len(corners) // 2 * 2].reshape(-1, 2)[::step].reshape(-1)
    is_last_left_out = (len(corners) - 1) % step > 0
    return np.append(corners[::step], corners[-1:]) if is_last_left_out else corners[::step]


def _split_curves(
    corners: NDArray[np.uint32], mode: int
) -> tuple[NDArray[np.uint32], NDArray[np.int64]]:
    """Return the points of all lines in order, and the number of points of each line."""
    if mode == LINES:
        return corners, np.full(len(corners) // 2, 2)
    if mode == LOOP and len(corners) > 2:
        corners = np.append(corners, corners[0])
    return corners, np.array([len(corners)])
