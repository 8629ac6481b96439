"""Read glTF 2.0 files, .glb and .gltf, as scenes.

glTF has the units, axes and colors of `Scene`. Lights are scaled to a suitable exposure.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.files.apart import call_in_process
from heatlens.media.files.limits import allow_for
from heatlens.media.scene.gltf.animation import Animation, read_animation
from heatlens.media.scene.gltf.cameras import GltfCameras
from heatlens.media.scene.gltf.compressed import OwnProcessNeededError
from heatlens.media.scene.gltf.file import GltfFile, named_files, open_gltf
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.lights import GltfLights
from heatlens.media.scene.gltf.material import GltfMaterials
from heatlens.media.scene.gltf.mesh import GltfMeshes
from heatlens.media.scene.gltf.nodes import DEFAULT_TRANSFORM, compose_matrices, read_tree
from heatlens.media.scene.gltf.vertices import read_floats
from heatlens.media.scene.gltf.vocabulary import unread_notes
from heatlens.media.scene.scene import Array, Instance, Scene, check_instances

_FAR_MOST_M = 1e9
_INSTANCING_EXTENSION = "EXT_mesh_gpu_instancing"
_WORLD = -1  # index of the identity, which is appended to the matrices of the nodes


@dataclass(frozen=True, eq=False)
class _NodeMotion:
    """The motion of instances.

    nodes    the node of each instance; `_WORLD` for a skinned mesh, which is in world space
    offsets  (instances, 4, 4) from each instance to its node
    """

    animation: Animation
    nodes: tuple[int, ...]
    offsets: Array

    def __call__(self, frame: float) -> Array:
        """Return the matrices (instances, 4, 4) to the world at a frame."""
        with np.errstate(over="ignore", invalid="ignore"):
            worlds = np.concatenate([self.animation.worlds(frame), np.eye(4)[None]])
            to_world = worlds[list(self.nodes)] @ self.offsets
        return np.clip(np.nan_to_num(to_world), -_FAR_MOST_M, _FAR_MOST_M)


def read_gltf(path: Path, timing: SceneTiming | None = None) -> Scene:
    """Read the default scene of a file; `timing` chooses the clip, frame rate and first frame.

    A compressed file is read in a separate process, because libraries that unpack it may crash.
    Raises InputError that names the file and the place in it if it is damaged, refers to missing
    objects, or has nothing visible.
    """
    try:
        return build_scene((path, timing))
    except OwnProcessNeededError:
        return call_in_process(_bounded_scene, (path, timing), str(path))


def _bounded_scene(request: tuple[Path, SceneTiming | None]) -> Scene:
    """Read a scene in the separate process, with a time limit that grows with its files.

    `request` holds the path and the timing.
    """
    for file in (request[0], *named_files(request[0])):
        allow_for(file)
    return build_scene(request)


@np.errstate(over="ignore", invalid="ignore")  # matrices are checked once they are computed
def build_scene(request: tuple[Path, SceneTiming | None]) -> Scene:
    """Read the scene of a file; `request` holds the path and the timing.

    Raises OwnProcessNeededError for a compressed file outside the separate process.
    """
    path, timing = request
    gltf = open_gltf(path)
    animation = read_animation(gltf, read_tree(gltf), timing or SceneTiming())
    materials = GltfMaterials(gltf)
    meshes = GltfMeshes(gltf, materials, animation)
    cameras = GltfCameras(gltf, animation)
    lights = GltfLights(gltf, animation)
    instances, node_motion = _read_instances(animation, meshes)
    boxes_m = _instance_boxes_m(meshes, instances)
    lights.scale_to_exposure(boxes_m.mean(axis=1))
    cameras.note_clipping(boxes_m)
    is_moving = any(animation.is_moving(node) for node in set(node_motion.nodes) if node != _WORLD)
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
        node_motion if is_moving else None,
        animation.frames,
        animation.timing.frames_per_second,
        notes=tuple(f"{path}: {note}" for note in notes),
        deforms=meshes.deforms,
        clips=animation.clips,
        light_motion=lights.motion,
    )


def _instance_boxes_m(meshes: GltfMeshes, instances: tuple[Instance, ...]) -> Array:
    """Return the boxes (N, 2, 3) around the instances in the world."""
    boxes = np.array([mesh.box_m for mesh in meshes.meshes])
    to_world = np.stack([instance.to_world for instance in instances])
    mesh_boxes = boxes[[instance.mesh for instance in instances]]
    centers = (
        np.einsum("nij,nj->ni", to_world[:, :3, :3], mesh_boxes.mean(axis=1)) + to_world[:, :3, 3]
    )
    half_sizes = np.einsum(
        "nij,nj->ni", np.abs(to_world[:, :3, :3]), np.ptp(mesh_boxes, axis=1) / 2
    )
    return np.stack([centers - half_sizes, centers + half_sizes], axis=1)


def _read_instances(
    animation: Animation, meshes: GltfMeshes
) -> tuple[tuple[Instance, ...], _NodeMotion]:
    """Return the instances of meshes on all visible nodes at the first frame, and their motion."""
    gltf, tree = meshes.gltf, animation.tree
    names: list[str] = []
    numbers, nodes, offsets = [], [], []
    for node in tree.scene_nodes:
        record = tree.records[node]
        index = gltf.index(record, "mesh", "meshes")
        if index is None or node in tree.hidden:
            continue
        name = record.text("name") or gltf.top_level("meshes")[index].text("name") or f"node {node}"
        for number in meshes.meshes_of(index, node):
            in_world = number in meshes.in_world
            copies = np.eye(4)[None] if in_world else _copy_matrices(gltf, record)
            check_instances(gltf.path, len(names) + len(copies))
            names += [name] * len(copies)
            numbers += [number] * len(copies)
            nodes += [_WORLD if in_world else node] * len(copies)
            offsets.append(copies)
    if not nodes:
        raise InputError(
            f"{gltf.path}: this scene has no surfaces to look at: export it with its meshes."
        )
    node_motion = _NodeMotion(animation, nodes=tuple(nodes), offsets=np.concatenate(offsets))
    worlds = np.concatenate([animation.worlds(animation.first_frame), np.eye(4)[None]])
    to_world = worlds[nodes] @ node_motion.offsets
    _check_matrices(gltf, to_world)
    instances = map(Instance, names, numbers, to_world)
    return tuple(instances), node_motion


def _check_matrices(gltf: GltfFile, to_world: Array) -> None:
    """Raise InputError if a matrix (N, 4, 4) moves or scales a mesh too far."""
    if not np.abs(to_world).max() <= _FAR_MOST_M:
        raise InputError(
            f"{gltf.path}: a mesh is farther away or larger than {_FAR_MOST_M:g} m, where nothing "
            "can be drawn."
        )


def _copy_matrices(gltf: GltfFile, record: Record) -> Array:
    """Return the matrices (K, 4, 4) of the copies of a node's mesh, a single one by default."""
    attributes = record.object_at("extensions", _INSTANCING_EXTENSION, "attributes")
    values_by_name = {
        name: read_floats(gltf, index, len(default)).astype(float)
        for name, default in DEFAULT_TRANSFORM.items()
        if (index := gltf.index(attributes, name.upper(), "accessors")) is not None
    }
    if not values_by_name:
        return np.eye(4)[None]
    count = len(next(iter(values_by_name.values())))
    if any(len(values) != count for values in values_by_name.values()):
        attributes.refuse("its lists differ in length")
    all_values = (
        values_by_name.get(name, np.tile(np.array(default, float), (count, 1)))
        for name, default in DEFAULT_TRANSFORM.items()
    )
    return compose_matrices(*all_values)
