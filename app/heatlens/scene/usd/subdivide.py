"""Decide which USD meshes are subdivided, how often, and where they stay sharp."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.files.usd_library import UsdObject, numbers, usd_module, whole_numbers
from heatlens.scene.subdivision import Polygons, subdivided

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
        found = _creased(what, mesh, cage)
        for _ in range(levels):
            found = subdivided(found)
        self.room -= len(found.counts)
        return found

    def _is_wanted(self, mesh: UsdObject) -> bool:
        attribute = mesh.GetSubdivisionSchemeAttr()
        scheme = attribute.Get()
        self.loops += scheme == "loop"
        # If the file names no scheme, polygons with normals are not subdivided.
        normals = mesh.GetPrim().GetAttribute("primvars:normals"), mesh.GetNormalsAttr()
        has_normals = any(told and told.HasAuthoredValue() for told in normals)
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
        told = (
            (self.once, "subdivided once instead of twice: they have many faces."),
            (self.left_out, "drawn as their cages, because they would have too many faces."),
            (self.loops, "drawn as their cages: the scheme 'loop' is not supported."),
        )
        return [f"{count} subdivision surfaces are {words}" for count, words in told if count]


def _creased(what: str, mesh: UsdObject, cage: Polygons) -> Polygons:
    """Return the cage with the valid creases and sharp corners of the file."""
    first = usd_module("Usd").TimeCode.EarliestTime()
    indices = whole_numbers(mesh.GetCreaseIndicesAttr().Get(first), f"{what}: creaseIndices")
    lengths = whole_numbers(mesh.GetCreaseLengthsAttr().Get(first), f"{what}: creaseLengths")
    told = mesh.GetCreaseSharpnessesAttr().Get(first)
    sharpness = numbers(told, 1, f"{what}: creaseSharpnesses")[:, 0]
    edges, of_chain = _chains(indices, lengths)
    if len(sharpness) not in (len(lengths), len(edges)):
        edges, of_chain = edges[:0], of_chain[:0]
    values = sharpness[of_chain] if len(sharpness) == len(lengths) else sharpness[: len(edges)]
    inside = ((edges >= 0) & (edges < len(cage.points))).all(axis=1)
    points = whole_numbers(mesh.GetCornerIndicesAttr().Get(first), f"{what}: cornerIndices")
    told = mesh.GetCornerSharpnessesAttr().Get(first)
    corners = numbers(told, 1, f"{what}: cornerSharpnesses")[:, 0]
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
