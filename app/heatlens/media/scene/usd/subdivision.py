"""Subdivide the surfaces of a USD stage."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.media.files.usd_library import UsdObject, float_array, integer_array, usd_module
from heatlens.media.scene.subdivision import Polygons, subdivide

_LEVELS = 2  # the default of Blender and most renderers
_QUADS_OF_MESH_MOST, _QUADS_MOST = (
    400_000,
    1_000_000,
)  # quads of one mesh, and of all meshes together
_SHARPNESS_MOST = 10.0  # USD's value for an infinitely sharp crease


@dataclass
class Subdivision:
    """Subdivides meshes up to a limit on the number of quads.

    quads_left       quads that further meshes may have
    too_large        number of meshes drawn as their cages, which would have too many quads
    subdivided_once  number of meshes that were subdivided once instead of twice
    loop_scheme      number of meshes with Loop's scheme for triangles, drawn as their cages
    """

    quads_left: int = _QUADS_MOST
    too_large: int = 0
    subdivided_once: int = 0
    loop_scheme: int = 0

    def subdivide_cage(self, label: str, mesh: object, cage: Polygons) -> Polygons | None:
        """Return the subdivision surface of `cage`; None if the cage itself is drawn.

        Raises InputError if its creases are not numbers.
        """
        if not self._is_subdivided(mesh):
            return None
        levels = self._choose_levels(len(cage.corners))
        if not levels or not len(cage.corners):
            return None
        refined = _add_creases(label, mesh, cage)
        for _ in range(levels):
            refined = subdivide(refined)
        self.quads_left -= len(refined.counts)
        return refined

    def _is_subdivided(self, mesh: UsdObject) -> bool:
        """Return True for a mesh with the Catmull-Clark scheme; count those with Loop's scheme."""
        attribute = mesh.GetSubdivisionSchemeAttr()
        scheme = attribute.Get()
        self.loop_scheme += scheme == "loop"
        # If the file names no scheme, polygons with normals are not subdivided.
        normals = mesh.GetPrim().GetAttribute("primvars:normals"), mesh.GetNormalsAttr()
        has_normals = any(attr and attr.HasAuthoredValue() for attr in normals)
        is_scheme_chosen = attribute.HasAuthoredValue() or not has_normals
        return scheme == "catmullClark" and is_scheme_chosen

    def _choose_levels(self, corner_count: int) -> int:
        """Return how often a mesh is subdivided, 0 to _LEVELS; each level quadruples its quads.

        A cage with n corners has n quads after the first level.
        """
        quads_most = min(self.quads_left, _QUADS_OF_MESH_MOST)
        for levels in range(_LEVELS, 0, -1):
            if corner_count * 4 ** (levels - 1) <= quads_most:
                self.subdivided_once += levels < _LEVELS
                return levels
        self.too_large += 1
        return 0

    @property
    def notes(self) -> list[str]:
        """Sentences on the meshes that were not subdivided as intended."""
        counts_and_words = (
            (self.subdivided_once, "subdivided once instead of twice: they have many faces."),
            (self.too_large, "drawn as their cages, because they would have too many faces."),
            (self.loop_scheme, "drawn as their cages: the scheme 'loop' is not supported."),
        )
        return [
            f"{count} subdivision surfaces are {words}"
            for count, words in counts_and_words
            if count
        ]


def _add_creases(label: str, mesh: UsdObject, cage: Polygons) -> Polygons:
    """Return the cage with the valid creases and sharp corners of the file."""
    first_time = usd_module("Usd").TimeCode.EarliestTime()
    indices = integer_array(mesh.GetCreaseIndicesAttr().Get(first_time), f"{label}: creaseIndices")
    lengths = integer_array(mesh.GetCreaseLengthsAttr().Get(first_time), f"{label}: creaseLengths")
    stored = mesh.GetCreaseSharpnessesAttr().Get(first_time)
    sharpness = float_array(stored, 1, f"{label}: creaseSharpnesses")[:, 0]
    edges, chain_of_edge = _chain_edges(indices, lengths)
    if len(sharpness) not in (len(lengths), len(edges)):
        edges, chain_of_edge = edges[:0], chain_of_edge[:0]
    values = sharpness[chain_of_edge] if len(sharpness) == len(lengths) else sharpness[: len(edges)]
    is_inside = ((edges >= 0) & (edges < len(cage.points))).all(axis=1)
    points = integer_array(mesh.GetCornerIndicesAttr().Get(first_time), f"{label}: cornerIndices")
    stored = mesh.GetCornerSharpnessesAttr().Get(first_time)
    corner_sharpness = float_array(stored, 1, f"{label}: cornerSharpnesses")[:, 0]
    count = min(len(points), len(corner_sharpness))
    points, corner_sharpness = points[:count], corner_sharpness[:count]
    is_valid = (points >= 0) & (points < len(cage.points))
    return replace(
        cage,
        creases=edges[is_inside],
        crease_sharpness=_clip_sharpness(values[is_inside]),
        sharp_points=points[is_valid],
        point_sharpness=_clip_sharpness(corner_sharpness[is_valid]),
    )


def _chain_edges(
    indices: NDArray[np.int64], lengths: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the edges (E, 2) of chains of vertices, and the number of the chain of each, (E,).

    `indices` holds the vertices of all chains one after the other, `lengths` their numbers. Invalid
    lengths give no edges.
    """
    no_edges = np.zeros((0, 2), np.int64), np.zeros(0, np.int64)
    if not len(lengths) or lengths.min() < 0 or lengths.sum() != len(indices):
        return no_edges
    chain = np.repeat(np.arange(len(lengths)), lengths)
    is_in_chain = chain[:-1] == chain[1:]
    return np.stack([indices[:-1], indices[1:]], axis=1)[is_in_chain], chain[:-1][is_in_chain]


def _clip_sharpness(values: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return sharpness clipped to 0.._SHARPNESS_MOST; NaN becomes 0."""
    return np.clip(
        np.nan_to_num(values.astype(np.float64), nan=0.0, posinf=_SHARPNESS_MOST),
        0.0,
        _SHARPNESS_MOST,
    )
