"""Read the node tree of a glTF file, and compute the transforms of the nodes.

Sources: Khronos, glTF 2.0 specification, section 3.5; KHR_node_visibility.

The targets of animation channels are found here as well: a node, its morph weights, or a camera's
angle of view (section 3.11; KHR_animation_pointer, which names a target by its path in the JSON).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.scene import Array

# The properties of a node that an animation can move, and their values at rest.
DEFAULT_TRANSFORM = {"translation": (0, 0, 0), "rotation": (0, 0, 0, 1), "scale": (1, 1, 1)}
_FAR_MOST = 1e9
_ROOT = -1
_LEVELS_MOST = 256  # levels of nodes; usual scenes have about ten


@dataclass(frozen=True, eq=False)
class NodeTree:
    """The nodes of the scene.

    locals   (N, 4, 4) matrices from each node to its parent, at rest
    parents  (N,) with -1 for none
    levels   nodes by their depth in the tree, the roots first; nodes in no level are not visible
    hidden   the nodes that the file hides, and their descendants
    """

    locals: Array
    parents: tuple[int, ...]
    levels: tuple[tuple[int, ...], ...]
    records: tuple[Record, ...] = field(default=())
    hidden: frozenset[int] = frozenset()

    @property
    def scene_nodes(self) -> tuple[int, ...]:
        """Every node of the scene, in the order of the file."""
        return tuple(sorted(node for level in self.levels for node in level))

    @np.errstate(over="ignore", invalid="ignore")  # the caller checks the result
    def worlds(self, moving_locals: Mapping[int, Array] | None = None) -> Array:
        """Return the matrices (N, 4, 4) from all nodes to the world.

        `moving_locals` holds, by node, the matrix (4, 4) to the parent for nodes not at rest.
        """
        worlds = self.locals.copy()
        for node, local in (moving_locals or {}).items():
            worlds[node] = local
        for level in self.levels[1:]:
            nodes = list(level)
            worlds[nodes] = worlds[[self.parents[node] for node in nodes]] @ worlds[nodes]
        return worlds

    def chain(self, node: int) -> list[int]:
        """Return a node and its ancestors up to the root."""
        nodes = [node]
        while (parent := self.parents[nodes[-1]]) != _ROOT:
            nodes.append(parent)
        return nodes


def read_tree(gltf: GltfFile) -> NodeTree:
    """Read the nodes; raise InputError if they form no tree or a transform is invalid."""
    records = tuple(gltf.top_level("nodes"))
    parents = [_ROOT] * len(records)
    levels: list[tuple[int, ...]] = []
    visited: set[int] = set()
    level = _find_roots(gltf, records)
    while level:
        if len(set(level)) != len(level) or not visited.isdisjoint(level):
            _raise_two_parents(gltf, level, visited)
        if len(levels) == _LEVELS_MOST:
            records[level[0]].refuse(f"it has more than {_LEVELS_MOST} ancestors")
        visited.update(level)
        levels.append(tuple(level))
        level = _collect_children(records, level, parents)
    locals_ = np.tile(np.eye(4), (len(records), 1, 1))
    for node in visited:
        locals_[node] = _read_local_matrix(records[node])
    hidden = _find_hidden(records, parents, levels)
    return NodeTree(locals_, tuple(parents), tuple(levels), records, hidden)


def _find_hidden(
    records: tuple[Record, ...], parents: list[int], levels: list[tuple[int, ...]]
) -> frozenset[int]:
    """Return the nodes that KHR_node_visibility hides, and their descendants."""
    hidden: set[int] = set()
    for node in (node for level in levels for node in level):
        visibility = records[node].object_at("extensions", "KHR_node_visibility")
        is_visible = (
            not visibility.has("visible") or visibility.entry_at("visible").value is not False
        )
        if parents[node] in hidden or not is_visible:
            hidden.add(node)
    return frozenset(hidden)


def _raise_two_parents(gltf: GltfFile, level: list[int], visited: set[int]) -> None:
    """Raise InputError that names a node with two places in the tree."""
    repeated = next(node for node in level if node in visited or level.count(node) > 1)
    gltf.top_level("nodes")[repeated].refuse("it has two parents; nodes must form a tree")


def _find_roots(gltf: GltfFile, records: tuple[Record, ...]) -> list[int]:
    """Return the roots of the default scene, or of all nodes if there is no scene."""
    scenes = gltf.top_level("scenes")
    if scenes:
        return scenes[gltf.root.index("scene", len(scenes)) or 0].indices("nodes", len(records))
    child_nodes = {
        child for record in records for child in record.indices("children", len(records))
    }
    return [node for node in range(len(records)) if node not in child_nodes]


def _collect_children(
    records: tuple[Record, ...], level: list[int], parents: list[int]
) -> list[int]:
    """Return all nodes below a level, and set their parents."""
    children = []
    for node in level:
        for child in records[node].indices("children", len(records)):
            parents[child] = node
            children.append(child)
    return children


def _read_local_matrix(record: Record) -> Array:
    """Return the matrix (4, 4) from a node to its parent, at rest."""
    if not record.has("matrix"):
        rows = [np.array([record.row(*default)], float) for default in DEFAULT_TRANSFORM.items()]
        if np.abs(np.concatenate(rows, axis=1)).max() > _FAR_MOST:
            record.refuse(f"it is moved or scaled by more than {_FAR_MOST:g}, which is too much")
        return np.asarray(compose_matrices(*rows)[0])
    matrix: Array = np.array(record.row("matrix", (0.0,) * 16)).reshape(4, 4).T
    if not np.abs(matrix).max() <= _FAR_MOST or not np.array_equal(matrix[3], (0, 0, 0, 1)):
        record.refuse("its matrix is not a valid transform")
    return np.asarray(matrix)


def compose_matrices(translations: Array, rotations: Array, scales: Array) -> Array:
    """Return matrices (K, 4, 4) of K translations, quaternions (x, y, z, w) and scales.

    A quaternion of length 0 does not rotate.
    """
    lengths = np.linalg.norm(rotations, axis=1, keepdims=True)
    safe_lengths = np.where(lengths > 1e-12, lengths, 1.0)
    x, y, z, w = np.where(
        lengths > 1e-12, rotations / safe_lengths, DEFAULT_TRANSFORM["rotation"]
    ).T
    composed = np.tile(np.eye(4), (len(translations), 1, 1))
    composed[:, 0, :3] = np.stack(
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    ).T
    composed[:, 1, :3] = np.stack(
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    ).T
    composed[:, 2, :3] = np.stack(
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    ).T
    composed[:, :3, :3] *= np.clip(scales, -_FAR_MOST, _FAR_MOST)[:, None, :]
    composed[:, :3, 3] = np.clip(translations, -_FAR_MOST, _FAR_MOST)
    return composed


WEIGHTS, ANGLE = "weights", "yfov"
_POINTER_EXTENSION = "KHR_animation_pointer"
_NODE_POINTER = re.compile(r"/nodes/(\d{1,9})/(translation|rotation|scale|weights)")
_CAMERA_POINTER = re.compile(r"/cameras/(\d{1,9})/perspective/(yfov)")
_UNSUPPORTED_NOTE = "Animations of anything but nodes and cameras' angles are left out"
_NO_SHAPES_NOTE = "Animated weights on nodes without morph targets change nothing"


@dataclass(frozen=True)
class Target:
    """A property that an animation changes.

    path    one of DEFAULT_TRANSFORM or WEIGHTS for a node, or ANGLE for a camera
    number  the number of the node or camera in the file
    """

    path: str
    number: int


def read_target(gltf: GltfFile, channel: Record) -> Target | None:
    """Return the property that a channel animates; None with a note if it is not supported.

    Raises InputError for a node that has a matrix, which cannot be animated.
    """
    record = channel.object_at("target")
    path, node = record.text("path"), gltf.index(record, "node", "nodes")
    target = None if node is None else Target(path, node)
    if path == "pointer":
        target = _parse_pointer(
            gltf, record.object_at("extensions", _POINTER_EXTENSION).text("pointer")
        )
    if target is None or target.path not in (*DEFAULT_TRANSFORM, WEIGHTS, ANGLE):
        gltf.note_loss(_UNSUPPORTED_NOTE, channel)
        return None
    if target.path == WEIGHTS and not _has_shapes(gltf, target.number):
        gltf.note_loss(_NO_SHAPES_NOTE, channel)
        return None
    if target.path in DEFAULT_TRANSFORM and gltf.top_level("nodes")[target.number].has("matrix"):
        record.refuse(
            f"node {target.number} has a matrix, which cannot be moved by its {target.path}"
        )
    return target


def _parse_pointer(gltf: GltfFile, pointer: str) -> Target | None:
    """Return the target that a JSON pointer names; None if it is not supported."""
    for pattern, name in ((_NODE_POINTER, "nodes"), (_CAMERA_POINTER, "cameras")):
        match = pattern.fullmatch(pointer)
        if match and int(match[1]) < len(gltf.top_level(name)):
            return Target(match[2], int(match[1]))
    return None


def _has_shapes(gltf: GltfFile, node: int) -> bool:
    """Return True if the mesh of a node has morph targets."""
    mesh = gltf.index(gltf.top_level("nodes")[node], "mesh", "meshes")
    parts = [] if mesh is None else gltf.top_level("meshes")[mesh].records("primitives")
    return any(part.has("targets") for part in parts)
