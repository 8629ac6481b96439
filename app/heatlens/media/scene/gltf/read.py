"""Read glTF 2.0 files, .glb and .gltf, as scenes.

glTF has the units, axes and colours of `Scene`. Lights are scaled to a suitable exposure.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.files.apart import called_apart
from heatlens.media.files.limits import allow_for
from heatlens.media.scene.gltf.animation import Animation, read_animation
from heatlens.media.scene.gltf.cameras import GltfCameras
from heatlens.media.scene.gltf.compressed import OwnProcessNeededError
from heatlens.media.scene.gltf.file import GltfFile, named_files, open_gltf
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.lights import GltfLights
from heatlens.media.scene.gltf.material import GltfMaterials
from heatlens.media.scene.gltf.mesh import GltfMeshes
from heatlens.media.scene.gltf.nodes import RESTS, matrices, read_tree
from heatlens.media.scene.gltf.vertices import read_floats
from heatlens.media.scene.gltf.vocabulary import unread_notes
from heatlens.media.scene.scene import Array, Instance, Scene, check_instances

_FAR_MOST_M = 1e9
_SPREAD = "EXT_mesh_gpu_instancing"
_WORLD = -1  # index of the identity, which is appended to the matrices of the nodes


@dataclass(frozen=True, eq=False)
class _Hanging:
    """Meshes on nodes: the node of each instance, and its matrix (4, 4) to the node.

    A skinned mesh is in world space already: its node is `_WORLD`.
    """

    animation: Animation
    nodes: tuple[int, ...]
    offsets: Array

    def __call__(self, frame: float) -> Array:
        """Return the matrices (instances, 4, 4) to the world at a frame."""
        with np.errstate(over="ignore", invalid="ignore"):
            worlds = np.concatenate([self.animation.worlds(frame), np.eye(4)[None]])
            places = worlds[list(self.nodes)] @ self.offsets
        return np.clip(np.nan_to_num(places), -_FAR_MOST_M, _FAR_MOST_M)


def read_gltf(path: Path, timing: SceneTiming | None = None) -> Scene:
    """Read the default scene of a file; `timing` chooses the clip, frame rate and first frame.

    A compressed one is read in a separate process, because the libraries that unpack it may crash.
    Raises InputError that names the file and the place in it if it is damaged, refers to missing
    objects, or has nothing visible.
    """
    try:
        return gltf_scene((path, timing))
    except OwnProcessNeededError:
        return called_apart(_bounded_scene, (path, timing), str(path))


def _bounded_scene(chosen: tuple[Path, SceneTiming | None]) -> Scene:
    """Read a scene with the time that its files may take."""
    for name in (chosen[0], *named_files(chosen[0])):
        allow_for(name)
    return gltf_scene(chosen)


@np.errstate(over="ignore", invalid="ignore")  # places are checked once they are known
def gltf_scene(chosen: tuple[Path, SceneTiming | None]) -> Scene:
    """Read the scene of a file with this timing; raise OwnProcessNeededError if compressed."""
    path, timing = chosen
    gltf = open_gltf(path)
    animation = read_animation(gltf, read_tree(gltf), timing or SceneTiming())
    materials = GltfMaterials(gltf)
    meshes = GltfMeshes(gltf, materials, animation)
    cameras = GltfCameras(gltf, animation)
    lights = GltfLights(gltf, animation)
    instances, hanging = _instances(animation, meshes)
    boxes_m = _boxes_m(meshes, instances)
    lights.exposed(boxes_m.mean(axis=1))
    cameras.cut_off(boxes_m)
    moving = any(animation.moves(node) for node in set(hanging.nodes) if node != _WORLD)
    readers = (materials, cameras, lights)
    notes = [note for reader in readers for note in reader.notes] + list(unread_notes(gltf))
    return Scene(
        path,
        tuple(meshes.meshes),
        instances,
        tuple(materials.materials),
        tuple(materials.textures.images),
        tuple(cameras.cameras),
        tuple(lights.lights),
        lights.daylight,
        hanging if moving else None,
        animation.frames,
        animation.timing.frames_per_second,
        notes=tuple(f"{path}: {note}" for note in notes),
        deforms=meshes.deforms,
        clips=animation.clips,
        light_motion=lights.motion,
    )


def _boxes_m(meshes: GltfMeshes, instances: tuple[Instance, ...]) -> Array:
    """Return (N, 2, 3), the box around each instance in the world."""
    boxes = np.array([mesh.box_m for mesh in meshes.meshes])
    places = np.stack([instance.to_world for instance in instances])
    own = boxes[[instance.mesh for instance in instances]]
    middles = np.einsum("nij,nj->ni", places[:, :3, :3], own.mean(axis=1)) + places[:, :3, 3]
    halves = np.einsum("nij,nj->ni", np.abs(places[:, :3, :3]), np.ptp(own, axis=1) / 2)
    return np.stack([middles - halves, middles + halves], axis=1)


def _instances(animation: Animation, meshes: GltfMeshes) -> tuple[tuple[Instance, ...], _Hanging]:
    gltf, tree = meshes.gltf, animation.tree
    names: list[str] = []
    numbers, nodes, offsets = [], [], []
    for node in tree.seen:
        record = tree.records[node]
        index = gltf.index(record, "mesh", "meshes")
        if index is None or node in tree.hidden:
            continue
        name = record.text("name") or gltf.listed("meshes")[index].text("name") or f"node {node}"
        for number in meshes.of(index, node):
            in_world = number in meshes.in_world
            spread = np.eye(4)[None] if in_world else _spread(gltf, record)
            check_instances(gltf.path, len(names) + len(spread))
            names += [name] * len(spread)
            numbers += [number] * len(spread)
            nodes += [_WORLD if in_world else node] * len(spread)
            offsets.append(spread)
    if not nodes:
        raise InputError(f"{gltf.path}: there is nothing in this scene to look at.")
    hanging = _Hanging(animation, tuple(nodes), np.concatenate(offsets))
    worlds = np.concatenate([animation.worlds(animation.first_frame), np.eye(4)[None]])
    places = worlds[nodes] @ hanging.offsets
    _check_places(gltf, places)
    instances = map(Instance, names, numbers, places)
    return tuple(instances), hanging


def _check_places(gltf: GltfFile, places: Array) -> None:
    if not np.abs(places).max() <= _FAR_MOST_M:
        raise InputError(
            f"{gltf.path}: a mesh is farther away or larger than {_FAR_MOST_M:g} m, where nothing "
            "can be drawn."
        )


def _spread(gltf: GltfFile, record: Record) -> Array:
    """Return the matrices (K, 4, 4) of the copies of a node's mesh, a single one by default."""
    attributes = record.inside("extensions", _SPREAD, "attributes")
    lists = {
        name: read_floats(gltf, index, len(rest)).astype(float)
        for name, rest in RESTS.items()
        if (index := gltf.index(attributes, name.upper(), "accessors")) is not None
    }
    if not lists:
        return np.eye(4)[None]
    count = len(next(iter(lists.values())))
    if any(len(values) != count for values in lists.values()):
        attributes.refuse("its lists differ in length")
    full = (
        lists.get(name, np.tile(np.array(rest, float), (count, 1))) for name, rest in RESTS.items()
    )
    return matrices(*full)
