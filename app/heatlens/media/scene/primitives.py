"""Make the triangles of shapes that a file only names: sphere, cube, cylinder and so on.

A shape of revolution is a profile rotated about z. The texture coordinates of each shape run once
around it and once along it.

Tubes along curves are made here too: hair, wires, grass.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

SIDES_AROUND = 48  # number of sides of round shapes
_CAP_RINGS = 12  # number of rings from the edge of a hemisphere to its pole
# By axis: which axes of the shape become x, y and z.
_AXIS_ORDERS = {"X": (2, 0, 1), "Y": (1, 2, 0), "Z": (0, 1, 2)}


@dataclass(frozen=True, eq=False)
class Shape:
    """Positions (V, 3), unit normals (V, 3), texture coordinates (V, 2), triangles (T, 3)."""

    positions: Floats
    normals: Floats
    uvs: Floats
    triangles: NDArray[np.uint32]

    def align_to(self, axis: str) -> "Shape":
        """Return the shape with its own z along the axis X, Y or Z."""
        order = list(_AXIS_ORDERS[axis])
        return Shape(self.positions[:, order], self.normals[:, order], self.uvs, self.triangles)


def sphere(radius: float) -> Shape:
    """Return a sphere about the origin."""
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 2 * _CAP_RINGS + 1)
    slopes = np.stack([np.cos(tilt), np.sin(tilt)], axis=1)
    return _revolve([(radius * slopes, slopes)])


def capsule(height: float, bottom: float, top: float) -> Shape:
    """Return a cylinder of `height` between two hemispheres with the radii `bottom` and `top`."""
    half = 0.5 * height
    tilt = np.linspace(0, np.pi / 2, _CAP_RINGS + 1)
    up = np.stack([np.cos(tilt), np.sin(tilt)], axis=1)
    down = (up * (1, -1))[::-1]
    profile = np.vstack([bottom * down + (0, -half), top * up + (0, half)])
    return _revolve([(profile, np.vstack([down, up]))])


def cylinder(height: float, bottom: float, top: float) -> Shape:
    """Return a closed cylinder, which is a cone if `top` is 0."""
    half = 0.5 * height
    side = np.array([(bottom, -half), (top, half)])
    facing = np.array([height, bottom - top]) / max(float(np.hypot(height, bottom - top)), 1e-30)
    bands = [(side, np.tile(facing, (2, 1)))]
    for radius, z, up in ((bottom, -half, -1.0), (top, half, 1.0)):
        cap = np.array([(0.0, z), (radius, z)])[:: int(-up)]
        bands += [(cap, np.tile((0.0, up), (2, 1)))] if radius > 0 else []
    return _revolve(bands)


def cube(size: float) -> Shape:
    """Return a cube centerd on the origin with edges of the length `size`."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], np.float32)
    positions, normals = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            face = np.empty((4, 3), np.float32)
            face[:, axis] = side
            face[:, (axis + 1) % 3] = square[:, 0] * side
            face[:, (axis + 2) % 3] = square[:, 1]
            positions.append(0.5 * size * face)
            normals.append(np.where(np.arange(3) == axis, side, 0.0) + np.zeros((4, 1)))
    return _make_quads(np.vstack(positions), np.vstack(normals), np.tile((square + 1) / 2, (6, 1)))


def plane(width: float, length: float) -> Shape:
    """Return a rectangle that faces z: `width` along x, `length` along y."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], np.float32)
    positions = np.column_stack([square * (width / 2, length / 2), np.zeros(4)])
    return _make_quads(positions, np.tile((0.0, 0.0, 1.0), (4, 1)), (square + 1) / 2)


def _make_quads(
    positions: NDArray[np.floating], normals: NDArray[np.floating], uvs: NDArray[np.floating]
) -> Shape:
    """Return a shape of rectangles, each with its own four vertices."""
    first_corner = 4 * np.arange(len(positions) // 4, dtype=np.uint32)[:, None]
    halves = [first_corner + np.array(half, np.uint32) for half in ((0, 1, 2), (0, 2, 3))]
    triangles = np.vstack(halves)
    return Shape(
        positions=convert_to_float32(positions),
        normals=convert_to_float32(normals),
        uvs=convert_to_float32(uvs * (1, -1) + (0, 1)),
        triangles=triangles,
    )


def _revolve(
    bands: Sequence[tuple[NDArray[np.floating], NDArray[np.floating]]],
    side_count: int = SIDES_AROUND,
) -> Shape:
    """Return a shape of revolution: profiles rotated about z.

    Each band is a profile of points (radius, z) and their normals, also as (radius, z).

    Profiles run from the bottom up on the outside, and do not share vertices.
    """
    angles = 2 * np.pi * np.arange(side_count + 1) / side_count
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    positions, normals, uvs, triangles, count = [], [], [], [], 0
    for profile, slopes in bands:
        along = np.linspace(0, 1, len(profile))
        positions.append(_rotate_rows(profile, circle))
        normals.append(_rotate_rows(slopes, circle))
        uvs.append(np.stack(np.meshgrid(angles / (2 * np.pi), 1 - along), axis=-1).reshape(-1, 2))
        triangles.append(count + _grid_triangles(len(profile), side_count + 1))
        count += len(profile) * (side_count + 1)
    joined = (
        convert_to_float32(np.vstack(positions)),
        convert_to_float32(np.vstack(normals)),
        convert_to_float32(np.vstack(uvs)),
    )
    return _drop_slivers(Shape(*joined, np.vstack(triangles).astype(np.uint32)))


def _rotate_rows(rows: NDArray[np.floating], circle: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return points (R * C, 3): rows (R, 2) of radius and height, each on a circle (C, 2)."""
    flat = rows[:, None, :1] * circle
    heights = np.broadcast_to(rows[:, None, 1:], (*flat.shape[:2], 1))
    return np.concatenate([flat, heights], axis=2).reshape(-1, 3)


def _grid_triangles(rows: int, columns: int) -> NDArray[np.uint32]:
    """Return the triangles between neighboring rows of a grid of vertices."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1, 1)
    low = first + np.array((0, 1, columns + 1))
    high = first + np.array((0, columns + 1, columns))
    return np.vstack([low, high]).astype(np.uint32)


def _drop_slivers(shape: Shape) -> Shape:
    """Return the shape without triangles whose corners coincide, as at a pole."""
    corners = shape.positions[shape.triangles].astype(np.float64)
    cross_products = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross_products, axis=1)
    kept_triangles = shape.triangles[area > 1e-9 * max(float(area.max(initial=0.0)), 1e-30)]
    return Shape(shape.positions, shape.normals, shape.uvs, kept_triangles)


def convert_to_float32(values: NDArray[np.floating]) -> Floats:
    """Return values as contiguous float32, as a mesh holds them."""
    with np.errstate(over="ignore"):  # infinite values are refused when a mesh is made
        return np.ascontiguousarray(values, np.float32)


Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def make_tubes(
    points: Array, radii: Array, counts: Indices, sides: int, is_crossed: bool = False
) -> tuple[Array, Array, NDArray[np.uint32], Indices]:
    """Return positions (V, 3), normals (V, 3), triangles (T, 3), and the point of each vertex (V,).

    `points` (P, 3) and `radii` (P,) hold one curve after the other, `counts` (C,) the number of
    points of each. Curves of fewer than two points have no tube. The ends are open.
    Crossed tubes have two bands through their middle instead of four sides.
    """
    curve = np.repeat(np.arange(len(counts)), counts)
    side, up = _tube_frames(points, curve, len(counts))
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
    point_index = np.repeat(np.arange(len(points)), sides)
    return positions.reshape(-1, 3), normals.reshape(-1, 3), triangles, point_index


def _tube_frames(points: Array, curve: Indices, count: int) -> tuple[Array, Array]:
    """Return two unit vectors (P, 3) perpendicular to the curve and to each other at each point.

    The first points towards the coordinate axis that is farthest from the curve's directions. Tubes
    then twist only where a curve turns towards this axis.
    """
    tangents = _tangents(points, curve)
    along = np.stack([np.bincount(curve, np.abs(column), count) for column in tangents.T], axis=1)
    reference_axis = np.eye(3)[np.argmin(along, axis=1)][curve]
    side = _normalize(
        reference_axis - (reference_axis * tangents).sum(axis=1, keepdims=True) * tangents
    )
    return side, np.cross(tangents, side)


def _tangents(points: Array, curve: Indices) -> Array:
    """Return the direction (P, 3) of the curve at each point, from its neighbors."""
    steps = np.where((curve[:-1] == curve[1:])[:, None], np.diff(points, axis=0), 0.0)
    zero_step = np.zeros((1, 3))
    return _normalize(np.vstack([zero_step, steps]) + np.vstack([steps, zero_step]))


def _normalize(vectors: Array) -> Array:
    """Return vectors (N, 3) of length 1; those without a direction become +z."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    has_direction = lengths > 1e-30
    return np.where(has_direction, vectors / np.where(has_direction, lengths, 1.0), (0.0, 0.0, 1.0))
