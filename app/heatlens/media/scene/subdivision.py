"""Catmull-Clark subdivision of polygons, vectorized over all vertices.

The rules are those of Catmull and Clark 1978 for smooth surfaces, and of DeRose, Kass and Truong
1998 for creases: an edge of sharpness s stays sharp for s levels. Edges at the boundary of a
surface and edges of more than two faces are sharp, and a vertex of a single face stays in place,
which is the default of USD. Values at the corners of faces, such as texture coordinates, are
interpolated linearly within each face, so that their seams are kept.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_SPREAD_ROUNDS = 64  # more than the number of faces around any reasonable vertex


@dataclass(frozen=True, eq=False)
class Polygons:
    """Faces with any number of corners.

    points        (V, 3)
    counts        (F,) corners of each face
    corners       (C,) the vertex at each corner, face after face
    values        (C, n) arrays of values at the corners, by name
    faces         (F,) the face of the file that each face comes from
    creases       (E, 2) vertices of creased edges, in any order, and their (E,) sharpness
    sharp_points  (P,) vertices that stay in place, and their (P,) sharpness in levels
    """

    points: Array
    counts: Indices
    corners: Indices
    values: Mapping[str, Array] = field(default_factory=dict)
    faces: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    creases: Indices = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    crease_sharpness: Array = field(default_factory=lambda: np.zeros(0))
    sharp_points: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    point_sharpness: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, eq=False)
class _Edges:
    """The edges between the corners of faces.

    of_corner  (C,) the edge from each corner to the next one of its face
    ends       (E, 2) vertices
    faces      (E,) how many faces each has
    sharpness  (E,) infinite at the boundary of a surface
    """

    of_corner: Indices
    ends: Indices
    faces: Indices
    sharpness: Array


def subdivide(mesh: Polygons) -> Polygons:
    """Return the mesh after one level: one quad for each corner of the old mesh."""
    edges, face_of = _find_edges(mesh), np.repeat(np.arange(len(mesh.counts)), mesh.counts)
    face_points = _means(mesh.points[mesh.corners], face_of, mesh.counts)
    edge_points = _edge_points(mesh, edges, face_points, face_of)
    points = _vertex_points(mesh, edges, face_points, face_of)
    vertex_count, first_face = len(mesh.points), len(mesh.points) + len(edges.ends)
    next_corner, previous_corner = neighbour_corners(mesh.counts)
    quads = np.stack(
        [
            mesh.corners,
            vertex_count + edges.of_corner,
            first_face + face_of,
            vertex_count + edges.of_corner[previous_corner],
        ],
        axis=1,
    )
    values = {
        name: _corner_values(value, next_corner, previous_corner, face_of, mesh.counts)
        for name, value in mesh.values.items()
    }
    creases, sharpness = _split_creases(edges, vertex_count)
    is_still_sharp = mesh.point_sharpness > 1
    return Polygons(
        points=np.vstack([points, edge_points, face_points]),
        counts=np.full(len(quads), 4, np.int64),
        corners=quads.reshape(-1),
        values=values,
        faces=mesh.faces[face_of] if len(mesh.faces) else face_of,
        creases=creases,
        crease_sharpness=sharpness,
        sharp_points=mesh.sharp_points[is_still_sharp],
        point_sharpness=mesh.point_sharpness[is_still_sharp] - 1,
    )


def corner_normals(mesh: Polygons) -> NDArray[np.float32]:
    """Return unit normals (C, 3), smooth except across creases.

    Faces at a vertex share its normal if they are connected by smooth edges.
    """
    face_of = np.repeat(np.arange(len(mesh.counts)), mesh.counts)
    next_corner, _ = neighbour_corners(mesh.counts)
    corner_points = mesh.points[mesh.corners]
    areas = np.stack(
        [
            np.bincount(face_of, column, len(mesh.counts))
            for column in np.cross(corner_points, corner_points[next_corner]).T
        ]
    ).T
    group = _smooth_groups(mesh, _find_edges(mesh), next_corner)
    count = int(group.max(initial=-1)) + 1
    sums = np.stack([np.bincount(group, column, count) for column in areas[face_of].T]).T
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    units = np.where(lengths > 1e-30, sums / np.maximum(lengths, 1e-30), (0.0, 1.0, 0.0))
    return np.asarray(units[group], np.float32)


def neighbour_corners(counts: Indices) -> tuple[Indices, Indices]:
    """Return, for each corner, the next and the previous corner of its face, each (C,)."""
    total = int(counts.sum())
    next_corner, previous_corner = np.arange(1, total + 1), np.arange(-1, total - 1)
    has_corners = counts > 0
    lasts = np.cumsum(counts)[has_corners] - 1
    firsts = lasts - counts[has_corners] + 1
    next_corner[lasts], previous_corner[firsts] = firsts, lasts
    return next_corner, previous_corner


def _find_edges(mesh: Polygons) -> _Edges:
    """Return the edges of a mesh with the sharpness of its creases."""
    next_corner, _ = neighbour_corners(mesh.counts)
    pairs = np.sort(np.stack([mesh.corners, mesh.corners[next_corner]], axis=1), axis=1)
    keys = pairs[:, 0] * len(mesh.points) + pairs[:, 1]
    edge_keys, of_corner, faces = np.unique(keys, return_inverse=True, return_counts=True)
    ends = np.stack(np.divmod(edge_keys, max(len(mesh.points), 1)), axis=1)
    sharpness = np.where(faces == 2, 0.0, np.inf)
    creases = np.sort(mesh.creases, axis=1)
    crease_keys = creases[:, 0] * len(mesh.points) + creases[:, 1]
    edge_index = np.minimum(np.searchsorted(edge_keys, crease_keys), max(len(edge_keys) - 1, 0))
    is_edge = (
        edge_keys[edge_index] == crease_keys if len(edge_keys) else np.zeros(len(crease_keys), bool)
    )
    np.maximum.at(sharpness, edge_index[is_edge], mesh.crease_sharpness[is_edge])
    return _Edges(of_corner.reshape(-1), ends, faces, sharpness)


def _edge_points(mesh: Polygons, edges: _Edges, face_points: Array, face_of: Indices) -> Array:
    """Return the new points (E, 3): the middle of a sharp edge, else its mean with its faces."""
    middles = mesh.points[edges.ends].mean(axis=1)
    face_means = _means(face_points[face_of], edges.of_corner, edges.faces)
    sharp_share = np.clip(edges.sharpness, 0, 1)[:, None]
    return np.asarray(middles * sharp_share + (middles + face_means) / 2 * (1 - sharp_share))


def _vertex_points(mesh: Polygons, edges: _Edges, face_points: Array, face_of: Indices) -> Array:
    """Return the moved vertices (V, 3): smooth, on a crease or in place, by their sharp edges."""
    points, count = mesh.points, len(mesh.points)
    valence = np.bincount(edges.ends.reshape(-1), minlength=count)
    faces = np.bincount(mesh.corners, minlength=count)
    other_ends = edges.ends[:, ::-1].reshape(-1)
    neighbour_means = (
        _sums(points[other_ends], edges.ends.reshape(-1), count) / np.maximum(valence, 1)[:, None]
    )
    face_means = _sums(face_points[face_of], mesh.corners, count) / np.maximum(faces, 1)[:, None]
    n = np.maximum(valence, 1)[:, None]
    smooth = (points * (n - 2) + neighbour_means + face_means) / n
    is_sharp = edges.sharpness > 0
    ends = edges.ends[is_sharp]
    sharp_edges = np.bincount(ends.reshape(-1), minlength=count)
    crease_neighbours = _sums(points[ends[:, ::-1].reshape(-1)], ends.reshape(-1), count)
    crease = 0.75 * points + 0.125 * crease_neighbours
    crease_share = _sums(np.repeat(edges.sharpness[is_sharp], 2)[:, None], ends.reshape(-1), count)[
        :, 0
    ]
    crease_share = np.clip(
        np.nan_to_num(crease_share / np.maximum(sharp_edges, 1), posinf=1.0), 0, 1
    )
    is_corner = (sharp_edges > 2) | ((faces == 1) & (sharp_edges > 1)) | (valence == 0)
    target = np.where(is_corner[:, None], points, crease)
    crease_share = np.where((sharp_edges >= 2) | (valence == 0), crease_share, 0.0)
    crease_share = np.where(valence == 0, 1.0, crease_share)
    moved_points = target * crease_share[:, None] + smooth * (1 - crease_share[:, None])
    fixed_share = np.clip(mesh.point_sharpness, 0, 1)[:, None]
    fixed_points = mesh.sharp_points
    moved_points[fixed_points] = points[fixed_points] * fixed_share + moved_points[fixed_points] * (
        1 - fixed_share
    )
    return np.asarray(moved_points)


def _corner_values(
    values: Array, next_corner: Indices, previous_corner: Indices, face_of: Indices, counts: Indices
) -> Array:
    """Return the values (4 C, n) at the four corners of the quad of each corner."""
    face_mean = _means(values, face_of, counts)[face_of]
    next_middle = (values + values[next_corner]) / 2
    previous_middle = (values + values[previous_corner]) / 2
    return np.stack([values, next_middle, face_mean, previous_middle], axis=1).reshape(
        -1, values.shape[1]
    )


def _split_creases(edges: _Edges, vertex_count: int) -> tuple[Indices, Array]:
    """Return the halves of creases that are still sharp, and their sharpness.

    Boundaries are left out, because `_find_edges` finds them again.
    """
    sharp_edges = np.flatnonzero((edges.sharpness > 1) & np.isfinite(edges.sharpness))
    middles = vertex_count + sharp_edges
    halves = [np.stack([edges.ends[sharp_edges, end], middles], axis=1) for end in (0, 1)]
    return np.vstack(halves), np.tile(edges.sharpness[sharp_edges] - 1, 2)


# Corners of a vertex that smooth edges connect form a group. The least number of each group spreads
# along all edges at once, in as many rounds as the longest fan of faces needs. Walking around each
# vertex would be a loop in Python over millions.
def _smooth_groups(mesh: Polygons, edges: _Edges, next_corner: Indices) -> Indices:
    """Return a group number (C,) for each corner; corners of a group share a normal."""
    is_inner_crease = (edges.sharpness > 0) & (edges.faces == 2)
    if not is_inner_crease.any():
        return np.unique(mesh.corners, return_inverse=True)[1].reshape(-1)
    # The two corners at each end of a smooth edge belong together.
    order = np.argsort(edges.of_corner, kind="stable")
    starts = np.cumsum(edges.faces) - edges.faces
    smooth = np.flatnonzero((edges.sharpness <= 0) & (edges.faces == 2))
    corner, other_corner = order[starts[smooth]], order[starts[smooth] + 1]
    is_same_direction = mesh.corners[corner] == mesh.corners[other_corner]
    first = np.where(is_same_direction, other_corner, next_corner[other_corner])
    second = np.where(is_same_direction, next_corner[other_corner], other_corner)
    a = np.concatenate([corner, next_corner[corner]])
    b = np.concatenate([first, second])
    group = np.arange(len(mesh.corners))
    for _ in range(_SPREAD_ROUNDS):
        least = np.minimum(group[a], group[b])
        if (least == group[a]).all() and (least == group[b]).all():
            break
        np.minimum.at(group, a, least)
        np.minimum.at(group, b, least)
    return np.unique(group, return_inverse=True)[1].reshape(-1)


def _sums(rows: Array, index: Indices, count: int) -> Array:
    """Return the sums (count, n) of the rows (R, n) that have the same index (R,)."""
    columns = [np.bincount(index, column, count) for column in rows.T]
    return np.stack(columns, axis=1) if columns else np.zeros((count, 0))


def _means(rows: Array, index: Indices, counts: Indices) -> Array:
    """Return the means of the rows (R, n) with the same index; `counts` tells how many have it."""
    return np.asarray(_sums(rows, index, len(counts)) / np.maximum(counts, 1)[:, None])
