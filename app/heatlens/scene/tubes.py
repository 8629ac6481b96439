"""Make thin tubes of triangles along curves: hair, wires, grass."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def tubes(
    points: Array, radii: Array, counts: Indices, sides: int, is_crossed: bool = False
) -> tuple[Array, Array, NDArray[np.uint32], Indices]:
    """Return positions (V, 3), normals (V, 3), triangles (T, 3), and the point of each vertex (V,).

    `points` (P, 3) and `radii` (P,) hold one curve after the other, `counts` (C,) the number of
    points of each. Curves of fewer than two points have no tube. The ends are open.
    Crossed tubes have two bands through their middle instead of four sides.
    """
    curve = np.repeat(np.arange(len(counts)), counts)
    side, up = _across(points, curve, len(counts))
    angles = 2 * np.pi * np.arange(sides) / sides
    normals = (
        np.cos(angles)[None, :, None] * side[:, None] + np.sin(angles)[None, :, None] * up[:, None]
    )
    positions = points[:, None] + radii[:, None, None] * normals
    first = np.flatnonzero(curve[:-1] == curve[1:])  # points with a next one on their curve
    i = np.arange(sides // 2 if is_crossed else sides)
    j = i + sides // 2 if is_crossed else (i + 1) % sides
    low, high = (first[:, None] * sides + k for k in (i, j))
    quads = np.stack([low, high, high + sides, low + sides], axis=-1).reshape(-1, 4)
    triangles = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.uint32)
    whose = np.repeat(np.arange(len(points)), sides)
    return positions.reshape(-1, 3), normals.reshape(-1, 3), triangles, whose


def _across(points: Array, curve: Indices, count: int) -> tuple[Array, Array]:
    """Return two unit vectors (P, 3) perpendicular to the curve at each point.

    The first leans towards the axis that is farthest from the curve's directions, so that tubes
    twist only where a curve turns towards it.
    """
    tangents = _tangents(points, curve)
    along = np.stack([np.bincount(curve, np.abs(column), count) for column in tangents.T], axis=1)
    leaning = np.eye(3)[np.argmin(along, axis=1)][curve]
    side = _unit(leaning - (leaning * tangents).sum(axis=1, keepdims=True) * tangents)
    return side, np.cross(tangents, side)


def _tangents(points: Array, curve: Indices) -> Array:
    """Return the direction (P, 3) of the curve at each point, from its neighbours."""
    steps = np.where((curve[:-1] == curve[1:])[:, None], np.diff(points, axis=0), 0.0)
    none = np.zeros((1, 3))
    return _unit(np.vstack([none, steps]) + np.vstack([steps, none]))


def _unit(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    safe = lengths > 1e-30
    return np.where(safe, vectors / np.where(safe, lengths, 1.0), (0.0, 0.0, 1.0))
