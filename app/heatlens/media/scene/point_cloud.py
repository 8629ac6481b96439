"""Draw points without faces, as scanners write them, as small solids or small discs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POINTS_MOST = 500_000  # if there are more, some are left out evenly and the others are larger
_BALL_COST = 8  # triangles of a ball divided by those of a tetrahedron
_SAMPLES = 96  # points whose distance to the nearest other point is measured
_SPACING_TO_RADIUS = (
    0.7  # radius as a part of the spacing, so that points of a surface just close it
)
_ROUND_MOST = 4_000  # up to this many points are drawn as balls, more as tetrahedra
_SOLID = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / np.sqrt(3)
_SOLID_FACES = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])
# Has the area of a disc.
_DISC = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * np.sqrt(np.pi) / 2
_DISC_FACES = np.array([(0, 1, 2), (0, 2, 3)])


@dataclass(frozen=True, eq=False)
class PointSolids:
    """The solids drawn for points.

    Positions (V, 3), normals (V, 3), triangles (T, 3), and the index of each vertex's point (V,).
    """

    positions: Array
    normals: Array
    triangles: NDArray[np.uint32]
    point: NDArray[np.int64]


def make_point_solids(
    positions: Array,
    radii: Array | None = None,
    normals: Array | None = None,
    points_most: int = POINTS_MOST,
) -> PointSolids:
    """Return solids with radii (P,) at positions (P, 3), or discs if there are normals (P, 3).

    The default radius just closes a surface of such points. If there are more than `points_most`,
    some are left out evenly and the others are larger. About that many solids are drawn.
    """
    chosen = _choose_evenly(len(positions), points_most)
    centers = positions[chosen]
    if radii is None:
        sizes = np.full(len(centers), closing_radius(centers))
    else:
        sizes = radii[chosen] * np.sqrt(len(positions) / max(len(centers), 1))
    if normals is None:
        has_few = len(centers) <= min(_ROUND_MOST, points_most // _BALL_COST)
        solid, faces = _make_ball() if has_few else (_SOLID, _SOLID_FACES)
        solid_normals = offsets = np.broadcast_to(solid, (len(centers), *solid.shape))
    else:
        side, up, unit = _tangent_frame(normals[chosen])
        offsets = _DISC[:, :1] * side[:, None] + _DISC[:, 1:] * up[:, None]
        solid_normals, faces = np.repeat(unit[:, None], 4, axis=1), _DISC_FACES
    vertices_each = offsets.shape[1]
    triangles = faces[None] + vertices_each * np.arange(len(centers))[:, None, None]
    return PointSolids(
        positions=(centers[:, None] + sizes[:, None, None] * offsets).reshape(-1, 3),
        normals=np.asarray(solid_normals, np.float64).reshape(-1, 3),
        triangles=triangles.reshape(-1, 3).astype(np.uint32),
        point=np.repeat(chosen, vertices_each),
    )


def _make_ball() -> tuple[Array, NDArray[np.int64]]:
    """Return corners (V, 3) and triangles of an octahedron whose sides are divided into four."""
    signs = np.array(np.meshgrid((1, -1), (1, -1), (1, -1), indexing="ij")).reshape(3, 8).T
    corners = signs[:, :, None] * np.eye(3)  # the corners of the eight sides
    flips = signs.prod(axis=1) < 0
    corners[flips] = corners[flips][:, ::-1]
    a, b, c = (corners[:, i] for i in range(3))
    ab, bc, ca = ((p + q) / np.sqrt(2) for p, q in ((a, b), (b, c), (c, a)))
    parts = [
        np.stack(side_corners, axis=1)
        for side_corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    ]
    vertices = np.concatenate(parts).reshape(-1, 3)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


# The size of points is not in a scanner's file. If they are too small, the background shows between
# them; if they are too large, edges swell.
def closing_radius(positions: Array) -> float:
    """Return the radius with which the points of a surface just close it.

    It is derived from the distances between some points and their nearest neighbors.
    """
    if len(positions) < 2:
        return 0.01
    chosen = np.unique(np.linspace(0, len(positions) - 1, _SAMPLES).astype(int))
    nearest = [_nearest_distance(positions, index) for index in chosen]
    distances = np.array([distance for distance in nearest if distance > 0])
    size = float(np.ptp(positions, axis=0).max())
    return (
        _SPACING_TO_RADIUS * float(np.median(distances))
        if len(distances)
        else max(1e-2 * size, 1e-6)
    )


def _nearest_distance(positions: Array, index: int) -> float:
    """Return the distance to the nearest point at another position; 0 if there is none."""
    squares = ((positions - positions[index]) ** 2).sum(axis=1)
    squares_above_0 = squares[squares > 0]
    return float(np.sqrt(squares_above_0.min())) if len(squares_above_0) else 0.0


def _choose_evenly(count: int, points_most: int) -> NDArray[np.int64]:
    """Return the indices of the points to draw, evenly spread among all."""
    if count <= points_most:
        return np.arange(count)
    return np.linspace(0, count - 1, max(points_most, 1)).astype(np.int64)


def _tangent_frame(normals: Array) -> tuple[Array, Array, Array]:
    """Return two unit vectors perpendicular to each normal, and the normalized normal."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    has_direction = np.isfinite(lengths) & (lengths > 1e-12)
    unit = np.where(has_direction, normals / np.where(has_direction, lengths, 1.0), (0.0, 1.0, 0.0))
    other_axis = np.eye(3)[np.argmin(np.abs(unit), axis=1)]
    side = np.cross(unit, other_axis)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return side, np.cross(unit, side), unit
