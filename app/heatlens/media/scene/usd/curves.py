"""Curves and points of USD: curves as thin tubes, points as small solids."""

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.files.usd_library import UsdObject, float_array, integer_array, usd_module
from heatlens.media.scene.mesh_make import make_mesh
from heatlens.media.scene.point_cloud import POINTS_MOST, make_point_solids
from heatlens.media.scene.primitives import convert_to_float32, make_tubes
from heatlens.media.scene.scene import Mesh
from heatlens.media.scene.usd.material import UsdMaterials

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_STEPS = 6  # points per cubic segment
_TUBE_POINTS_MOST = 400_000  # points in all tubes of a prim
_SIDES, _SIDES_OF_MANY, _MANY = 6, 3, 60_000  # sides of a tube; fewer from so many points on
_DEFAULT_WIDTH = 2e-3  # default width of curves, relative to their size
# Rows are the powers of t from 0 to 3, columns the four points of a segment.
_BASES = {
    "bezier": np.array([(1, 0, 0, 0), (-3, 3, 0, 0), (3, -6, 3, 0), (-1, 3, -3, 1)]),
    "bspline": np.array([(1, 4, 1, 0), (-3, 0, 3, 0), (3, -6, 3, 0), (-1, 3, -3, 1)]) / 6,
    "catmullRom": np.array([(0, 2, 0, 0), (-1, 0, 1, 0), (2, -5, 4, -1), (-1, 3, -3, 1)]) / 2,
}


def read_curves(materials: UsdMaterials, prim: object) -> list[Mesh]:
    """Return the tubes of BasisCurves; raise InputError if their data are inconsistent."""
    label, first_time = _describe(materials, prim), usd_module("Usd").TimeCode.EarliestTime()
    curves = usd_module("UsdGeom").BasisCurves(prim)
    points = _convert_points(label, curves.GetPointsAttr().Get(first_time))
    counts = integer_array(
        curves.GetCurveVertexCountsAttr().Get(first_time), f"{label}: curveVertexCounts"
    )
    if counts.size and (counts.min() < 0 or counts.sum() != len(points)):
        raise InputError(f"{label}: the counts of its curves do not match its points.")
    if not len(points):
        return []
    widths = _choose_widths(label, curves.GetWidthsAttr().Get(first_time), points, counts)
    colors, material = _read_colors(materials, prim, len(points), counts)
    lines = _Lines(np.column_stack([points, widths, colors]), counts).evaluate(curves)
    if len(lines.rows) > _TUBE_POINTS_MOST:
        lines = lines.select_evenly(_TUBE_POINTS_MOST)
        materials.notes[
            f"Of curves with very many points, only {_TUBE_POINTS_MOST:,} are drawn."
        ] = None
    if not len(lines.rows):
        return []
    sides = _SIDES if len(lines.rows) < _MANY else _SIDES_OF_MANY
    rows = lines.rows
    positions, normals, triangles, point_index = make_tubes(
        rows[:, :3], 0.5 * rows[:, 3], lines.counts, sides
    )
    vertex_colors = rows[point_index, 4:].astype(np.float32)
    return [
        make_mesh(
            label,
            convert_to_float32(positions),
            triangles,
            convert_to_float32(normals),
            uvs=None,
            material=material,
            colors=vertex_colors,
        )
    ]


def read_points(materials: UsdMaterials, prim: object) -> list[Mesh]:
    """Return the solids drawn for UsdGeom.Points; none if it has no points."""
    label, first_time = _describe(materials, prim), usd_module("Usd").TimeCode.EarliestTime()
    prim_points = usd_module("UsdGeom").Points(prim)
    points = _convert_points(label, prim_points.GetPointsAttr().Get(first_time))
    if not len(points):
        return []
    widths = float_array(prim_points.GetWidthsAttr().Get(first_time), 1, f"{label}: widths")[:, 0]
    normals = float_array(prim_points.GetNormalsAttr().Get(first_time), 3, f"{label}: normals")
    radii = None
    if len(widths) in (1, len(points)):
        radii = np.broadcast_to(0.5 * np.nan_to_num(widths.astype(np.float64)), len(points))
    if len(points) > POINTS_MOST:
        materials.notes[f"Only {POINTS_MOST:,} points of very large point sets are drawn."] = None
    point_normals = normals.astype(np.float64) if len(normals) == len(points) else None
    solids = make_point_solids(points, radii, point_normals)
    colors, material = _read_colors(materials, prim, len(points), np.ones(len(points), np.int64))
    positions = convert_to_float32(solids.positions)
    solid_normals = convert_to_float32(solids.normals)
    vertex_colors = colors[solids.point].astype(np.float32)
    return [
        make_mesh(
            label,
            positions,
            solids.triangles,
            solid_normals,
            uvs=None,
            material=material,
            colors=vertex_colors,
        )
    ]


class _Lines:
    """Points on curves: rows (P, n) of position, width and color, one curve after the other.

    `counts` (C,) holds the number of points of each curve.
    """

    def __init__(self, rows: Array, counts: Indices) -> None:
        self.rows = rows
        self.counts = counts

    def evaluate(self, curves: UsdObject) -> "_Lines":
        """Return points on linear or cubic curves that are close enough for straight lines."""
        curve_type, wrap = str(curves.GetTypeAttr().Get()), str(curves.GetWrapAttr().Get())
        basis = str(curves.GetBasisAttr().Get())
        if curve_type == "linear" or basis not in _BASES:
            return self._close() if wrap == "periodic" else self
        return self._sample_cubic(basis, wrap)

    def select_evenly(self, points_most: int) -> "_Lines":
        """Return an even selection of the curves with about `points_most` points in total."""
        curve_count = max(1, int(len(self.counts) * points_most / max(len(self.rows), 1)))
        is_chosen = np.zeros(len(self.counts), bool)
        is_chosen[np.linspace(0, len(self.counts) - 1, curve_count).astype(int)] = True
        return _Lines(self.rows[np.repeat(is_chosen, self.counts)], self.counts[is_chosen])

    def _close(self) -> "_Lines":
        """Return the curves with their first point repeated at the end."""
        has_points = self.counts > 0
        lasts = np.cumsum(self.counts)[has_points]
        rows = np.insert(self.rows, lasts, self.rows[lasts - self.counts[has_points]], axis=0)
        return _Lines(rows, self.counts + has_points)

    def _sample_cubic(self, basis: str, wrap: str) -> "_Lines":
        """Return points along cubic curves: _STEPS for each segment, and the end of the curve."""
        step = 3 if basis == "bezier" else 1
        pieces = [_windows(int(count), step, basis, wrap) for count in np.unique(self.counts)]
        shapes = dict(zip(np.unique(self.counts).tolist(), pieces, strict=True))
        firsts = np.cumsum(self.counts) - self.counts
        windows = [
            shapes[count] + first
            for count, first in zip(self.counts.tolist(), firsts.tolist(), strict=True)
        ]
        segments = np.array([len(window) for window in windows], np.int64)
        if not segments.sum():
            return _Lines(self.rows[:0], segments)
        t = np.arange(_STEPS) / _STEPS
        powers = np.stack([t**0, t, t**2, t**3], axis=1)
        corners = self.rows[np.concatenate(windows)]
        inner = np.einsum("sk,kp,wpn->wsn", powers, _BASES[basis], corners)
        # Every curve ends with the end of its last segment.
        ends = np.einsum("k,kp,wpn->wn", np.ones(4), _BASES[basis], corners)
        has_segments = segments > 0
        lasts = np.cumsum(segments)[has_segments]
        inner_rows = inner.reshape(-1, self.rows.shape[1])
        rows = np.insert(inner_rows, lasts * _STEPS, ends[lasts - 1], axis=0)
        return _Lines(rows, segments * _STEPS + has_segments)


def _windows(count: int, step: int, basis: str, wrap: str) -> Indices:
    """Return the indices (S, 4) of the four points that control each segment of a curve."""
    if count < 2 or (count < 4 and wrap != "pinned"):
        return np.zeros((0, 4), np.int64)
    indices = np.arange(count)
    if wrap == "periodic":
        segments = max(count // step, 0)
        return np.asarray((np.arange(segments)[:, None] * step + np.arange(4)) % count)
    if wrap == "pinned" and basis != "bezier":
        # With repeated end points the curve reaches them, or nearly so.
        indices = np.concatenate([[0], indices, [count - 1]])
    segments = (len(indices) - 4) // step + 1
    return np.asarray(indices[np.arange(max(segments, 0))[:, None] * step + np.arange(4)])


def _describe(materials: UsdMaterials, prim: UsdObject) -> str:
    """Return the file and the path of a prim, with which error messages begin."""
    return f"{materials.stage.path}: {prim.GetPath()}"


def _convert_points(label: str, stored: UsdObject) -> Array:
    """Return points (P, 3) of the file; raise InputError if some are not finite."""
    points = float_array(stored, 3, f"{label}: points")
    if not np.isfinite(points).all():
        raise InputError(
            f"{label}: a point has no finite place (NaN or infinity). Export it again."
        )
    return points.astype(np.float64)


def _choose_widths(label: str, stored: object, points: Array, counts: Indices) -> Array:
    """Return the widths (P,): constant, per curve or per point; a thin default if none fits."""
    widths = np.nan_to_num(float_array(stored, 1, f"{label}: widths")[:, 0].astype(np.float64))
    if len(widths) == len(points):
        return widths
    if len(widths) == len(counts):
        return np.repeat(widths, counts)
    default_width = _DEFAULT_WIDTH * float(np.linalg.norm(np.ptp(points, axis=0))) or 1e-3
    return np.full(len(points), widths[0] if len(widths) else default_width)


def _read_colors(
    materials: UsdMaterials, prim: object, points: int, counts: Indices
) -> tuple[Array, int]:
    """Return colors (P, 3) that multiply the base color, and the number of the material."""
    primvar = usd_module("UsdGeom").PrimvarsAPI(prim).GetPrimvar("displayColor")
    stored = primvar.ComputeFlattened() if primvar else None
    values = float_array(stored, 3, f"{_describe(materials, prim)}: displayColor").astype(
        np.float64
    )
    point_colors = None
    if len(values) > 1 and len(values) == points:
        point_colors = values
    elif len(values) > 1 and len(values) == len(counts):
        point_colors = np.repeat(values, counts, axis=0)
    material = materials.number_of(prim, point_colors is not None)
    if point_colors is None or material in materials.shaders:
        point_colors = np.ones((points, 3))
    return point_colors, material
