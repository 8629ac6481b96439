"""Make drawable meshes from the positions, triangles and attributes of a file."""

import numpy as np
from numpy.typing import NDArray

from heatlens.base.errors import InputError
from heatlens.scene.scene import Mesh

Floats = NDArray[np.float32]
Triangles = NDArray[np.uint32]

# Cameras have the same limit, where float32 resolves about a kilometre.
_FAR_MOST_M = 1e9
_UV_MOST = 1e4  # repeats; beyond that float32 cannot distinguish the pixels of a picture
_UP = np.array([0.0, 1.0, 0.0])  # normal of a triangle without area, which is invisible


def made_mesh(
    what: str,
    positions_m: Floats,
    triangles: Triangles,
    normals: Floats | None = None,
    uvs: Floats | None = None,
    material: int = 0,
    colors: Floats | None = None,
) -> Mesh:
    """Make a mesh of (V, 3) positions and (T, 3) indices, flat-shaded if there are no normals.

    Colours (V, 3) or (V, 4) are linear and are clipped to 0..1. Raises InputError, beginning with
    `what`, for positions that are not finite and indices without a position.
    """
    _check(what, positions_m, triangles)
    uvs = np.zeros((len(positions_m), 2), np.float32) if uvs is None else _uvs(uvs)
    colors = None if colors is None else _shares(colors)
    if normals is None:
        # Each triangle gets its own vertices, so that each can have its own normal.
        apart, triangles = triangles.reshape(-1), own_vertices(len(triangles))
        positions_m, uvs = positions_m[apart], uvs[apart]
        colors = None if colors is None else colors[apart]
        normals = smooth_normals(positions_m, triangles)
    else:
        apart, normals = None, _unit(normals, positions_m, triangles)
    return Mesh(
        np.ascontiguousarray(positions_m),
        np.ascontiguousarray(normals),
        np.ascontiguousarray(uvs),
        np.ascontiguousarray(triangles),
        material,
        None if colors is None else np.ascontiguousarray(colors, np.float32),
        sources=apart,
    )


def _shares(colors: Floats) -> Floats | None:
    """Clip colours to 0..1; return None if all are white, as many exporters write them."""
    found = np.clip(np.nan_to_num(colors, nan=1.0), 0.0, 1.0)
    return None if (found == 1).all() else found


def own_vertices(count: int) -> Triangles:
    """Return (count, 3) triangles that share no vertices."""
    return np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)


def smooth_normals(positions: Floats, triangles: Triangles) -> Floats:
    """Return normals (V, 3): the mean of the triangles around each vertex, weighted by area."""
    corners = positions[triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros((len(positions), 3))
    for axis in range(3):
        for corner in range(3):
            sums[:, axis] += np.bincount(triangles[:, corner], across[:, axis], len(positions))
    return _normalized(sums, _UP)


def _check(what: str, positions: Floats, triangles: Triangles) -> None:
    if not (np.abs(positions) <= _FAR_MOST_M).all():
        raise InputError(
            f"{what}: a vertex is at NaN or beyond {_FAR_MOST_M:g} m, where nothing can be drawn."
        )
    if triangles.size and int(triangles.max()) >= len(positions):
        raise InputError(
            f"{what}: a triangle refers to vertex {int(triangles.max())} of {len(positions)}; the "
            "file is damaged."
        )


def _uvs(uvs: Floats) -> Floats:
    found = np.nan_to_num(uvs, nan=0.0, posinf=0.0, neginf=0.0)
    return np.asarray(np.clip(found, -_UV_MOST, _UV_MOST), np.float32)


def _unit(normals: Floats, positions: Floats, triangles: Triangles) -> Floats:
    """Normalise normals; one of length 0 becomes that of the triangles around its vertex."""
    lengths = np.linalg.norm(normals.astype(np.float64), axis=1)
    if (np.isfinite(lengths) & (lengths > 1e-6)).all():
        return np.asarray(normals / lengths[:, None], np.float32)
    return _normalized(np.nan_to_num(normals), smooth_normals(positions, triangles))


def _normalized(vectors: NDArray[np.floating], instead: NDArray[np.floating]) -> Floats:
    lengths = np.linalg.norm(vectors.astype(np.float64), axis=1, keepdims=True)
    safe = lengths > 1e-30
    return np.where(safe, vectors / np.where(safe, lengths, 1.0), instead).astype(np.float32)
