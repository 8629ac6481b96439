"""Triangles of USD meshes: polygons are split into fans, and each corner becomes a vertex.

This module also decides which meshes are subdivided, how often, and where they stay sharp.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.files.usd_library import UsdObject, float_array, integer_array, usd_module
from heatlens.media.scene.mesh_make import make_mesh, smooth_normals
from heatlens.media.scene.scene import Mesh
from heatlens.media.scene.subdivision import Polygons, corner_normals
from heatlens.media.scene.usd.material import UsdMaterials
from heatlens.media.scene.usd.subdivision import Subdivision

_UV_NAMES = ("st", "UVMap", "map1", "st0")


def read_mesh_parts(
    materials: UsdMaterials, subdivision: Subdivision, prim: UsdObject
) -> list[Mesh]:
    """Return one mesh for each material; raise InputError if the data are inconsistent."""
    geometry = usd_module("UsdGeom")
    label = f"{materials.stage.path}: {prim.GetPath()}"
    time = usd_module("Usd").TimeCode.EarliestTime()
    mesh = geometry.Mesh(prim)
    points = float_array(mesh.GetPointsAttr().Get(time), 3, f"{label}: points")
    counts = integer_array(mesh.GetFaceVertexCountsAttr().Get(time), f"{label}: faceVertexCounts")
    indices = mesh.GetFaceVertexIndicesAttr().Get(time)
    corners = integer_array(indices, f"{label}: faceVertexIndices")
    _check_polygons(label, points, counts, corners)
    uvs = _read_uvs(label, prim, corners)
    colors = _read_colors(label, prim, len(points), counts, corners)
    cage = _Surface(
        points, counts, corners, np.arange(len(counts)), normals=None, uvs=uvs, colors=colors
    )
    surface = _subdivide_surface(label, subdivision, mesh, cage) or cage
    triangles, faces = _make_fans(surface.counts)
    normals = surface.normals
    if normals is None:
        normals = _read_normals(label, mesh, points, corners, triangles)
    faces = surface.faces[faces]
    holes = integer_array(mesh.GetHoleIndicesAttr().Get(time), f"{label}: holeIndices")
    is_hole = np.isin(faces, holes)
    meshes = []
    for part_prim, is_in_part in _split_by_material(label, prim, faces, len(counts)):
        material = materials.number_of(part_prim, colors is not None)
        part_triangles = triangles[is_in_part & ~is_hole].astype(np.uint32)
        if len(part_triangles):
            used_corners, renumbered = np.unique(part_triangles, return_inverse=True)
            part_triangles = renumbered.reshape(-1, 3).astype(np.uint32)
            surface_colors = None if material in materials.shaders else surface.colors
            part_normals, part_uvs, part_colors = (
                None if v is None else v[used_corners]
                for v in (normals, surface.uvs, surface_colors)
            )
            part_positions = surface.points[surface.corners[used_corners]]
            shape = part_positions, part_triangles, part_normals, part_uvs
            meshes.append(make_mesh(label, *shape, material, part_colors))
    return meshes


@dataclass(frozen=True, eq=False)
class _Surface:
    """Polygons with the attributes of their corners.

    faces    (F,) the face of the file that each polygon is a part of
    normals  (corners, 3); None if those of the file are used, or derived ones
    """

    points: NDArray[np.float32]
    counts: NDArray[np.int64]
    corners: NDArray[np.int64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float32] | None
    uvs: NDArray[np.float32] | None
    colors: NDArray[np.float32] | None


def _subdivide_surface(
    label: str, subdivision: Subdivision, mesh: object, cage: _Surface
) -> _Surface | None:
    """Return the subdivision surface of a cage; None if the cage itself is drawn."""
    corner_values = {"uvs": cage.uvs, "colors": cage.colors}
    is_polygon = cage.counts > 2
    is_polygon_corner = np.repeat(is_polygon, cage.counts)
    polygons = Polygons(
        cage.points.astype(np.float64),
        cage.counts[is_polygon],
        cage.corners[is_polygon_corner],
        {
            name: values_of_corners[is_polygon_corner].astype(np.float64)
            for name, values_of_corners in corner_values.items()
            if values_of_corners is not None
        },
        np.flatnonzero(is_polygon),
    )
    refined = subdivision.subdivide_cage(label, mesh, polygons)
    if refined is None:
        return None
    values = {name: value.astype(np.float32) for name, value in refined.values.items()}
    points, normals = refined.points.astype(np.float32), corner_normals(refined)
    uvs, colors = values.get("uvs"), values.get("colors")
    return _Surface(
        points=points,
        counts=refined.counts,
        corners=refined.corners,
        faces=refined.faces,
        normals=normals,
        uvs=uvs,
        colors=colors,
    )


def _check_polygons(
    label: str, points: NDArray[np.float32], counts: NDArray[np.int64], corners: NDArray[np.int64]
) -> None:
    """Raise InputError if the polygons are inconsistent or a vertex is not finite."""
    if counts.size and (counts.min() < 0 or counts.sum() != len(corners)):
        raise InputError(
            f"{label}: the corner counts of its polygons do not match its corners. Export it again."
        )
    if corners.size and (corners.min() < 0 or corners.max() >= len(points)):
        raise InputError(
            f"{label}: a polygon refers to a vertex that does not exist. Export it again."
        )
    if not np.isfinite(points).all():
        raise InputError(
            f"{label}: a vertex has no finite place (NaN or infinity). Export it again."
        )


def _make_fans(counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the triangles (T, 3) as numbers of corners, and the face of each (T,)."""
    sizes = np.maximum(counts - 2, 0)
    faces = np.repeat(np.arange(len(counts)), sizes)
    firsts = (np.cumsum(counts) - counts)[faces]
    steps = np.arange(len(faces)) - (np.cumsum(sizes) - sizes)[faces]
    return np.stack([firsts, firsts + steps + 1, firsts + steps + 2], axis=1), faces


def _read_normals(
    label: str,
    mesh: UsdObject,
    points: NDArray[np.float32],
    corners: NDArray[np.int64],
    triangles: NDArray[np.int64],
) -> NDArray[np.float32] | None:
    """Return the normals (corners, 3) of the file, or smooth ones for a subdivision scheme.

    Returns None if the file has neither; the surface is then shaded flat.
    """
    primvar = usd_module("UsdGeom").PrimvarsAPI(mesh.GetPrim()).GetPrimvar("normals")
    stored = primvar.ComputeFlattened() if primvar else mesh.GetNormalsAttr().Get()
    values = float_array(stored, 3, f"{label}: normals")
    if len(values) == len(corners) and len(values):
        return values
    if len(values) == len(points) and len(values):
        return np.asarray(values[corners])
    if mesh.GetSubdivisionSchemeAttr().Get() == "none" or not len(triangles):
        return None
    return np.asarray(smooth_normals(points, corners[triangles].astype(np.uint32))[corners])


def _read_uvs(label: str, prim: object, corners: NDArray[np.int64]) -> NDArray[np.float32] | None:
    """Return the texture coordinates (corners, 2) with v downwards; None if there are none."""
    primvars = usd_module("UsdGeom").PrimvarsAPI(prim)
    for name in _UV_NAMES:
        stored = primvars.GetPrimvar(name).ComputeFlattened() if primvars.HasPrimvar(name) else None
        values = float_array(stored, 2, f"{label}: {name}")
        if not len(values):
            continue
        values[:, 1] = 1 - values[:, 1]
        if len(values) == len(corners):
            return np.asarray(values)
        if corners.size and len(values) > corners.max():
            return np.asarray(values[corners])
    return None


def _read_colors(
    label: str, prim: object, points: int, counts: NDArray[np.int64], corners: NDArray[np.int64]
) -> NDArray[np.float32] | None:
    """Return the linear colors (corners, 3) of displayColor; None for a constant color.

    The material has a constant color.
    """
    primvar = usd_module("UsdGeom").PrimvarsAPI(prim).GetPrimvar("displayColor")
    stored = primvar.ComputeFlattened() if primvar else None
    values = float_array(stored, 3, f"{label}: displayColor")
    kind = primvar.GetInterpolation() if len(values) > 1 else "constant"
    if kind == "uniform" and len(values) == len(counts):
        return np.repeat(values, counts, axis=0)
    if kind in ("vertex", "varying") and len(values) == points:
        return np.asarray(values[corners])
    return values if kind == "faceVarying" and len(values) == len(corners) else None


def _split_by_material(
    label: str, prim: object, faces: NDArray[np.int64], count: int
) -> list[tuple[object, NDArray[np.bool_]]]:
    """Return the prim of each part with its own material, and a mask of its triangles."""
    binding = usd_module("UsdShade").MaterialBindingAPI(prim)
    is_unassigned = np.ones(count, bool)
    groups = []
    for subset in binding.GetMaterialBindSubsets():
        subset_faces = integer_array(subset.GetIndicesAttr().Get(), f"{label}: indices of a subset")
        is_in_subset = np.zeros(count, bool)
        is_in_subset[subset_faces[(subset_faces >= 0) & (subset_faces < count)]] = True
        groups.append((subset.GetPrim(), (is_in_subset & is_unassigned)[faces]))
        is_unassigned &= ~is_in_subset
    return [*groups, (prim, is_unassigned[faces])]
