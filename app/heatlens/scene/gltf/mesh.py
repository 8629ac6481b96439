"""The triangles of a glTF file: one mesh of the scene for each primitive.

Source: Khronos, glTF 2.0 specification, section 3.7.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.scene.gltf.accessor import read_colors, read_floats, read_indices
from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.gltf.material import GltfMaterials
from heatlens.scene.mesh_make import made_mesh
from heatlens.scene.scene import Mesh
from heatlens.scene.tangents import told_tangents, with_tangents

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_NOT_READ = {
    "JOINTS_0": "Skins are not read: a figure stands as it was modelled.",
}
_MORPHS = "Shapes that change into others (morph targets) stay as they were modelled."


@dataclass
class GltfMeshes:
    """Reads each mesh of a file once, when a node first uses it."""

    gltf: GltfFile
    materials: GltfMaterials
    meshes: list[Mesh] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    _found: dict[int, list[int]] = field(default_factory=dict)

    def of(self, index: int) -> list[int]:
        """Return the scene's meshes for a mesh of the file, without its points and lines.

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
        if mode < _TRIANGLES:
            self.notes["Points and lines are not drawn; only triangles are."] = None
            return None
        self._note_what_is_not_read(primitive)
        mesh = self._mesh(primitive, mode)
        if not len(mesh.triangles):
            return None
        self.meshes.append(mesh)
        return len(self.meshes) - 1

    def _mesh(self, primitive: Record, mode: int) -> Mesh:
        materials = self.gltf.listed("materials")
        material = primitive.index("material", len(materials))
        number = len(materials) if material is None else material
        positions = self._attribute(primitive, "POSITION", 3)
        if positions is None:
            primitive.refuse("it has no POSITION, so its vertices have no place")
        place = self.materials.places[number]
        uvs = self._attribute(primitive, f"TEXCOORD_{place.coordinates}", 2, len(positions))
        mesh = made_mesh(
            f"{self.gltf.path}: {primitive.entry.place}",
            positions,
            _triangles(self._corners(primitive, len(positions)), mode),
            self._attribute(primitive, "NORMAL", 3, len(positions)),
            None if uvs is None else place.placed(uvs),
            number,
            self._attribute(primitive, "COLOR_0", None, len(positions)),
        )
        has_bumps = self.materials.materials[number].normal_map is not None
        return self._with_tangents(primitive, mesh) if has_bumps else mesh

    def _with_tangents(self, primitive: Record, mesh: Mesh) -> Mesh:
        """Return the mesh with the file's tangents if it has normals, else derived ones."""
        told = None
        if primitive.inside("attributes").has("NORMAL"):
            told = self._attribute(primitive, "TANGENT", 4, len(mesh.positions_m))
        return with_tangents(mesh) if told is None else replace(mesh, tangents=told_tangents(told))

    def _attribute(
        self, primitive: Record, name: str, width: int | None, count: int | None = None
    ) -> NDArray[np.float32] | None:
        """Return (V, width) of a vertex attribute; colours, without a width, have three or four."""
        attributes = primitive.inside("attributes")
        accessor = attributes.index(name, len(self.gltf.listed("accessors")))
        if accessor is None:
            return None
        gltf = self.gltf
        found = read_floats(gltf, accessor, width) if width else read_colors(gltf, accessor)
        if count is not None and len(found) != count:
            attributes.refuse(f"there are {count} positions, but {len(found)} of {name}")
        return found

    def _corners(self, primitive: Record, count: int) -> NDArray[np.uint32]:
        accessor = primitive.index("indices", len(self.gltf.listed("accessors")))
        if accessor is None:
            return np.arange(count, dtype=np.uint32)
        return read_indices(self.gltf, accessor, count)

    def _note_what_is_not_read(self, primitive: Record) -> None:
        attributes = primitive.inside("attributes")
        self.notes.update({note: None for name, note in _NOT_READ.items() if attributes.has(name)})
        if primitive.has("targets"):
            self.notes[_MORPHS] = None


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
