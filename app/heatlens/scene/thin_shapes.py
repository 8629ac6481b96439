"""Points and lines as thin solids of triangles, so that rays and the rasteriser both find them."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Indices = NDArray[np.uint32]

THINNESS = 1 / 600  # the radius of a line or a point, as a part of the size of all of them
_LEAST_M = 1e-6
# A tetrahedron around a point, and three edges around a line.
_POINT = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / np.sqrt(3)
_POINT_FACES = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])
_AROUND = np.array([(np.cos(a), np.sin(a)) for a in (np.pi / 2, np.pi * 7 / 6, np.pi * 11 / 6)])
_TUBE_FACES = np.array([(i, (i + 1) % 3, 3 + i) for i in range(3)]
                       + [((i + 1) % 3, 3 + (i + 1) % 3, 3 + i) for i in range(3)])  # fmt: skip


def radius_of(positions: Floats) -> float:
    """Return the radius of points or lines between positions (V, 3)."""
    if not len(positions):
        return _LEAST_M
    return max(THINNESS * float(np.linalg.norm(np.ptp(positions.astype(float), axis=0))), _LEAST_M)


def points_as_triangles(
    positions: Floats, picked: Indices, radius_m: float
) -> tuple[Floats, Indices, Indices]:
    """Return positions (V, 3), triangles (T, 3) and for each vertex the point it belongs to.

    `picked` (N,) lists the positions that are points.
    """
    middles = positions[picked]
    found = middles[:, None] + (radius_m * _POINT).astype(np.float32)
    faces = _POINT_FACES + 4 * np.arange(len(picked))[:, None, None]
    return found.reshape(-1, 3), faces.reshape(-1, 3).astype(np.uint32), np.repeat(picked, 4)


def lines_as_triangles(
    positions: Floats, ends: Indices, radius_m: float
) -> tuple[Floats, Indices, Indices]:
    """Return positions (V, 3), triangles (T, 3) and for each vertex the end it belongs to.

    `ends` (N, 2) lists the two positions of each line; lines of no length are left out.
    """
    along = positions[ends[:, 1]].astype(float) - positions[ends[:, 0]]
    lengths = np.linalg.norm(along, axis=1)
    ends, along = ends[lengths > 0], along[lengths > 0] / lengths[lengths > 0, None]
    aside = np.eye(3)[np.argmin(np.abs(along), axis=1)]
    side = np.cross(along, aside)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    axes = np.stack([side, np.cross(along, side)], axis=1)  # (N, 2, 3)
    ring = radius_m * np.einsum("ka,nax->nkx", _AROUND, axes)
    found = positions[ends][:, :, None] + ring[:, None].astype(np.float32)  # (N, 2, 3, 3)
    faces = _TUBE_FACES + 6 * np.arange(len(ends))[:, None, None]
    return found.reshape(-1, 3), faces.reshape(-1, 3).astype(np.uint32), np.repeat(ends, 3)


def line_ends(corners: Indices, is_strip: bool, is_loop: bool) -> Indices:
    """Return (N, 2) ends of separate lines, or of a strip that a loop closes."""
    if not is_strip:
        return corners[: len(corners) // 2 * 2].reshape(-1, 2)
    ends = np.stack([corners[:-1], corners[1:]], axis=1)
    closing = np.array([[corners[-1], corners[0]]], np.uint32) if is_loop and len(ends) else None
    return ends if closing is None else np.concatenate([ends, closing])
