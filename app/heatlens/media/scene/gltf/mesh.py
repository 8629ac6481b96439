"""Read triangles, lines and points of a glTF file: one mesh of the scene for each primitive.

Source: Khronos, glTF 2.0 specification, section 3.7.

A mesh is changed by the bones and morph targets of the node that it hangs on.

A scene shows triangles alone: points and lines become thin solids. All points and pieces of lines
of a file together become at most four times POINTS_MOST triangles.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.gltf.animation import Animation
from heatlens.media.scene.gltf.deform import Deformed, Skin, read_binding, read_skin, read_targets
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.material import GltfMaterials
from heatlens.media.scene.gltf.vertices import Vertices
from heatlens.media.scene.mesh_make import made_mesh, unit_tangents, with_tangents
from heatlens.media.scene.point_cloud import POINTS_MOST, drawn_points
from heatlens.media.scene.primitives import tubes
from heatlens.media.scene.scene import Array, Deform, MapPlace, Material, Mesh

_BONELESS = "Skinned meshes on nodes without a skeleton keep their modelled shape"
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_THIN = "Points and lines are drawn thin"
_NOT_ALL = ", and some are left out because there are very many"
_FLAT = "Surfaces without texture coordinates for their pictures have a single colour"
_NORMALS = 3  # index of the normal map among the maps of a material
POINTS, LINES, LOOP, STRIP = range(4)  # modes of a primitive
_THINNESS = 1 / 600  # radius of a line or a point, as a part of the size of its mesh
_SIDES = 4

Solids = tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.uint32]]


@dataclass(eq=False)
class ShapeChange:
    """How the primitives of one mesh change their shape on a node.

    skin    index of the skin, None for none
    blends  the node whose morph weights are used, None for those of the mesh
    """

    gltf: GltfFile
    animation: Animation
    skin: int | None
    blends: int | None
    mesh: Record

    def of(self, vertices: Vertices, mesh: Mesh, is_thin: bool) -> Deformed | None:
        """Return the deformed mesh; None if neither bones nor morph targets change it."""
        binding = None if self.bones is None else read_binding(vertices, mesh, self.bones)
        if self.bones is None and vertices.has("JOINTS_0"):
            self.gltf.lose(_BONELESS, vertices.primitive)
        count = len(self.weights(self.animation.first_frame))
        targets = read_targets(vertices, mesh, self.weights, count) if count else None
        if binding is None and targets is None:
            return None
        return Deformed(mesh, targets, binding, is_thin or not vertices.has("NORMAL"))

    @cached_property
    def bones(self) -> Skin | None:
        """The skin of the mesh, if any."""
        return None if self.skin is None else read_skin(self.gltf, self.animation, self.skin)

    @property
    def moves(self) -> bool:
        """Return whether the shape differs from frame to frame."""
        is_blending = self.blends is not None and self.blends in self.animation.weights
        return is_blending or (self.bones is not None and self.bones.moves)

    def weights(self, frame: float) -> Array:
        """Return the morph weights at a frame; none if the file has none."""
        if self.blends is not None and self.blends in self.animation.weights:
            return self.animation.weights_of(self.blends, frame)
        return self._still_weights

    @cached_property
    def _still_weights(self) -> Array:
        node = None if self.blends is None else self.animation.tree.records[self.blends]
        holder = node if node is not None and node.has("weights") else self.mesh
        return np.array(holder.numbers("weights"))


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
    _found: dict[object, list[int]] = field(default_factory=dict)

    def of(self, index: int, node: int) -> list[int]:
        """Return the scene's meshes for a mesh of the file on a node.

        Raises InputError if it is damaged.
        """
        record, on_it = self.gltf.listed("meshes")[index], self.animation.tree.records[node]
        skin = self.gltf.index(on_it, "skin", "skins")
        blends = node if on_it.has("weights") or node in self.animation.weights else None
        key = index, skin, blends
        if key not in self._found:
            change = ShapeChange(self.gltf, self.animation, skin, blends, record)
            self._found[key] = [
                number
                for primitive in record.records("primitives")
                if (number := self._add(primitive, change)) is not None
            ]
        return self._found[key]

    def _add(self, primitive: Record, change: ShapeChange) -> int | None:
        mode = primitive.whole("mode", _TRIANGLES)
        if mode > _FAN:
            primitive.refuse(f"{mode} is not a primitive mode of glTF")
        material = self.gltf.index(primitive, "material", "materials")
        number = len(self.gltf.listed("materials")) if material is None else material
        vertices = Vertices(self.gltf, primitive)
        made = self._solid if mode >= _TRIANGLES else self._thin
        mesh = made(vertices, mode, number)
        if not len(mesh.triangles):
            return None
        return self._kept(change.of(vertices, mesh, is_thin=mode < _TRIANGLES), mesh, change.moves)

    def _kept(self, deformed: Deformed | None, mesh: Mesh, moves: bool) -> int:
        """Keep a mesh in its shape at the first frame, and its deformation; return its index."""
        place = len(self.meshes)
        self.meshes.append(mesh if deformed is None else deformed(self.animation.first_frame))
        if deformed is not None and deformed.binding is not None:
            self.in_world.add(place)
        if deformed is not None and moves:
            self.deforms[place] = deformed
        return place

    @cached_property
    def _thin_count(self) -> int:
        return thin_count(self.gltf)

    def _solid(self, vertices: Vertices, mode: int, number: int) -> Mesh:
        layout, material = self.materials.layouts[number], self.materials.materials[number]
        uvs = [vertices.floats(f"TEXCOORD_{n}", 2) for n in layout.sets]
        self._check_maps(vertices, material, any(part is None for part in uvs))
        if uvs[0] is not None and material.map_places is None:
            uvs[0] = layout.shared.placed(uvs[0])
        mesh = made_mesh(
            self._what(vertices),
            vertices.positions,
            _triangles(vertices.corners(), _TRIANGLES if vertices.is_packed else mode),
            vertices.floats("NORMAL", 3),
            uvs[0],
            number,
            vertices.colors(),
        )
        if len(uvs) > 1 and uvs[1] is not None:
            mesh = replace(mesh, more_uvs=uvs[1] if mesh.sources is None else uvs[1][mesh.sources])
        return mesh if material.normal_map is None else self._with_tangents(vertices, mesh)

    def _thin(self, vertices: Vertices, mode: int, number: int) -> Mesh:
        """Return points or lines as thin solids, in the colours of their vertices."""
        are_some_left_out = self._thin_count > POINTS_MOST
        self.gltf.lose(_THIN + _NOT_ALL * are_some_left_out, vertices.primitive)
        self._check_maps(vertices, self.materials.materials[number], True)
        corners = vertices.corners()
        positions, triangles, sources = thin_solids(
            vertices.positions.astype(float), corners, mode, self._thin_count
        )
        colors = vertices.colors()
        tints = None if colors is None else colors[sources]
        what, floats = self._what(vertices), positions.astype(np.float32)
        mesh = made_mesh(what, floats, triangles, None, None, number, tints)
        return replace(mesh, sources=None if mesh.sources is None else sources[mesh.sources])

    def _check_maps(self, vertices: Vertices, material: Material, is_without: bool) -> None:
        """Note a surface without texture coordinates whose material has pictures."""
        if is_without and any(number is not None for number in material.maps):
            self.gltf.lose(_FLAT, vertices.primitive)

    def _what(self, vertices: Vertices) -> str:
        return f"{self.gltf.path}: {vertices.primitive.entry.place}"

    def _with_tangents(self, vertices: Vertices, mesh: Mesh) -> Mesh:
        """Return the mesh with the file's tangents if it has normals, else derived ones."""
        stored = vertices.floats("TANGENT", 4) if vertices.has("NORMAL") else None
        if stored is not None:
            return replace(mesh, tangents=unit_tangents(stored))
        places = self.materials.materials[mesh.material].map_places
        return with_tangents(mesh) if places is None else _along_map(mesh, places[_NORMALS])


def _along_map(mesh: Mesh, place: MapPlace) -> Mesh:
    """Return the mesh with tangents along the texture coordinates of its normal map."""
    second = mesh.uvs if mesh.more_uvs is None else mesh.more_uvs
    uvs = place.placed(second if place.coordinates else mesh.uvs)
    numbers = np.arange(len(uvs), dtype=np.uint32)
    turned = with_tangents(replace(mesh, uvs=uvs, sources=numbers))
    assert turned.sources is not None
    kept = turned.sources
    return replace(
        turned, uvs=mesh.uvs[kept], sources=kept if mesh.sources is None else mesh.sources[kept]
    )


def _triangles(corners: NDArray[np.uint32], mode: int) -> NDArray[np.uint32]:
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


def thin_count(gltf: GltfFile) -> int:
    """Return how many points and ends of lines all meshes of the file have."""
    return sum(
        _corner_count(gltf, primitive)
        for mesh in gltf.listed("meshes")
        for primitive in mesh.records("primitives")
        if primitive.whole("mode", STRIP + 1) <= STRIP
    )


def _corner_count(gltf: GltfFile, primitive: Record) -> int:
    index = gltf.index(primitive, "indices", "accessors")
    if index is None:
        index = gltf.index(primitive.inside("attributes"), "POSITION", "accessors")
    return 0 if index is None else gltf.listed("accessors")[index].whole("count", 0)


# A share for each primitive, because all points and lines of a file have the same two million
# triangles that a scan of points has: a file of 1.9 MB became 6.3 million triangles, now 1.7, and
# is read in a third of the time. Lines become crossed bands where tubes would be too many.
def thin_solids(
    places: NDArray[np.float64], corners: NDArray[np.uint32], mode: int, of_all: int
) -> Solids:
    """Return positions (V, 3), triangles (T, 3) and the vertex of the file of each position (V,).

    `of_all` is the number of points and ends of lines that share the triangles.
    """
    if not len(corners):
        return np.zeros((0, 3)), np.zeros((0, 3), np.uint32), np.zeros(0, np.uint32)
    radius_m = max(_THINNESS * float(np.linalg.norm(np.ptp(places, axis=0))), 1e-6)
    most = int(POINTS_MOST * len(corners) / max(of_all, len(corners)))
    if mode == POINTS:
        drawn = drawn_points(places[corners], np.full(len(corners), radius_m), None, most)
        return drawn.positions, drawn.triangles, corners[drawn.point]
    corners, counts = _curves(_thinned(corners, mode, most), mode)
    pieces = len(corners) - len(counts)
    radii = np.full(len(corners), radius_m)
    is_crossed = 2 * pieces > most
    positions, _, triangles, point = tubes(places[corners], radii, counts, _SIDES, is_crossed)
    return positions, triangles, corners[point]


def _thinned(corners: NDArray[np.uint32], mode: int, most: int) -> NDArray[np.uint32]:
    """Return at most about `most` corners: every second line, or points of a curve, and so on."""
    step = -(-len(corners) // max(most, 1))
    if mode == LINES:
        return corners[: len(corners) // 2 * 2].reshape(-1, 2)[::step].reshape(-1)
    is_last_left_out = (len(corners) - 1) % step > 0
    return np.append(corners[::step], corners[-1:]) if is_last_left_out else corners[::step]


def _curves(corners: NDArray[np.uint32], mode: int) -> tuple[NDArray[np.uint32], NDArray[np.int64]]:
    """Return the points of all lines in order, and the number of points of each line."""
    if mode == LINES:
        return corners, np.full(len(corners) // 2, 2)
    if mode == LOOP and len(corners) > 2:
        corners = np.append(corners, corners[0])
    return corners, np.array([len(corners)])
