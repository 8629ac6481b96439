"""Make the triangles of shapes that a file only names: sphere, cube, cylinder and so on.

A shape of revolution is a profile rotated about z. The texture coordinates of each shape run once
around it and once along it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

AROUND = 48  # number of sides of round shapes
_CAP_RINGS = 12  # number of rings from the rim of a hemisphere to its pole
# By axis: which axes of the shape become x, y and z.
_TURNS = {"X": (2, 0, 1), "Y": (1, 2, 0), "Z": (0, 1, 2)}


@dataclass(frozen=True, eq=False)
class Shape:
    """Positions (V, 3), unit normals (V, 3), texture coordinates (V, 2), triangles (T, 3)."""

    positions: Floats
    normals: Floats
    uvs: Floats
    triangles: NDArray[np.uint32]

    def along(self, axis: str) -> "Shape":
        """Return the shape with its own z along the axis X, Y or Z."""
        turn = list(_TURNS[axis])
        return Shape(self.positions[:, turn], self.normals[:, turn], self.uvs, self.triangles)


def sphere(radius: float) -> Shape:
    """Return a sphere about the origin."""
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 2 * _CAP_RINGS + 1)
    slopes = np.stack([np.cos(tilt), np.sin(tilt)], axis=1)
    return _turned([(radius * slopes, slopes)])


def capsule(height: float, bottom: float, top: float) -> Shape:
    """Return a cylinder of `height` between two hemispheres with the radii `bottom` and `top`."""
    half = 0.5 * height
    tilt = np.linspace(0, np.pi / 2, _CAP_RINGS + 1)
    up = np.stack([np.cos(tilt), np.sin(tilt)], axis=1)
    down = (up * (1, -1))[::-1]
    profile = np.vstack([bottom * down + (0, -half), top * up + (0, half)])
    return _turned([(profile, np.vstack([down, up]))])


def cylinder(height: float, bottom: float, top: float) -> Shape:
    """Return a closed cylinder, which is a cone if `top` is 0."""
    half = 0.5 * height
    side = np.array([(bottom, -half), (top, half)])
    facing = np.array([height, bottom - top]) / max(float(np.hypot(height, bottom - top)), 1e-30)
    bands = [(side, np.tile(facing, (2, 1)))]
    for radius, at, up in ((bottom, -half, -1.0), (top, half, 1.0)):
        rim = np.array([(0.0, at), (radius, at)])[:: int(-up)]
        bands += [(rim, np.tile((0.0, up), (2, 1)))] if radius > 0 else []
    return _turned(bands)


def cube(size: float) -> Shape:
    """Return a cube centred on the origin with edges of the length `size`."""
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
    return _of_quads(np.vstack(positions), np.vstack(normals), np.tile((square + 1) / 2, (6, 1)))


def plane(width: float, length: float) -> Shape:
    """Return a rectangle that faces z: `width` along x, `length` along y."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], np.float32)
    positions = np.column_stack([square * (width / 2, length / 2), np.zeros(4)])
    return _of_quads(positions, np.tile((0.0, 0.0, 1.0), (4, 1)), (square + 1) / 2)


def _of_quads(
    positions: NDArray[np.floating], normals: NDArray[np.floating], uvs: NDArray[np.floating]
) -> Shape:
    """Return a shape of rectangles, each with its own four vertices."""
    first = 4 * np.arange(len(positions) // 4, dtype=np.uint32)[:, None]
    halves = [first + np.array(half, np.uint32) for half in ((0, 1, 2), (0, 2, 3))]
    triangles = np.vstack(halves)
    return Shape(_f32(positions), _f32(normals), _f32(uvs * (1, -1) + (0, 1)), triangles)


def _turned(
    bands: Sequence[tuple[NDArray[np.floating], NDArray[np.floating]]], around: int = AROUND
) -> Shape:
    """Rotate profiles of (radius, z), with (radius, z) of their normals, about z.

    Profiles run from the bottom up on the outside, and do not share vertices.
    """
    angles = 2 * np.pi * np.arange(around + 1) / around
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    positions, normals, uvs, triangles, count = [], [], [], [], 0
    for profile, slopes in bands:
        along = np.linspace(0, 1, len(profile))
        positions.append(_around(profile, circle))
        normals.append(_around(slopes, circle))
        uvs.append(np.stack(np.meshgrid(angles / (2 * np.pi), 1 - along), axis=-1).reshape(-1, 2))
        triangles.append(count + _strips(len(profile), around + 1))
        count += len(profile) * (around + 1)
    whole = _f32(np.vstack(positions)), _f32(np.vstack(normals)), _f32(np.vstack(uvs))
    return _without_slivers(Shape(*whole, np.vstack(triangles).astype(np.uint32)))


def _around(rows: NDArray[np.floating], circle: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return points (R * C, 3) for rows (R, 2) of radius and height, and a circle (C, 2)."""
    flat = rows[:, None, :1] * circle
    heights = np.broadcast_to(rows[:, None, 1:], (*flat.shape[:2], 1))
    return np.concatenate([flat, heights], axis=2).reshape(-1, 3)


def _strips(rows: int, columns: int) -> NDArray[np.uint32]:
    """Return the triangles between neighbouring rows of a grid of vertices."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1, 1)
    low = first + np.array((0, 1, columns + 1))
    high = first + np.array((0, columns + 1, columns))
    return np.vstack([low, high]).astype(np.uint32)


def _without_slivers(shape: Shape) -> Shape:
    """Return the shape without triangles whose corners coincide, as at a pole."""
    corners = shape.positions[shape.triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    kept = shape.triangles[area > 1e-9 * max(float(area.max(initial=0.0)), 1e-30)]
    return Shape(shape.positions, shape.normals, shape.uvs, kept)


def _f32(values: NDArray[np.floating]) -> Floats:
    with np.errstate(over="ignore"):  # infinite values are refused when a mesh is made
        return np.ascontiguousarray(values, np.float32)
