"""Triangles of USD meshes: polygons are split into fans, and each corner becomes a vertex.

Here it is decided too which meshes are subdivided, how often, and where they stay sharp.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.files.usd_library import UsdObject, numbers, usd_module, whole_numbers
from heatlens.media.scene.mesh_make import made_mesh, smooth_normals
from heatlens.media.scene.scene import Mesh
from heatlens.media.scene.subdivision import Polygons, corner_normals, subdivided
from heatlens.media.scene.usd.material import UsdMaterials

_LEVELS = 2  # as Blender and most renderers show it by default
_MOST_OF_MESH, _MOST = 400_000, 1_000_000  # quads
_SHARP = 10.0  # USD's value for an infinitely sharp crease


@dataclass
class Subdivision:
    """Subdivides meshes up to a limit on the number of quads.

    left_out  meshes drawn as their cages, because they would have too many quads
    once      meshes that were subdivided once instead of twice
    loops     meshes of another scheme, Loop's for triangles, which are drawn as their cages
    """

    room: int = _MOST
    left_out: int = 0
    once: int = 0
    loops: int = 0

    def refined(self, what: str, mesh: object, cage: Polygons) -> Polygons | None:
        """Return the subdivision surface of `cage`; None if the cage itself is drawn.

        Raises InputError if its creases are not numbers.
        """
        if not self._is_wanted(mesh):
            return None
        levels = self._levels(len(cage.corners))
        if not levels or not len(cage.corners):
            return None
        finer = _creased(what, mesh, cage)
        for _ in range(levels):
            finer = subdivided(finer)
        self.room -= len(finer.counts)
        return finer

    def _is_wanted(self, mesh: UsdObject) -> bool:
        attribute = mesh.GetSubdivisionSchemeAttr()
        scheme = attribute.Get()
        self.loops += scheme == "loop"
        # If the file names no scheme, polygons with normals are not subdivided.
        normals = mesh.GetPrim().GetAttribute("primvars:normals"), mesh.GetNormalsAttr()
        has_normals = any(attr and attr.HasAuthoredValue() for attr in normals)
        is_meant = attribute.HasAuthoredValue() or not has_normals
        return scheme == "catmullClark" and is_meant

    def _levels(self, corners: int) -> int:
        """Return how often a mesh is subdivided: each level has four times as many quads."""
        room = min(self.room, _MOST_OF_MESH)
        for levels in range(_LEVELS, 0, -1):
            if corners * 4 ** (levels - 1) <= room:
                self.once += levels < _LEVELS
                return levels
        self.left_out += 1
        return 0

    @property
    def notes(self) -> list[str]:
        """Return sentences on the meshes that were not subdivided as intended."""
        counted = (
            (self.once, "subdivided once instead of twice: they have many faces."),
            (self.left_out, "drawn as their cages, because they would have too many faces."),
            (self.loops, "drawn as their cages: the scheme 'loop' is not supported."),
        )
        return [f"{count} subdivision surfaces are {words}" for count, words in counted if count]


def _creased(what: str, mesh: UsdObject, cage: Polygons) -> Polygons:
    """Return the cage with the valid creases and sharp corners of the file."""
    first = usd_module("Usd").TimeCode.EarliestTime()
    indices = whole_numbers(mesh.GetCreaseIndicesAttr().Get(first), f"{what}: creaseIndices")
    lengths = whole_numbers(mesh.GetCreaseLengthsAttr().Get(first), f"{what}: creaseLengths")
    stored = mesh.GetCreaseSharpnessesAttr().Get(first)
    sharpness = numbers(stored, 1, f"{what}: creaseSharpnesses")[:, 0]
    edges, of_chain = _chains(indices, lengths)
    if len(sharpness) not in (len(lengths), len(edges)):
        edges, of_chain = edges[:0], of_chain[:0]
    values = sharpness[of_chain] if len(sharpness) == len(lengths) else sharpness[: len(edges)]
    inside = ((edges >= 0) & (edges < len(cage.points))).all(axis=1)
    points = whole_numbers(mesh.GetCornerIndicesAttr().Get(first), f"{what}: cornerIndices")
    stored = mesh.GetCornerSharpnessesAttr().Get(first)
    corners = numbers(stored, 1, f"{what}: cornerSharpnesses")[:, 0]
    some = min(len(points), len(corners))
    points, corners = points[:some], corners[:some]
    usable = (points >= 0) & (points < len(cage.points))
    return replace(
        cage,
        creases=edges[inside],
        crease_sharpness=_sharp(values[inside]),
        sharp_points=points[usable],
        point_sharpness=_sharp(corners[usable]),
    )


def _chains(
    indices: NDArray[np.int64], lengths: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return (E, 2), the edges of chains of vertices, and (E,), the chain of each edge."""
    none = np.zeros((0, 2), np.int64), np.zeros(0, np.int64)
    if not len(lengths) or lengths.min() < 0 or lengths.sum() != len(indices):
        return none
    chain = np.repeat(np.arange(len(lengths)), lengths)
    joined = chain[:-1] == chain[1:]
    return np.stack([indices[:-1], indices[1:]], axis=1)[joined], chain[:-1][joined]


def _sharp(values: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return sharpness clipped to 0.._SHARP; NaN becomes 0."""
    return np.clip(np.nan_to_num(values.astype(np.float64), nan=0.0, posinf=_SHARP), 0.0, _SHARP)


_UV_NAMES = ("st", "UVMap", "map1", "st0")


def read_parts(materials: UsdMaterials, subdivision: Subdivision, prim: UsdObject) -> list[Mesh]:
    """Return one mesh for each material; raise InputError if the data are inconsistent."""
    geometry = usd_module("UsdGeom")
    what = f"{materials.stage.path}: {prim.GetPath()}"
    time = usd_module("Usd").TimeCode.EarliestTime()
    mesh = geometry.Mesh(prim)
    points = numbers(mesh.GetPointsAttr().Get(time), 3, f"{what}: points")
    counts = whole_numbers(mesh.GetFaceVertexCountsAttr().Get(time), f"{what}: faceVertexCounts")
    corners = whole_numbers(mesh.GetFaceVertexIndicesAttr().Get(time), f"{what}: faceVertexIndices")
    _check(what, points, counts, corners)
    uvs, colors = _uvs(what, prim, corners), _colors(what, prim, len(points), counts, corners)
    cage = _Surface(points, counts, corners, np.arange(len(counts)), None, uvs, colors)
    drawn = _refined(what, subdivision, mesh, cage) or cage
    triangles, faces = _fans(drawn.counts)
    normals = drawn.normals
    if normals is None:
        normals = _normals(what, mesh, points, corners, triangles)
    faces = drawn.faces[faces]
    holes = whole_numbers(mesh.GetHoleIndicesAttr().Get(time), f"{what}: holeIndices")
    is_hole = np.isin(faces, holes)
    meshes = []
    for part, chosen in _by_material(what, prim, faces, len(counts)):
        material = materials.of(part, colors is not None)
        own = triangles[chosen & ~is_hole].astype(np.uint32)
        if len(own):
            used, places = np.unique(own, return_inverse=True)
            own = places.reshape(-1, 3).astype(np.uint32)
            shown = None if material in materials.shaders else drawn.colors
            facing, laid, tint = (
                None if v is None else v[used] for v in (normals, drawn.uvs, shown)
            )
            at = drawn.points[drawn.corners[used]]
            meshes.append(made_mesh(what, at, own, facing, laid, material, tint))
    return meshes


@dataclass(frozen=True, eq=False)
class _Surface:
    """Polygons with the attributes of their corners.

    faces    (F,) the face of the file that each one is a part of
    normals  (corners, 3); None if they are found as for polygons
    """

    points: NDArray[np.float32]
    counts: NDArray[np.int64]
    corners: NDArray[np.int64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float32] | None
    uvs: NDArray[np.float32] | None
    colors: NDArray[np.float32] | None


def _refined(what: str, subdivision: Subdivision, mesh: object, cage: _Surface) -> _Surface | None:
    """Return the subdivision surface of a cage; None if the cage itself is drawn."""
    corner_values = {"uvs": cage.uvs, "colors": cage.colors}
    whole = cage.counts > 2
    of_whole = np.repeat(whole, cage.counts)
    polygons = Polygons(
        cage.points.astype(np.float64),
        cage.counts[whole],
        cage.corners[of_whole],
        {k: v[of_whole].astype(np.float64) for k, v in corner_values.items() if v is not None},
        np.flatnonzero(whole),
    )
    refined = subdivision.refined(what, mesh, polygons)
    if refined is None:
        return None
    values = {name: value.astype(np.float32) for name, value in refined.values.items()}
    points, normals = refined.points.astype(np.float32), corner_normals(refined)
    uvs, colors = values.get("uvs"), values.get("colors")
    return _Surface(points, refined.counts, refined.corners, refined.faces, normals, uvs, colors)


def _check(
    what: str, points: NDArray[np.float32], counts: NDArray[np.int64], corners: NDArray[np.int64]
) -> None:
    if counts.size and (counts.min() < 0 or counts.sum() != len(corners)):
        raise InputError(f"{what}: the corner counts of its polygons do not match its corners.")
    if corners.size and (corners.min() < 0 or corners.max() >= len(points)):
        raise InputError(f"{what}: a polygon refers to a vertex that does not exist.")
    if not np.isfinite(points).all():
        raise InputError(f"{what}: a vertex is at NaN or infinity.")


def _fans(counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return (T, 3) triangles of corners, and (T,) the face that each belongs to."""
    sizes = np.maximum(counts - 2, 0)
    faces = np.repeat(np.arange(len(counts)), sizes)
    firsts = (np.cumsum(counts) - counts)[faces]
    steps = np.arange(len(faces)) - (np.cumsum(sizes) - sizes)[faces]
    return np.stack([firsts, firsts + steps + 1, firsts + steps + 2], axis=1), faces


def _normals(
    what: str,
    mesh: UsdObject,
    points: NDArray[np.float32],
    corners: NDArray[np.int64],
    triangles: NDArray[np.int64],
) -> NDArray[np.float32] | None:
    """Return (corners, 3): the file's, or smooth ones of a subdivision surface; None for flat."""
    primvar = usd_module("UsdGeom").PrimvarsAPI(mesh.GetPrim()).GetPrimvar("normals")
    stored = primvar.ComputeFlattened() if primvar else mesh.GetNormalsAttr().Get()
    values = numbers(stored, 3, f"{what}: normals")
    if len(values) == len(corners) and len(values):
        return values
    if len(values) == len(points) and len(values):
        return np.asarray(values[corners])
    if mesh.GetSubdivisionSchemeAttr().Get() == "none" or not len(triangles):
        return None
    return np.asarray(smooth_normals(points, corners[triangles].astype(np.uint32))[corners])


def _uvs(what: str, prim: object, corners: NDArray[np.int64]) -> NDArray[np.float32] | None:
    """Return (corners, 2) with v downwards."""
    primvars = usd_module("UsdGeom").PrimvarsAPI(prim)
    for name in _UV_NAMES:
        stored = primvars.GetPrimvar(name).ComputeFlattened() if primvars.HasPrimvar(name) else None
        values = numbers(stored, 2, f"{what}: {name}")
        if not len(values):
            continue
        values[:, 1] = 1 - values[:, 1]
        if len(values) == len(corners):
            return np.asarray(values)
        if corners.size and len(values) > corners.max():
            return np.asarray(values[corners])
    return None


def _colors(
    what: str, prim: object, points: int, counts: NDArray[np.int64], corners: NDArray[np.int64]
) -> NDArray[np.float32] | None:
    """Return (corners, 3) of displayColor, linear; None for a constant, which the material has."""
    primvar = usd_module("UsdGeom").PrimvarsAPI(prim).GetPrimvar("displayColor")
    stored = primvar.ComputeFlattened() if primvar else None
    values = numbers(stored, 3, f"{what}: displayColor")
    kind = primvar.GetInterpolation() if len(values) > 1 else "constant"
    if kind == "uniform" and len(values) == len(counts):
        return np.repeat(values, counts, axis=0)
    if kind in ("vertex", "varying") and len(values) == points:
        return np.asarray(values[corners])
    return values if kind == "faceVarying" and len(values) == len(corners) else None


def _by_material(
    what: str, prim: object, faces: NDArray[np.int64], count: int
) -> list[tuple[object, NDArray[np.bool_]]]:
    """Return the prim of each part with its own material, and a mask of its triangles."""
    binding = usd_module("UsdShade").MaterialBindingAPI(prim)
    rest = np.ones(count, bool)
    groups = []
    for subset in binding.GetMaterialBindSubsets():
        listed = whole_numbers(subset.GetIndicesAttr().Get(), f"{what}: indices of a subset")
        chosen = np.zeros(count, bool)
        chosen[listed[(listed >= 0) & (listed < count)]] = True
        groups.append((subset.GetPrim(), (chosen & rest)[faces]))
        rest &= ~chosen
    return [*groups, (prim, rest[faces])]
