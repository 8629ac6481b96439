"""Points and lines of a glTF file as thin solids, of few triangles where there are very many.

A scene shows triangles alone. All points and pieces of lines of a file together become at most
four times POINTS_MOST triangles.
"""

import numpy as np
from numpy.typing import NDArray

from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.point_cloud import POINTS_MOST, drawn_points
from heatlens.scene.tubes import tubes

POINTS, LINES, LOOP, STRIP = range(4)  # modes of a primitive
_THINNESS = 1 / 600  # radius of a line or a point, as a part of the size of its mesh
_SIDES = 4

Solids = tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.uint32]]


def thin_count(gltf: GltfFile) -> int:
    """Return how many points and ends of lines all meshes of the file have."""
    return sum(
        _corner_count(gltf, primitive)
        for mesh in gltf.listed("meshes")
        for primitive in mesh.records("primitives")
        if primitive.whole("mode", STRIP + 1) <= STRIP
    )


def _corner_count(gltf: GltfFile, primitive: Record) -> int:
    accessors = gltf.listed("accessors")
    index = primitive.index("indices", len(accessors))
    if index is None:
        index = primitive.inside("attributes").index("POSITION", len(accessors))
    return 0 if index is None else accessors[index].whole("count", 0)


def thin_solids(
    places: NDArray[np.float64], corners: NDArray[np.uint32], mode: int, of_all: int
) -> Solids:
    """Return positions (V, 3), triangles (T, 3) and the vertex of the file of each position (V,).

    `of_all` is the number of points and ends of lines that share the triangles.
    """
    if not len(corners):
        return np.zeros((0, 3)), np.zeros((0, 3), np.uint32), np.zeros(0, np.uint32)
    radius_m = max(_THINNESS * float(np.linalg.norm(np.ptp(places, axis=0))), 1e-6)
    most = int(POINTS_MOST * len(corners) / max(of_all, len(corners)))
    if mode == POINTS:
        found = drawn_points(places[corners], np.full(len(corners), radius_m), None, most)
        return found.positions, found.triangles, corners[found.point]
    corners, counts = _curves(_thinned(corners, mode, most), mode)
    pieces = len(corners) - len(counts)
    radii = np.full(len(corners), radius_m)
    is_crossed = 2 * pieces > most
    positions, _, triangles, point = tubes(places[corners], radii, counts, _SIDES, is_crossed)
    return positions, triangles, corners[point]


def _thinned(corners: NDArray[np.uint32], mode: int, most: int) -> NDArray[np.uint32]:
    """Return at most about `most` corners: every second line, or points of a curve, and so on."""
    step = -(-len(corners) // max(most, 1))
    if mode == LINES:
        return corners[: len(corners) // 2 * 2].reshape(-1, 2)[::step].reshape(-1)
    is_last_left_out = (len(corners) - 1) % step > 0
    return np.append(corners[::step], corners[-1:]) if is_last_left_out else corners[::step]


def _curves(corners: NDArray[np.uint32], mode: int) -> tuple[NDArray[np.uint32], NDArray[np.int64]]:
    """Return the points of all lines in order, and the number of points of each line."""
    if mode == LINES:
        return corners, np.full(len(corners) // 2, 2)
    if mode == LOOP and len(corners) > 2:
        corners = np.append(corners, corners[0])
    return corners, np.array([len(corners)])
