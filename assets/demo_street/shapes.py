"""Make and place the few shapes of the built-in scene."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from heatlens.media.scene.scene import Array, Mesh

Point = tuple[float, float, float]


def lathe(profile: Sequence[tuple[float, float]], around: int = 10, smooth: bool = True) -> Mesh:
    """Return a solid turned around y; `profile` is (radius, height) in metres from the bottom up.

    Without `smooth` each band keeps its edges.
    """
    points = np.array(profile, np.float64)
    along = np.diff(points, axis=0)
    slopes = np.stack([along[:, 1], -along[:, 0]], axis=1)
    slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
    if smooth:
        slopes = np.vstack([slopes[:1], slopes[1:] + slopes[:-1], slopes[-1:]])
        bands = np.arange(len(points) - 1)
    else:
        points = np.repeat(points, 2, axis=0)[1:-1]
        slopes = np.repeat(slopes, 2, axis=0)
        bands = np.arange(0, len(points), 2)
    return mesh_of(_turned(points, around), _turned(slopes, around), _bands(bands, around))


def _turned(rows: Array, around: int) -> Array:
    """Turn (R, 2) of radius and height into positions (R * around, 3)."""
    angles = 2 * np.pi * np.arange(around) / around
    circle = np.stack([np.sin(angles), np.zeros(around), np.cos(angles)], axis=1)
    turned = rows[:, None, :1] * circle + rows[:, None, 1:] * np.array([0.0, 1.0, 0.0])
    return np.asarray(turned.reshape(-1, 3))


def _bands(starts: npt.NDArray[np.int64], around: int) -> npt.NDArray[np.int64]:
    """Return the triangles between each ring of `starts` and the one after it."""
    i = np.arange(around)
    j = (i + 1) % around
    quads = np.stack([i, j, j + around, i + around], axis=1)
    return np.concatenate([(quads + start * around)[:, [0, 1, 2, 0, 2, 3]] for start in starts])


def mesh_of(positions: Array, normals: Array, triangles: npt.NDArray[np.int64]) -> Mesh:
    """Return a mesh without triangles of zero area and with normals of length 1."""
    rows = triangles.reshape(-1, 3)
    a, b, c = (positions[rows[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Mesh(
        positions.astype(np.float32),
        (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32),
        np.zeros((len(positions), 2), np.float32),
        rows[area > 1e-12].astype(np.uint32),
    )


def sphere(radius_m: float, around: int = 10, rows: int = 6) -> Mesh:
    """Return a sphere around the origin."""
    angles = np.pi * (np.arange(rows + 1) / rows - 0.5)
    return lathe([(abs(radius_m * np.cos(a)), radius_m * np.sin(a)) for a in angles], around)


def limb(top_m: float, bottom_m: float, length_m: float, around: int = 8) -> Mesh:
    """Return a limb that hangs from a joint at the origin and is round at both ends.

    The radii are those at its two ends.
    """
    caps = np.array([90.0, 55.0, 20.0]) * np.pi / 180
    low = [(bottom_m * np.cos(a), -length_m - bottom_m * np.sin(a)) for a in caps]
    high = [(top_m * np.cos(a), top_m * np.sin(a)) for a in reversed(caps)]
    return lathe([(abs(r), float(y)) for r, y in (*low, *high)], around)


def box(width_m: float, height_m: float, depth_m: float) -> Mesh:
    """Return a box whose base is centred at the origin."""
    lid = quads([np.array([(-1, 1, 1), (1, 1, 1), (1, 1, -1), (-1, 1, -1)])])
    quarter = np.pi / 2
    turns = [turned_x(i * quarter) for i in range(4)] + [turned_z(i * quarter) for i in (1, 3)]
    stretched = moved(0, height_m / 2, 0) @ scaled(width_m / 2, height_m / 2, depth_m / 2)
    return placed(joined(placed(lid, turn) for turn in turns), stretched)


def quads(corners: Iterable[Array]) -> Mesh:
    """Return flat faces of four corners, (4, 3) each, counter-clockwise seen from the front."""
    faces = np.stack([np.asarray(face, np.float64) for face in corners])
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 3] - faces[:, 0])
    first = 4 * np.arange(len(faces))[:, None]
    return mesh_of(
        faces.reshape(-1, 3), np.repeat(normals, 4, axis=0), first + np.array([[0, 1, 2, 0, 2, 3]])
    )


def tube(points: Sequence[Point], radius_m: float, sides: int = 4) -> Mesh:
    """Return a wire or a rail through `points`; none of its pieces may be vertical."""
    middle = np.array(points, np.float64)
    along = np.gradient(middle, axis=0)
    across = np.cross(along, (0.0, 1.0, 0.0))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    downward = np.cross(along, across)
    downward /= np.linalg.norm(downward, axis=1, keepdims=True)
    angles = 2 * np.pi * np.arange(sides) / sides
    ring = across[:, None] * np.cos(angles)[:, None] + downward[:, None] * np.sin(angles)[:, None]
    positions = middle[:, None] + radius_m * ring
    rows = _bands(np.arange(len(middle) - 1), sides)
    return mesh_of(positions.reshape(-1, 3), ring.reshape(-1, 3), rows)


def joined(meshes: Iterable[Mesh]) -> Mesh:
    """Return several meshes as one with the material of the first."""
    parts = list(meshes)
    starts = np.cumsum([0, *(len(part.positions_m) for part in parts)])
    return Mesh(
        np.concatenate([part.positions_m for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.uvs for part in parts]),
        np.concatenate(
            [part.triangles + np.uint32(s) for part, s in zip(parts, starts, strict=False)]
        ),
        parts[0].material,
    )


def placed(mesh: Mesh, to_world: Array) -> Mesh:
    """Return the mesh moved by `to_world` (4, 4), which may also stretch it."""
    turn = to_world[:3, :3]
    normals = mesh.normals @ np.linalg.inv(turn)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return replace(
        mesh,
        positions_m=(mesh.positions_m @ turn.T + to_world[:3, 3]).astype(np.float32),
        normals=normals.astype(np.float32),
    )


def moved(x: float, y: float, z: float) -> Array:
    """Return a translation (4, 4) in metres."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def turned_x(angle: float) -> Array:
    """Return a rotation (4, 4) about x in radians, which turns +y towards +z."""
    matrix = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    matrix[1:3, 1:3] = [[c, -s], [s, c]]
    return matrix


def turned_y(angle: float) -> Array:
    """Return a rotation (4, 4) about y in radians, which turns +z towards +x."""
    matrix = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    matrix[np.ix_((0, 2), (0, 2))] = [[c, s], [-s, c]]
    return matrix


def turned_z(angle: float) -> Array:
    """Return a rotation (4, 4) about z in radians, which turns +x upwards."""
    matrix = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    matrix[:2, :2] = [[c, -s], [s, c]]
    return matrix


def scaled(x: float, y: float, z: float) -> Array:
    """Return a scale (4, 4) along each axis."""
    return np.diag([x, y, z, 1.0])
