"""Read triangles, lines and points of a glTF file: one mesh of the scene for each primitive.

Source: Khronos, glTF 2.0 specification, section 3.7.

A mesh is deformed by the bones and morph targets of its node.

A scene consists of triangles only: points and lines become thin solids. All points and pieces of
lines of a file together become at most four times POINTS_MOST triangles.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.gltf.animation import Animation
from heatlens.media.scene.gltf.deform import (
    DeformedMesh,
    Skin,
    read_binding,
    read_skin,
    read_targets,
)
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.material import GltfMaterials
from heatlens.media.scene.gltf.thin_solids import count_thin_corners, make_thin_solids
from heatlens.media.scene.gltf.vertices import Vertices
from heatlens.media.scene.material import MapPlace, Material
from heatlens.media.scene.mesh_make import add_tangents, make_mesh, normalize_tangents
from heatlens.media.scene.point_cloud import POINTS_MOST
from heatlens.media.scene.scene import Array, Deform, Mesh

_BONELESS_NOTE = "Skinned meshes on nodes without a skeleton keep their modelled shape"
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_THIN_NOTE = "Points and lines are drawn thin"
_LEFT_OUT_WORDS = ", and some are left out because there are very many"
_UNTEXTURED_NOTE = "Surfaces without texture coordinates for their pictures have a single colour"
_NORMAL_MAP = 3  # index of the normal map among the maps of a material


@dataclass(eq=False)
class ShapeChange:
    """The bones and morph weights that deform the primitives of one mesh on a node.

    skin          index of the skin, None for none
    weights_node  the node whose morph weights are used, None for those of the mesh
    """

    gltf: GltfFile
    animation: Animation
    skin: int | None
    weights_node: int | None
    mesh: Record

    def deformed_mesh(self, vertices: Vertices, mesh: Mesh, is_thin: bool) -> DeformedMesh | None:
        """Return the deformed mesh; None if neither bones nor morph targets change it.

        `is_thin` is true for points and lines, whose meshes are thin solids.
        """
        binding = None if self.bones is None else read_binding(vertices, mesh, self.bones)
        if self.bones is None and vertices.has("JOINTS_0"):
            self.gltf.note_loss(_BONELESS_NOTE, vertices.primitive)
        count = len(self.weights(self.animation.first_frame))
        targets = read_targets(vertices, mesh, self.weights, count) if count else None
        if binding is None and targets is None:
            return None
        # Thin solids have flat sides, and glTF shades a mesh without normals flat too.
        is_faceted = is_thin or not vertices.has("NORMAL")
        return DeformedMesh(mesh, targets, binding, is_faceted)

    @cached_property
    def bones(self) -> Skin | None:
        """The skin of the mesh, if any."""
        return None if self.skin is None else read_skin(self.gltf, self.animation, self.skin)

    @property
    def is_moving(self) -> bool:
        """Whether the shape differs from frame to frame."""
        is_blending = self.weights_node is not None and self.weights_node in self.animation.weights
        return is_blending or (self.bones is not None and self.bones.is_moving)

    def weights(self, frame: float) -> Array:
        """Return the morph weights at a frame; none if the file has none."""
        if self.weights_node is not None and self.weights_node in self.animation.weights:
            return self.animation.weights_of(self.weights_node, frame)
        return self._constant_weights

    @cached_property
    def _constant_weights(self) -> Array:
        """The morph weights that are not animated: those of the node, or else of the mesh."""
        node = None if self.weights_node is None else self.animation.tree.records[self.weights_node]
        weights_record = node if node is not None and node.has("weights") else self.mesh
        return np.array(weights_record.numbers("weights"))


@dataclass
class GltfMeshes:
    """Reads each mesh of a file once, when a node first uses it.

    A skinned mesh, or one with morph weights of its own on a node, is read for that node.

    deforms   the meshes of the scene that change their shape
    in_world  skinned meshes, whose bones place them in the world regardless of their node
    """

    gltf: GltfFile
    materials: GltfMaterials
    animation: Animation
    meshes: list[Mesh] = field(default_factory=list)
    deforms: dict[int, Deform] = field(default_factory=dict)
    in_world: set[int] = field(default_factory=set)
    _numbers_by_key: dict[object, list[int]] = field(default_factory=dict)

    def meshes_of(self, index: int, node: int) -> list[int]:
        """Return the scene's meshes for a mesh of the file on a node.

        Raises InputError if it is damaged.
        """
        record = self.gltf.top_level("meshes")[index]
        node_record = self.animation.tree.records[node]
        skin = self.gltf.index(node_record, "skin", "skins")
        weights_node = (
            node if node_record.has("weights") or node in self.animation.weights else None
        )
        key = index, skin, weights_node
        if key not in self._numbers_by_key:
            change = ShapeChange(self.gltf, self.animation, skin, weights_node, record)
            self._numbers_by_key[key] = [
                number
                for primitive in record.records("primitives")
                if (number := self._add_primitive(primitive, change)) is not None
            ]
        return self._numbers_by_key[key]

    def _add_primitive(self, primitive: Record, change: ShapeChange) -> int | None:
        """Read a primitive as a mesh and return its number; None if it has no triangles."""
        mode = primitive.whole_number("mode", _TRIANGLES)
        if mode > _FAN:
            primitive.refuse(f"{mode} is not a primitive mode of glTF")
        material = self.gltf.index(primitive, "material", "materials")
        number = len(self.gltf.top_level("materials")) if material is None else material
        vertices = Vertices(self.gltf, primitive)
        make = self._make_solid if mode >= _TRIANGLES else self._make_thin
        mesh = make(vertices, mode, number)
        if not len(mesh.triangles):
            return None
        return self._store(
            change.deformed_mesh(vertices, mesh, is_thin=mode < _TRIANGLES), mesh, change.is_moving
        )

    def _store(self, deformed: DeformedMesh | None, mesh: Mesh, is_moving: bool) -> int:
        """Store a mesh in its shape at the first frame, and its deformation; return its number."""
        number = len(self.meshes)
        self.meshes.append(mesh if deformed is None else deformed(self.animation.first_frame))
        if deformed is not None and deformed.binding is not None:
            self.in_world.add(number)
        if deformed is not None and is_moving:
            self.deforms[number] = deformed
        return number

    @cached_property
    def _thin_count(self) -> int:
        return count_thin_corners(self.gltf)

    def _make_solid(self, vertices: Vertices, mode: int, number: int) -> Mesh:
        """Return a mesh of the triangles of a primitive, with material `number`."""
        layout, material = self.materials.layouts[number], self.materials.materials[number]
        uvs = [vertices.floats(f"TEXCOORD_{n}", 2) for n in layout.sets]
        lacks_uvs = any(uv_set is None for uv_set in uvs)
        self._note_unused_maps(vertices, material, lacks_uvs)
        if uvs[0] is not None and material.map_places is None:
            uvs[0] = layout.shared.transform(uvs[0])
        mesh = make_mesh(
            self._describe(vertices),
            vertices.positions,
            _list_triangles(vertices.corners(), _TRIANGLES if vertices.is_packed else mode),
            vertices.floats("NORMAL", 3),
            uvs[0],
            number,
            vertices.colors(),
        )
        if len(uvs) > 1 and uvs[1] is not None:
            mesh = replace(mesh, more_uvs=uvs[1] if mesh.sources is None else uvs[1][mesh.sources])
        return mesh if material.normal_map is None else self._with_tangents(vertices, mesh)

    def _make_thin(self, vertices: Vertices, mode: int, number: int) -> Mesh:
        """Return points or lines as thin solids, in the colors of their vertices."""
        are_some_left_out = self._thin_count > POINTS_MOST
        self.gltf.note_loss(_THIN_NOTE + _LEFT_OUT_WORDS * are_some_left_out, vertices.primitive)
        self._note_unused_maps(vertices, self.materials.materials[number], lacks_uvs=True)
        corners = vertices.corners()
        positions, triangles, sources = make_thin_solids(
            vertices.positions.astype(float), corners, mode, self._thin_count
        )
        colors = vertices.colors()
        tints = None if colors is None else colors[sources]
        label, floats = self._describe(vertices), positions.astype(np.float32)
        mesh = make_mesh(label, floats, triangles, None, None, number, tints)
        return replace(mesh, sources=None if mesh.sources is None else sources[mesh.sources])

    def _note_unused_maps(self, vertices: Vertices, material: Material, lacks_uvs: bool) -> None:
        """Add a note if a surface lacks texture coordinates but its material has pictures."""
        if lacks_uvs and any(number is not None for number in material.maps):
            self.gltf.note_loss(_UNTEXTURED_NOTE, vertices.primitive)

    def _describe(self, vertices: Vertices) -> str:
        """Return the file and the place of a primitive, with which error messages begin."""
        return f"{self.gltf.path}: {vertices.primitive.entry.place}"

    def _with_tangents(self, vertices: Vertices, mesh: Mesh) -> Mesh:
        """Return the mesh with the file's tangents if it has normals, else derived ones."""
        stored = vertices.floats("TANGENT", 4) if vertices.has("NORMAL") else None
        if stored is not None:
            return replace(mesh, tangents=normalize_tangents(stored))
        placements = self.materials.materials[mesh.material].map_places
        return (
            add_tangents(mesh)
            if placements is None
            else _add_tangents_along_map(mesh, placements[_NORMAL_MAP])
        )


def _add_tangents_along_map(mesh: Mesh, place: MapPlace) -> Mesh:
    """Return the mesh with tangents along the texture coordinates of its normal map.

    `place` is the placement of that map.
    """
    second_uvs = mesh.uvs if mesh.more_uvs is None else mesh.more_uvs
    # `coordinates` is 0 for the first set of texture coordinates, and 1 for the second.
    uvs = place.transform(second_uvs if place.coordinates else mesh.uvs)
    # Tangents may split vertices: `sources` then tells from which vertex each one came, so that
    # the original texture coordinates can be restored.
    numbers = np.arange(len(uvs), dtype=np.uint32)
    with_map_tangents = add_tangents(replace(mesh, uvs=uvs, sources=numbers))
    assert with_map_tangents.sources is not None
    sources = with_map_tangents.sources
    return replace(
        with_map_tangents,
        uvs=mesh.uvs[sources],
        sources=sources if mesh.sources is None else mesh.sources[sources],
    )


def _list_triangles(corners: NDArray[np.uint32], mode: int) -> NDArray[np.uint32]:
    """Return the triangles (T, 3) of a list, strip or fan, without incomplete ones."""
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
