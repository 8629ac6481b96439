"""Make drawable meshes from the positions, triangles and attributes of a file.

Tangents for normal maps are (x, y, z) and a sign at each vertex. The tangent follows u, and the
bitangent, cross(normal, tangent) * sign, points against v, as in glTF 2.0 (section 3.7.2.1).
Missing tangents are computed as in Mikkelsen 2008 ("Simulation of wrinkled surfaces revisited"),
except that vertices are shared as in the file.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.scene.scene import Array, Mesh

Floats = NDArray[np.float32]
Triangles = NDArray[np.uint32]

# Cameras have the same limit, where float32 resolves about a kilometer.
_FAR_MOST_M = 1e9
_UV_MOST = 1e4  # repeats; beyond that float32 cannot distinguish the pixels of a picture
_UP = np.array([0.0, 1.0, 0.0])  # normal of a triangle without area, which is invisible


def make_mesh(
    label: str,
    positions_m: Floats,
    triangles: Triangles,
    normals: Floats | None = None,
    uvs: Floats | None = None,
    material: int = 0,
    colors: Floats | None = None,
) -> Mesh:
    """Make a mesh of (V, 3) positions and (T, 3) indices, flat-shaded if there are no normals.

    Colors (V, 3) or (V, 4) are linear and are clipped to 0..1. Raises InputError, beginning with
    `label`, for positions that are not finite and indices without a position.
    """
    _check_geometry(label, positions_m, triangles)
    uvs = np.zeros((len(positions_m), 2), np.float32) if uvs is None else _clip_uvs(uvs)
    colors = None if colors is None else _clip_colors(colors)
    if normals is None:
        # Each triangle gets vertices and a normal of its own.
        sources, triangles = triangles.reshape(-1), unshared_triangles(len(triangles))
        positions_m, uvs = positions_m[sources], uvs[sources]
        colors = None if colors is None else colors[sources]
        normals = smooth_normals(positions_m, triangles)
    else:
        sources, normals = None, _normalize_normals(normals, positions_m, triangles)
    return Mesh(
        positions_m=np.ascontiguousarray(positions_m),
        normals=np.ascontiguousarray(normals),
        uvs=np.ascontiguousarray(uvs),
        triangles=np.ascontiguousarray(triangles),
        material=material,
        colors=None if colors is None else np.ascontiguousarray(colors, np.float32),
        sources=sources,
    )


def _clip_colors(colors: Floats) -> Floats | None:
    """Clip colors to 0..1; return None if all are white, which is the default."""
    clipped = np.clip(np.nan_to_num(colors, nan=1.0), 0.0, 1.0)
    return None if (clipped == 1).all() else clipped


def unshared_triangles(count: int) -> Triangles:
    """Return triangles (count, 3) of which each has three vertices of its own."""
    return np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)


def smooth_normals(positions: Floats, triangles: Triangles) -> Floats:
    """Return normals (V, 3): the mean of the triangles around each vertex, weighted by area."""
    corners = positions[triangles].astype(np.float64)
    cross_products = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros((len(positions), 3))
    for axis in range(3):
        for corner in range(3):
            sums[:, axis] += np.bincount(
                triangles[:, corner], cross_products[:, axis], len(positions)
            )
    return _normalize_or(sums, _UP)


def _check_geometry(label: str, positions: Floats, triangles: Triangles) -> None:
    """Raise InputError for positions that are not finite and indices without a position."""
    if not (np.abs(positions) <= _FAR_MOST_M).all():
        raise InputError(
            f"{label}: a vertex has no finite place, or is beyond {_FAR_MOST_M:g} m: look at the "
            "unit, or export it again."
        )
    if triangles.size and int(triangles.max()) >= len(positions):
        raise InputError(
            f"{label}: a triangle refers to vertex {int(triangles.max())} of {len(positions)}; the "
            "file is damaged."
        )


def _clip_uvs(uvs: Floats) -> Floats:
    """Return texture coordinates (V, 2) within the range of float32 textures; NaN becomes 0."""
    finite_uvs = np.nan_to_num(uvs, nan=0.0, posinf=0.0, neginf=0.0)
    return np.asarray(np.clip(finite_uvs, -_UV_MOST, _UV_MOST), np.float32)


def _normalize_normals(normals: Floats, positions: Floats, triangles: Triangles) -> Floats:
    """Normalise normals; one of length 0 becomes that of the triangles around its vertex."""
    lengths = np.linalg.norm(normals.astype(np.float64), axis=1)
    if (np.isfinite(lengths) & (lengths > 1e-6)).all():
        return np.asarray(normals / lengths[:, None], np.float32)
    return _normalize_or(np.nan_to_num(normals), smooth_normals(positions, triangles))


def _normalize_or(vectors: NDArray[np.floating], fallback: NDArray[np.floating]) -> Floats:
    """Return vectors (V, 3) of length 1; those without a direction become `fallback`."""
    lengths = np.linalg.norm(vectors.astype(np.float64), axis=1, keepdims=True)
    has_direction = lengths > 1e-30
    return np.where(
        has_direction, vectors / np.where(has_direction, lengths, 1.0), fallback
    ).astype(np.float32)


# Area of a triangle, or of its texture coordinates, relative to two edges, that counts as none.
_NO_AREA = 1e-6
_SIDES = np.array([(1, 2), (2, 0), (0, 1)])  # the two other corners of each corner


def normalize_tangents(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Normalise tangents (V, 4) of a file: length 1 or 0, and a sign of 1 or -1."""
    directions = _scale_to_unit(values[:, :3].astype(np.float64))
    signs = np.where(values[:, 3:] < 0, -1.0, 1.0)
    return np.concatenate([directions, signs], axis=1).astype(np.float32)


def add_tangents(mesh: Mesh) -> Mesh:
    """Return the mesh with tangents.

    A vertex between mirrored and other texture coordinates is split in two. Tangents are zero where
    the texture coordinates define no direction.
    """
    if mesh.tangents is not None:
        return mesh
    directions, is_mirrored = _triangle_tangents(mesh)
    mesh = _split_mirrored_vertices(mesh, is_mirrored)
    triangles, normals = mesh.triangles, mesh.normals.astype(np.float64)
    angles, sums = _corner_angles(mesh), np.zeros((len(normals), 3))
    for corner in range(3):
        vertex = triangles[:, corner]
        # Normalize in the tangent plane of the vertex, where sloped triangles have the same weight.
        projected = directions - normals[vertex] * np.sum(
            directions * normals[vertex], axis=1, keepdims=True
        )
        weighted = _scale_to_unit(projected) * angles[:, corner, None]
        for axis in range(3):
            sums[:, axis] += np.bincount(vertex, weighted[:, axis], len(normals))
    signs = np.ones((len(normals), 1))
    signs[triangles[is_mirrored]] = -1.0
    tangents = np.concatenate([_scale_to_unit(sums), signs], axis=1).astype(np.float32)
    return replace(mesh, tangents=tangents)


def _triangle_tangents(mesh: Mesh) -> tuple[Array, NDArray[np.bool_]]:
    """Return the directions (T, 3) of u, zero for none, and a mask (T,) of mirrored triangles."""
    corners = mesh.positions_m[mesh.triangles].astype(np.float64)
    uvs = mesh.uvs[mesh.triangles].astype(np.float64)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    s, t = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    area = s[:, 0] * t[:, 1] - t[:, 0] * s[:, 1]
    directions = (t[:, 1:] * a - s[:, 1:] * b) * np.sign(area)[:, None]
    cross_products = np.cross(a, b)
    is_flat = np.abs(area) <= _NO_AREA * np.linalg.norm(s, axis=1) * np.linalg.norm(t, axis=1)
    is_flat |= np.linalg.norm(cross_products, axis=1) <= _NO_AREA * np.linalg.norm(a, axis=1) * (
        np.linalg.norm(b, axis=1)
    )
    # The order of the corners may contradict the normals; v runs down.
    agreement = np.sum(cross_products * mesh.normals[mesh.triangles].sum(axis=1), axis=1)
    is_mirrored = (area > 0) == (agreement >= 0)
    return np.where(is_flat[:, None], 0.0, _scale_to_unit(directions)), is_mirrored & ~is_flat


def _split_mirrored_vertices(mesh: Mesh, is_mirrored: NDArray[np.bool_]) -> Mesh:
    """Return the mesh with a copy of each vertex that mirrored triangles share with others."""
    count = len(mesh.positions_m)
    uses = np.zeros((2, count), bool)
    uses[0][mesh.triangles[~is_mirrored]] = uses[1][mesh.triangles[is_mirrored]] = True
    shared = np.flatnonzero(uses.all(axis=0))
    if not len(shared):
        return mesh
    duplicate = np.arange(count)
    duplicate[shared] = count + np.arange(len(shared))
    triangles = np.where(is_mirrored[:, None], duplicate[mesh.triangles], mesh.triangles)
    sources = np.concatenate([np.arange(count), shared])
    return replace(
        mesh,
        positions_m=mesh.positions_m[sources],
        normals=mesh.normals[sources],
        uvs=mesh.uvs[sources],
        triangles=triangles.astype(np.uint32),
        colors=None if mesh.colors is None else mesh.colors[sources],
        more_uvs=None if mesh.more_uvs is None else mesh.more_uvs[sources],
        sources=(sources if mesh.sources is None else mesh.sources[sources]).astype(np.uint32),
    )


def _corner_angles(mesh: Mesh) -> Array:
    """Return the angles (T, 3), in radians, at the corners of the triangles."""
    corners = mesh.positions_m[mesh.triangles].astype(np.float64)
    sides = corners[:, _SIDES] - corners[:, :, None]
    cosines = np.sum(_scale_to_unit(sides[:, :, 0]) * _scale_to_unit(sides[:, :, 1]), axis=-1)
    return np.asarray(np.arccos(np.clip(cosines, -1.0, 1.0)))


def _scale_to_unit(vectors: Array) -> Array:
    """Return vectors (..., 3) scaled to length 1; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    has_direction = lengths > 1e-30
    return np.where(has_direction, vectors / np.where(has_direction, lengths, 1.0), 0.0)
