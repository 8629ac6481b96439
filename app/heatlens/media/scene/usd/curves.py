"""Curves and points of USD: curves as thin tubes, points as small solids."""

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.files.usd_library import UsdObject, numbers, usd_module, whole_numbers
from heatlens.media.scene.mesh_make import made_mesh
from heatlens.media.scene.point_cloud import POINTS_MOST, drawn_points
from heatlens.media.scene.primitives import f32, tubes
from heatlens.media.scene.scene import Mesh
from heatlens.media.scene.usd.material import UsdMaterials

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_STEPS = 6  # per cubic segment
_MOST = 400_000  # points in all tubes of a prim
_SIDES, _SIDES_OF_MANY, _MANY = 6, 3, 60_000  # sides of a tube; of this many points or more
_THIN = 2e-3  # the default width of curves, relative to their size
# Rows are the powers of t from 0 to 3, columns the four points of a segment.
_BASES = {
    "bezier": np.array([(1, 0, 0, 0), (-3, 3, 0, 0), (3, -6, 3, 0), (-1, 3, -3, 1)]),
    "bspline": np.array([(1, 4, 1, 0), (-3, 0, 3, 0), (3, -6, 3, 0), (-1, 3, -3, 1)]) / 6,
    "catmullRom": np.array([(0, 2, 0, 0), (-1, 0, 1, 0), (2, -5, 4, -1), (-1, 3, -3, 1)]) / 2,
}


def read_curves(materials: UsdMaterials, prim: object) -> list[Mesh]:
    """Return the tubes of BasisCurves; raise InputError if their data are inconsistent."""
    what, first = _what(materials, prim), usd_module("Usd").TimeCode.EarliestTime()
    curves = usd_module("UsdGeom").BasisCurves(prim)
    points = _points(what, curves.GetPointsAttr().Get(first))
    counts = whole_numbers(
        curves.GetCurveVertexCountsAttr().Get(first), f"{what}: curveVertexCounts"
    )
    if counts.size and (counts.min() < 0 or counts.sum() != len(points)):
        raise InputError(f"{what}: the counts of its curves do not match its points.")
    if not len(points):
        return []
    widths = _widths(what, curves.GetWidthsAttr().Get(first), points, counts)
    colors, material = _colors(materials, prim, len(points), counts)
    lines = _Lines(np.column_stack([points, widths, colors]), counts).evaluated(curves)
    if len(lines.rows) > _MOST:
        lines = lines.some(_MOST)
        materials.notes[f"Of curves with very many points, only {_MOST:,} are drawn."] = None
    if not len(lines.rows):
        return []
    sides = _SIDES if len(lines.rows) < _MANY else _SIDES_OF_MANY
    rows = lines.rows
    at, normals, triangles, whose = tubes(rows[:, :3], 0.5 * rows[:, 3], lines.counts, sides)
    tint = rows[whose, 4:].astype(np.float32)
    return [made_mesh(what, f32(at), triangles, f32(normals), None, material, tint)]


def read_points(materials: UsdMaterials, prim: object) -> list[Mesh]:
    """Return the solids of UsdGeom.Points."""
    what, first = _what(materials, prim), usd_module("Usd").TimeCode.EarliestTime()
    prim_points = usd_module("UsdGeom").Points(prim)
    points = _points(what, prim_points.GetPointsAttr().Get(first))
    if not len(points):
        return []
    widths = numbers(prim_points.GetWidthsAttr().Get(first), 1, f"{what}: widths")[:, 0]
    normals = numbers(prim_points.GetNormalsAttr().Get(first), 3, f"{what}: normals")
    radii = None
    if len(widths) in (1, len(points)):
        radii = np.broadcast_to(0.5 * np.nan_to_num(widths.astype(np.float64)), len(points))
    if len(points) > POINTS_MOST:
        materials.notes[f"Only {POINTS_MOST:,} points of very large point sets are drawn."] = None
    facing = normals.astype(np.float64) if len(normals) == len(points) else None
    drawn = drawn_points(points, radii, facing)
    colors, material = _colors(materials, prim, len(points), np.ones(len(points), np.int64))
    at, turned = f32(drawn.positions), f32(drawn.normals)
    tint = colors[drawn.point].astype(np.float32)
    return [made_mesh(what, at, drawn.triangles, turned, None, material, tint)]


class _Lines:
    """Rows (P, n) of position, width and color along one curve after the other."""

    def __init__(self, rows: Array, counts: Indices) -> None:
        self.rows = rows
        self.counts = counts

    def evaluated(self, curves: UsdObject) -> "_Lines":
        """Return the points of linear or cubic curves, to be joined by straight lines."""
        kind, wrap = str(curves.GetTypeAttr().Get()), str(curves.GetWrapAttr().Get())
        basis = str(curves.GetBasisAttr().Get())
        if kind == "linear" or basis not in _BASES:
            return self._closed() if wrap == "periodic" else self
        return self._cubic(basis, wrap)

    def some(self, most: int) -> "_Lines":
        """Return an even selection of the curves with about `most` points in total."""
        share = max(1, int(len(self.counts) * most / max(len(self.rows), 1)))
        chosen = np.zeros(len(self.counts), bool)
        chosen[np.linspace(0, len(self.counts) - 1, share).astype(int)] = True
        return _Lines(self.rows[np.repeat(chosen, self.counts)], self.counts[chosen])

    def _closed(self) -> "_Lines":
        """Return the curves with their first point repeated at the end."""
        some = self.counts > 0
        lasts = np.cumsum(self.counts)[some]
        rows = np.insert(self.rows, lasts, self.rows[lasts - self.counts[some]], axis=0)
        return _Lines(rows, self.counts + some)

    def _cubic(self, basis: str, wrap: str) -> "_Lines":
        """Return points along the segments of cubic curves."""
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
        some = segments > 0
        lasts = np.cumsum(segments)[some]
        flat = inner.reshape(-1, self.rows.shape[1])
        rows = np.insert(flat, lasts * _STEPS, ends[lasts - 1], axis=0)
        return _Lines(rows, segments * _STEPS + some)


def _windows(count: int, step: int, basis: str, wrap: str) -> Indices:
    """Return (S, 4), the indices of the four points of each segment of a curve."""
    if count < 2 or (count < 4 and wrap != "pinned"):
        return np.zeros((0, 4), np.int64)
    places = np.arange(count)
    if wrap == "periodic":
        segments = max(count // step, 0)
        return np.asarray((np.arange(segments)[:, None] * step + np.arange(4)) % count)
    if wrap == "pinned" and basis != "bezier":
        # Repeating the end points makes the curve reach them, or nearly so.
        places = np.concatenate([[0], places, [count - 1]])
    segments = (len(places) - 4) // step + 1
    return np.asarray(places[np.arange(max(segments, 0))[:, None] * step + np.arange(4)])


def _what(materials: UsdMaterials, prim: UsdObject) -> str:
    return f"{materials.stage.path}: {prim.GetPath()}"


def _points(what: str, stored: UsdObject) -> Array:
    points = numbers(stored, 3, f"{what}: points")
    if not np.isfinite(points).all():
        raise InputError(f"{what}: a point is at NaN or infinity.")
    return points.astype(np.float64)


def _widths(what: str, stored: object, points: Array, counts: Indices) -> Array:
    """Return (P,) widths: constant, per curve or per point; a thin default if none fits."""
    widths = np.nan_to_num(numbers(stored, 1, f"{what}: widths")[:, 0].astype(np.float64))
    if len(widths) == len(points):
        return widths
    if len(widths) == len(counts):
        return np.repeat(widths, counts)
    thin = _THIN * float(np.linalg.norm(np.ptp(points, axis=0))) or 1e-3
    return np.full(len(points), widths[0] if len(widths) else thin)


def _colors(
    materials: UsdMaterials, prim: object, points: int, counts: Indices
) -> tuple[Array, int]:
    """Return (P, 3) colors that multiply the base color, and the material."""
    primvar = usd_module("UsdGeom").PrimvarsAPI(prim).GetPrimvar("displayColor")
    stored = primvar.ComputeFlattened() if primvar else None
    values = numbers(stored, 3, f"{_what(materials, prim)}: displayColor").astype(np.float64)
    own = None
    if len(values) > 1 and len(values) == points:
        own = values
    elif len(values) > 1 and len(values) == len(counts):
        own = np.repeat(values, counts, axis=0)
    material = materials.of(prim, own is not None)
    if own is None or material in materials.shaders:
        own = np.ones((points, 3))
    return own, material
