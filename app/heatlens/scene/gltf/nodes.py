"""The tree of nodes of a glTF file: where each of them is, at one time or at many.

Source: Khronos, glTF 2.0 specification, section 3.5.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.scene import Array

# What of a node an animation moves, and where it stands without one.
RESTS = {"translation": (0, 0, 0), "rotation": (0, 0, 0, 1), "scale": (1, 1, 1)}
_FAR_MOST = 1e9
_ROOT = -1
_LEVELS_MOST = 256  # of nodes below each other; scenes that people make have some ten


@dataclass(frozen=True, eq=False)
class NodeTree:
    """The nodes that hang in the scene.

    locals   (N, 4, 4) each within its parent, at rest
    parents  (N,) -1 for none
    levels   nodes with as many others above them, the roots first; those in no level are not seen
    """

    locals: Array
    parents: tuple[int, ...]
    levels: tuple[tuple[int, ...], ...]
    records: tuple[Record, ...] = field(default=())

    @property
    def seen(self) -> tuple[int, ...]:
        """Every node of the scene, in the order of the file."""
        return tuple(sorted(node for level in self.levels for node in level))

    @np.errstate(over="ignore", invalid="ignore")  # what comes of it is looked at by the caller
    def worlds(self, moved: Mapping[int, Array] | None = None) -> Array:
        """(N, 4, 4) to the world, where `moved` has (4, 4) of nodes that left their rest."""
        worlds = self.locals.copy()
        for node, local in (moved or {}).items():
            worlds[node] = local
        for level in self.levels[1:]:
            nodes = list(level)
            worlds[nodes] = worlds[[self.parents[node] for node in nodes]] @ worlds[nodes]
        return worlds

    def chain(self, node: int) -> list[int]:
        """A node and what it hangs on, up to the root."""
        found = [node]
        while (parent := self.parents[found[-1]]) != _ROOT:
            found.append(parent)
        return found


def read_tree(gltf: GltfFile) -> NodeTree:
    """Raises InputError where the nodes are no tree, or one of them is no place."""
    records = tuple(gltf.listed("nodes"))
    parents = [_ROOT] * len(records)
    levels: list[tuple[int, ...]] = []
    seen: set[int] = set()
    level = _roots(gltf, records)
    while level:
        if len(set(level)) != len(level) or not seen.isdisjoint(level):
            _raise_twice(gltf, level, seen)
        if len(levels) == _LEVELS_MOST:
            records[level[0]].refuse(f"it hangs below {_LEVELS_MOST} others, which are the most")
        seen.update(level)
        levels.append(tuple(level))
        level = _children(records, level, parents)
    locals_ = np.tile(np.eye(4), (len(records), 1, 1))
    for node in seen:
        locals_[node] = _local(records[node])
    return NodeTree(locals_, tuple(parents), tuple(levels), records)


def _raise_twice(gltf: GltfFile, level: list[int], seen: set[int]) -> None:
    """InputError naming a node that is found in two places of the tree."""
    twice = next(node for node in level if node in seen or level.count(node) > 1)
    gltf.listed("nodes")[twice].refuse("it hangs in two places; nodes should be a tree")


def _roots(gltf: GltfFile, records: tuple[Record, ...]) -> list[int]:
    """Of the scene that the file shows first; of all nodes where it has no scene."""
    scenes = gltf.listed("scenes")
    if scenes:
        return scenes[gltf.root.index("scene", len(scenes)) or 0].indices("nodes", len(records))
    below = {child for record in records for child in record.indices("children", len(records))}
    return [node for node in range(len(records)) if node not in below]


def _children(records: tuple[Record, ...], level: list[int], parents: list[int]) -> list[int]:
    """All nodes below a level; their parents are noted."""
    found = []
    for node in level:
        for child in records[node].indices("children", len(records)):
            parents[child] = node
            found.append(child)
    return found


def _local(record: Record) -> Array:
    if not record.has("matrix"):
        rows = [np.array([record.row(*rest)], float) for rest in RESTS.items()]
        if np.abs(np.concatenate(rows, axis=1)).max() > _FAR_MOST:
            record.refuse(f"it is moved or scaled by more than {_FAR_MOST:g}: it is nowhere")
        return np.asarray(matrices(*rows)[0])
    matrix: Array = np.array(record.row("matrix", (0.0,) * 16)).reshape(4, 4).T
    if not np.abs(matrix).max() <= _FAR_MOST or not np.array_equal(matrix[3], (0, 0, 0, 1)):
        record.refuse("its matrix is no place in a scene")
    return np.asarray(matrix)


def matrices(translations: Array, rotations: Array, scales: Array) -> Array:
    """(K, 4, 4) of K translations, quaternions x, y, z, w and scales; within reason.

    A quaternion of no length does not turn.
    """
    lengths = np.linalg.norm(rotations, axis=1, keepdims=True)
    safe = np.where(lengths > 1e-12, lengths, 1.0)
    x, y, z, w = np.where(lengths > 1e-12, rotations / safe, RESTS["rotation"]).T
    found = np.tile(np.eye(4), (len(translations), 1, 1))
    found[:, 0, :3] = np.stack(
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    ).T
    found[:, 1, :3] = np.stack(
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    ).T
    found[:, 2, :3] = np.stack(
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    ).T
    found[:, :3, :3] *= np.clip(scales, -_FAR_MOST, _FAR_MOST)[:, None, :]
    found[:, :3, 3] = np.clip(translations, -_FAR_MOST, _FAR_MOST)
    return found
