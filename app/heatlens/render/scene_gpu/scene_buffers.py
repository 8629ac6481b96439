"""A scene in the memory of the GPU, laid out as lib/scene.lib.glsl reads it (std430).

The pictures that color its surfaces are layers of one texture.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from enum import Enum, auto
from functools import cached_property

import numpy as np
import numpy.typing as npt

from heatlens.media.scene.material import Material
from heatlens.media.scene.scene import Array, Mesh, Scene
from heatlens.media.scene.scene_bounds import transform_corners
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Buffer, Image
from heatlens.render.scene_gpu.closed_meshes import ClosedMeshes
from heatlens.render.scene_gpu.scene_records import (
    COMMAND_BYTES,
    INSTANCE,
    colors_of,
    draw_commands,
    join_meshes,
    maps_of,
    materials_of,
    more_uvs_of,
    placements_of,
    vertex_records,
)


# A program that looks for holes takes twice as long for each pixel on a processor, even where a
# surface has none, and one that reads maps half as long again. It takes both branches of an `if`.
class Instances(Enum):
    """Kinds of a scene's instances: without or with holes, without or with maps on them."""

    SOLID = auto()
    HOLED = auto()
    PLAIN = auto()
    MAPPED = auto()


Kinds = tuple[Instances, Instances]  # two kinds that are all instances together
BY_HOLES: Kinds = (Instances.SOLID, Instances.HOLED)
BY_MAPS: Kinds = (Instances.PLAIN, Instances.MAPPED)
_NEEDLESS = {  # features whose defines the programs of a kind leave out
    Instances.SOLID: {"HOLES", "MAPS"},
    Instances.HOLED: set[str](),
    Instances.PLAIN: {"HOLES", "MAPS"},
    Instances.MAPPED: {"HOLES"},
}


class SceneBuffers:
    """The buffers that the rasterizer and the ray tracer read.

    vertices        of all meshes, VERTEX, or BUMPY_VERTEX where a material has a normal map;
                    the ray tracer reads two or three vec4 for each
    colors          four half floats for each vertex, linear; None if no mesh has any
    more_uvs        two floats for each vertex, the second set of texture coordinates; None
                    if all maps of each material share one placement
    placements      placement of the maps of each material, None in the same case
    triangles       (T, 3) uint32 into all vertices
    first_triangle  (meshes + 1,) where each mesh's triangles begin
    instances       INSTANCE, those of one mesh after each other
    order           (N,) the scene's instance at each index of `instances`
    commands        for each of `Instances`, indexed indirect draws and their number
    maps            RGBA8 layers of one size, as the files keep them; one white texel for none
    boxes_m         (meshes, 2, 3) bounds of each mesh in its own axes
    """

    def __init__(self, ctx: Device, scene: Scene) -> None:
        self.scene = scene
        self.boxes_m = np.array([mesh.box_m for mesh in scene.meshes])
        mesh_of = np.array([instance.mesh for instance in scene.instances])
        self.order = np.argsort(mesh_of, kind="stable")
        self._meshes = mesh_of[self.order]
        self.has_bumps = any(material.normal_map is not None for material in scene.materials)
        vertices, triangles, self.first_triangle = join_meshes(scene, self.has_bumps)
        self._first_vertex = np.cumsum([0] + [len(mesh.positions_m) for mesh in scene.meshes])
        self.vertices = ctx.buffer(vertices.tobytes())
        self.colors = ctx.buffer(colors_of(scene.meshes)) if has_colors(scene) else None
        has_placements = any(material.map_places for material in scene.materials)
        self.more_uvs = ctx.buffer(more_uvs_of(scene.meshes)) if has_placements else None
        self.placements = ctx.buffer(placements_of(scene.materials)) if has_placements else None
        self.triangles = ctx.buffer(triangles.tobytes())
        self._members = members_of(scene, self._meshes)
        self._all_commands, self._some_commands = self._new_commands(ctx), self._new_commands(ctx)
        self.commands, self._some_drawn = self._all_commands, np.ones(len(self.order), bool)
        self.instances = ctx.buffer(reserve=len(self.order) * INSTANCE.itemsize)
        self._instance_records = np.zeros(len(self.order), INSTANCE)
        self.materials = materials_of(ctx, scene.materials)
        self.maps = maps_of(ctx, scene.images)

    @property
    def defines(self) -> dict[str, int]:
        """The defines of the scene's shaders: only the features that this scene needs."""
        has = {kind: bool(members.any()) for kind, members in self._members.items()}
        names = {"HOLES": has[Instances.HOLED], "MAPS": has[Instances.MAPPED]}
        names |= {"COLORS": self.colors is not None, "BUMPS": self.has_bumps}
        names |= {"PLACEMENTS": self.placements is not None}
        return {name: 1 for name, is_needed in names.items() if is_needed}

    def defines_of(self, kind: Instances) -> dict[str, int]:
        """Return those of `defines` that the instances of a kind need."""
        return {name: 1 for name in self.defines if name not in _NEEDLESS[kind]}

    @property
    def triangles_drawn(self) -> int:
        """The number of triangles of all instances together."""
        return int(np.diff(self.first_triangle)[self._meshes].sum())

    @property
    def storage(self) -> dict[str, Buffer]:
        """The blocks of lib/scene.lib.glsl."""
        blocks = {"instances_block": self.instances}
        return blocks if self.placements is None else blocks | {"placements_block": self.placements}

    @property
    def textures(self) -> dict[str, Image]:
        """The textures of lib/scene.lib.glsl."""
        return {"maps_tx": self.maps, "materials_tx": self.materials}

    @property
    def vertex_storage(self) -> dict[str, Buffer]:
        """The blocks of lib/bvh.lib.glsl for vertices, which only some scenes have."""
        blocks = {"colors_block": self.colors, "more_uvs_block": self.more_uvs}
        return {name: buffer for name, buffer in blocks.items() if buffer is not None}

    def place(self, transforms: Array) -> None:
        """Place the instances by (N, 4, 4) object-to-world matrices, in the order of the scene.

        The records are in the order of `self.order`. Their `numbers` are the material, the mesh,
        the index in the scene, and what `write_back_rules` adds.
        """
        matrices = transforms[self.order]
        records = np.zeros(len(matrices), INSTANCE)
        records["to_world"] = matrices.transpose(0, 2, 1)  # GLSL stores matrices by columns
        records["to_object"] = inverses(matrices).transpose(0, 2, 1)
        materials = np.array([mesh.material for mesh in self.scene.meshes])
        records["numbers"][:, 0] = materials[self._meshes]
        records["numbers"][:, 1] = self._meshes
        records["numbers"][:, 2] = self.order
        self._instance_records = records
        self.instances.write(records.tobytes())

    def reshape(self, shapes: Mapping[int, Mesh]) -> None:
        """Replace the shapes of meshes, by their index."""
        for mesh_index, mesh in shapes.items():
            records = vertex_records(mesh, self.has_bumps)
            start = int(self._first_vertex[mesh_index]) * records.itemsize
            self.vertices.write(records.tobytes(), offset=start)
            self.boxes_m[mesh_index] = mesh.box_m

    @contextmanager
    def draw_only(self, is_drawn: npt.NDArray[np.bool_]) -> Iterator[None]:
        """Draw only some instances within the block; `is_drawn` (N,) is in the scene's order."""
        if not np.array_equal(is_drawn, self._some_drawn):
            self._some_drawn = is_drawn
            self._some_commands = {
                kind: (buffer, self._write_commands(buffer, kind, is_drawn[self.order]))
                for kind, (buffer, _) in self._some_commands.items()
            }
        self.commands = self._some_commands
        try:
            yield
        finally:
            self.commands = self._all_commands

    def _new_commands(self, ctx: Device) -> dict[Instances, tuple[Buffer, int]]:
        """Return new commands that draw all instances of each kind."""
        size = len(self.order) * COMMAND_BYTES
        buffers = {kind: ctx.buffer(reserve=size) for kind in Instances}
        everything = np.ones(len(self.order), bool)
        return {
            kind: (buffer, self._write_commands(buffer, kind, everything))
            for kind, buffer in buffers.items()
        }

    def _write_commands(
        self, buffer: Buffer, kind: Instances, is_drawn: npt.NDArray[np.bool_]
    ) -> int:
        """Write the commands of the drawn instances of a kind; return how many there are."""
        is_drawn = is_drawn & self._members[kind]
        if not is_drawn.any():
            return 0
        commands = draw_commands(self._meshes, self.first_triangle, is_drawn)
        buffer.write(commands.tobytes())
        return len(commands)

    def write_back_rules(self, eye_m: Array) -> None:
        """Write how back faces are recognized from `eye_m`; call this after `place`."""
        records = self._instance_records
        rules = self._closed_meshes.rules(
            self._meshes, records["to_world"].transpose(0, 2, 1), records["to_object"], eye_m
        )
        if not np.array_equal(rules, records["numbers"][:, 3]):
            records["numbers"][:, 3] = rules
            self.instances.write(records.tobytes())

    @cached_property
    def _closed_meshes(self) -> ClosedMeshes:
        return ClosedMeshes(self.scene.meshes, self.boxes_m)

    def corners_m(self, transforms: Array) -> Array:
        """Return the corners (N, 8, 3) in the world of the instances' boxes.

        `transforms` (N, 4, 4) are their object-to-world matrices, in the order of the scene.
        """
        return transform_corners(self.boxes_m[[i.mesh for i in self.scene.instances]], transforms)

    def release(self) -> None:
        """Release everything on the GPU."""
        for buffer in (self.vertices, self.triangles):
            buffer.release()
        for buffer, _ in (*self._all_commands.values(), *self._some_commands.values()):
            buffer.release()
        for buffer in (self.storage | self.vertex_storage).values():
            buffer.release()
        for texture in (self.materials, self.maps):
            texture.release()


def inverses(matrices: Array) -> Array:
    """Return (N, 4, 4) inverses; an instance scaled to 0 has zeros, which no ray meets."""
    flat = np.abs(np.linalg.det(matrices)) < 1e-30
    inverse = np.linalg.inv(np.where(flat[:, None, None], np.eye(4), matrices))
    return np.where(flat[:, None, None], 0.0, inverse)


def members_of(
    scene: Scene, meshes: npt.NDArray[np.int64]
) -> dict[Instances, npt.NDArray[np.bool_]]:
    """Return (N,) which instances are of each kind; `meshes` (N,) is the mesh of each."""
    materials = [scene.materials[mesh.material] for mesh in scene.meshes]
    is_holed = np.array([m.alpha_cutoff > 0 or m.is_blended for m in materials], bool)[meshes]
    is_mapped = np.array([has_maps(material) for material in materials], bool)[meshes]
    return {
        Instances.SOLID: ~is_holed,
        Instances.HOLED: is_holed,
        Instances.PLAIN: ~is_mapped,
        Instances.MAPPED: is_mapped,
    }


def has_maps(material: Material) -> bool:
    """Return whether a material reads any of the scene's images."""
    color_maps = material.base_color_map, material.emission_map
    other_maps = material.metallic_roughness_map, material.normal_map, material.occlusion_map
    return any(number is not None for number in (*color_maps, *other_maps))


def has_colors(scene: Scene) -> bool:
    """Return whether any vertex has a color of its own."""
    return any(mesh.colors is not None for mesh in scene.meshes)
