"""Along what on a surface the pictures of its normals lie: (x, y, z) and a sign at each vertex.

x goes with u, y is the normal cross x times the sign, against v, as glTF 2.0 has it (section
3.7.2.1). Where a file tells nothing they are found as Mikkelsen 2008 ("Simulation of wrinkled
surfaces revisited") does, except that vertices are shared as the file shares them.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.scene.scene import Array, Mesh

_FLAT = 1e-6  # of the product of two edges: a triangle, or its place in the picture, without area
_SIDES = np.array([(1, 2), (2, 0), (0, 1)])  # the two other corners of each


def told_tangents(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return tangents (V, 4) of a file with length 1 or 0 and a sign of 1 or -1."""
    along = _unit(values[:, :3].astype(np.float64))
    signs = np.where(values[:, 3:] < 0, -1.0, 1.0)
    return np.concatenate([along, signs], axis=1).astype(np.float32)


def with_tangents(mesh: Mesh) -> Mesh:
    """Return the mesh with tangents.

    A vertex between two orientations of the picture is split in two. Tangents are zero where the
    texture coordinates define no direction.
    """
    if mesh.tangents is not None:
        return mesh
    along, is_mirrored = _across_triangles(mesh)
    mesh = _parted(mesh, is_mirrored)
    triangles, normals = mesh.triangles, mesh.normals.astype(np.float64)
    angles, sums = _angles(mesh), np.zeros((len(normals), 3))
    for corner in range(3):
        at = triangles[:, corner]
        # Of length 1 in the plane of the vertex, so that sloped triangles weigh as much as others.
        leaning = along - normals[at] * np.sum(along * normals[at], axis=1, keepdims=True)
        heavy = _unit(leaning) * angles[:, corner, None]
        for axis in range(3):
            sums[:, axis] += np.bincount(at, heavy[:, axis], len(normals))
    signs = np.ones((len(normals), 1))
    signs[triangles[is_mirrored]] = -1.0
    tangents = np.concatenate([_unit(sums), signs], axis=1).astype(np.float32)
    return replace(mesh, tangents=tangents)


def _across_triangles(mesh: Mesh) -> tuple[Array, NDArray[np.bool_]]:
    """Return (T, 3) directions of u, zero for none, and (T,) where uvs are mirrored."""
    corners = mesh.positions_m[mesh.triangles].astype(np.float64)
    places = mesh.uvs[mesh.triangles].astype(np.float64)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    s, t = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    area = s[:, 0] * t[:, 1] - t[:, 0] * s[:, 1]
    along = (t[:, 1:] * a - s[:, 1:] * b) * np.sign(area)[:, None]
    facing = np.cross(a, b)
    is_flat = np.abs(area) <= _FLAT * np.linalg.norm(s, axis=1) * np.linalg.norm(t, axis=1)
    is_flat |= np.linalg.norm(facing, axis=1) <= _FLAT * np.linalg.norm(a, axis=1) * (
        np.linalg.norm(b, axis=1)
    )
    # Corners may run the other way round than the normals say; v runs down.
    outside = np.sum(facing * mesh.normals[mesh.triangles].sum(axis=1), axis=1)
    is_mirrored = (area > 0) == (outside >= 0)
    return np.where(is_flat[:, None], 0.0, _unit(along)), is_mirrored & ~is_flat


def _parted(mesh: Mesh, is_mirrored: NDArray[np.bool_]) -> Mesh:
    """Duplicate each vertex that mirrored triangles share with others."""
    count = len(mesh.positions_m)
    uses = np.zeros((2, count), bool)
    uses[0][mesh.triangles[~is_mirrored]] = uses[1][mesh.triangles[is_mirrored]] = True
    shared = np.flatnonzero(uses.all(axis=0))
    if not len(shared):
        return mesh
    second = np.arange(count)
    second[shared] = count + np.arange(len(shared))
    triangles = np.where(is_mirrored[:, None], second[mesh.triangles], mesh.triangles)
    kept = np.concatenate([np.arange(count), shared])
    return replace(
        mesh,
        positions_m=mesh.positions_m[kept],
        normals=mesh.normals[kept],
        uvs=mesh.uvs[kept],
        triangles=triangles.astype(np.uint32),
        colors=None if mesh.colors is None else mesh.colors[kept],
        more_uvs=None if mesh.more_uvs is None else mesh.more_uvs[kept],
        sources=(kept if mesh.sources is None else mesh.sources[kept]).astype(np.uint32),
    )


def _angles(mesh: Mesh) -> Array:
    """Return (T, 3) angles of the corners in radians."""
    corners = mesh.positions_m[mesh.triangles].astype(np.float64)
    sides = corners[:, _SIDES] - corners[:, :, None]
    cosines = np.sum(_unit(sides[:, :, 0]) * _unit(sides[:, :, 1]), axis=-1)
    return np.asarray(np.arccos(np.clip(cosines, -1.0, 1.0)))


def _unit(vectors: Array) -> Array:
    """Return (..., 3) of length 1; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    safe = lengths > 1e-30
    return np.where(safe, vectors / np.where(safe, lengths, 1.0), 0.0)
