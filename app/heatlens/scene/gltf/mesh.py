"""The triangles, lines and points of a glTF file: one mesh of the scene for each primitive.

Source: Khronos, glTF 2.0 specification, section 3.7.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.scene.gltf.accessor import read_colors, read_floats, read_indices, read_numbers
from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.gltf.material import GltfMaterials
from heatlens.scene.mesh_make import made_mesh
from heatlens.scene.scene import MapPlace, Mesh
from heatlens.scene.tangents import told_tangents, with_tangents
from heatlens.scene.thin_shapes import (
    line_ends,
    lines_as_triangles,
    points_as_triangles,
    radius_of,
)

_POINTS, _LINES, _LOOP, _TRIANGLES, _STRIP, _FAN = 0, 1, 2, 4, 5, 6
_NAN = "Some normals, colours or texture coordinates are not numbers; others take their place."
_THIN = "Points and lines are drawn thin."
_NORMALS = 3  # the place of the map of normals among the maps of a material


@dataclass
class GltfMeshes:
    """Reads each mesh of a file once, when a node first uses it."""

    gltf: GltfFile
    materials: GltfMaterials
    meshes: list[Mesh] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    _found: dict[int, list[int]] = field(default_factory=dict)

    def of(self, index: int) -> list[int]:
        """Return the scene's meshes for a mesh of the file.

        Raises InputError where it is damaged.
        """
        if index not in self._found:
            record = self.gltf.listed("meshes")[index]
            self._found[index] = [
                number
                for primitive in record.records("primitives")
                if (number := self._add(primitive)) is not None
            ]
        return self._found[index]

    def _add(self, primitive: Record) -> int | None:
        mode = primitive.whole("mode", _TRIANGLES)
        if mode > _FAN:
            primitive.refuse(f"{mode} is not a primitive mode of glTF")
        material = primitive.index("material", len(self.gltf.listed("materials")))
        number = len(self.gltf.listed("materials")) if material is None else material
        positions = self._floats(primitive, "POSITION", 3)
        if positions is None:
            primitive.refuse("it has no POSITION, so its vertices have no place")
        corners = self._corners(primitive, len(positions))
        if mode < _TRIANGLES:
            self.notes[_THIN] = None
            mesh = self._thin(primitive, positions, corners, number)
        else:
            mesh = self._solid(primitive, positions, _triangles(corners, mode), number)
        if not len(mesh.triangles):
            return None
        self.meshes.append(mesh)
        return len(self.meshes) - 1

    def _solid(
        self,
        primitive: Record,
        positions: NDArray[np.float32],
        triangles: NDArray[np.uint32],
        number: int,
    ) -> Mesh:
        count, layout = len(positions), self.materials.layouts[number]
        material = self.materials.materials[number]
        uvs = [self._floats(primitive, f"TEXCOORD_{n}", 2, count) for n in layout.sets]
        if uvs[0] is not None and material.map_places is None:
            uvs[0] = layout.shared.placed(uvs[0])
        mesh = made_mesh(
            f"{self.gltf.path}: {primitive.entry.place}",
            positions,
            triangles,
            self._floats(primitive, "NORMAL", 3, count),
            uvs[0],
            number,
            self._colors(primitive, count),
        )
        if len(uvs) > 1 and uvs[1] is not None:
            mesh = replace(mesh, more_uvs=uvs[1] if mesh.sources is None else uvs[1][mesh.sources])
        return mesh if material.normal_map is None else self._with_tangents(primitive, mesh)

    def _thin(
        self,
        primitive: Record,
        positions: NDArray[np.float32],
        corners: NDArray[np.uint32],
        number: int,
    ) -> Mesh:
        """Return points or lines as thin solids, in the colours of their vertices."""
        mode, radius_m = primitive.whole("mode", _TRIANGLES), radius_of(positions)
        if mode == _POINTS:
            solid = points_as_triangles(positions, corners, radius_m)
        else:
            ends = line_ends(corners, mode != _LINES, mode == _LOOP)
            solid = lines_as_triangles(positions, ends, radius_m)
        colors = self._colors(primitive, len(positions))
        found, triangles, sources = solid
        what = f"{self.gltf.path}: {primitive.entry.place}"
        tints = None if colors is None else colors[sources]
        mesh = made_mesh(what, found, triangles, None, None, number, tints)
        return replace(mesh, sources=None if mesh.sources is None else sources[mesh.sources])

    def _with_tangents(self, primitive: Record, mesh: Mesh) -> Mesh:
        """Return the mesh with the file's tangents if it has normals, else derived ones."""
        told = None
        if primitive.inside("attributes").has("NORMAL"):
            told = self._floats(primitive, "TANGENT", 4, len(mesh.positions_m))
        if told is not None:
            return replace(mesh, tangents=told_tangents(told))
        places = self.materials.materials[mesh.material].map_places
        return with_tangents(mesh) if places is None else _along_map(mesh, places[_NORMALS])

    def _floats(
        self, primitive: Record, name: str, width: int, count: int | None = None
    ) -> NDArray[np.float32] | None:
        """Return (V, width) of a vertex attribute; only positions have to be finite."""
        accessor = self._accessor(primitive, name)
        if accessor is None:
            return None
        read = read_floats if name == "POSITION" else read_numbers
        found = self._checked(primitive, name, read(self.gltf, accessor, width), count)
        return np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)

    def _colors(self, primitive: Record, count: int) -> NDArray[np.float32] | None:
        """Return (V, 3) or (V, 4) of the first set of colours."""
        accessor = self._accessor(primitive, "COLOR_0")
        if accessor is None:
            return None
        return self._checked(primitive, "COLOR_0", read_colors(self.gltf, accessor), count)

    def _accessor(self, primitive: Record, name: str) -> int | None:
        attributes = primitive.inside("attributes")
        return attributes.index(name, len(self.gltf.listed("accessors")))

    def _checked(
        self, primitive: Record, name: str, found: NDArray[np.float32], count: int | None
    ) -> NDArray[np.float32]:
        """Note what is not a number; raise InputError where there are not `count` of them."""
        if count is not None and len(found) != count:
            primitive.inside("attributes").refuse(
                f"there are {count} positions, but {len(found)} of {name}"
            )
        if not np.isfinite(found).all():
            self.notes[_NAN] = None
        return found

    def _corners(self, primitive: Record, count: int) -> NDArray[np.uint32]:
        accessor = primitive.index("indices", len(self.gltf.listed("accessors")))
        if accessor is None:
            return np.arange(count, dtype=np.uint32)
        return read_indices(self.gltf, accessor, count)


def _along_map(mesh: Mesh, place: MapPlace) -> Mesh:
    """Return the mesh with tangents along the texture coordinates of its map of normals."""
    second = mesh.uvs if mesh.more_uvs is None else mesh.more_uvs
    uvs = place.placed(second if place.coordinates else mesh.uvs)
    numbers = np.arange(len(uvs), dtype=np.uint32)
    found = with_tangents(replace(mesh, uvs=uvs, sources=numbers))
    assert found.sources is not None
    kept = found.sources
    return replace(
        found, uvs=mesh.uvs[kept], sources=kept if mesh.sources is None else mesh.sources[kept]
    )


def _triangles(corners: NDArray[np.uint32], mode: int) -> NDArray[np.uint32]:
    """Return (T, 3) of a list of triangles, a strip or a fan, without incomplete triangles."""
    if mode == _TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if len(corners) < 3:
        return np.zeros((0, 3), np.uint32)
    if mode == _FAN:
        first = np.full(len(corners) - 2, corners[0])
        return np.stack([first, corners[1:-1], corners[2:]], axis=1)
    rows = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    rows[1::2] = rows[1::2][:, [1, 0, 2]]
    return rows
