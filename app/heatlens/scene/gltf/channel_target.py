"""Find what an animation channel changes: a node, its morph weights, or a camera's angle.

Sources: Khronos, glTF 2.0 specification, section 3.11; KHR_animation_pointer, which names what is
changed by its place in the JSON.
"""

import re
from dataclasses import dataclass

from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.gltf.nodes import RESTS

WEIGHTS, ANGLE = "weights", "yfov"
_POINTER = "KHR_animation_pointer"
_OF_NODE = re.compile(r"/nodes/(\d{1,9})/(translation|rotation|scale|weights)")
_OF_CAMERA = re.compile(r"/cameras/(\d{1,9})/perspective/(yfov)")
_NOT_FOLLOWED = "Animations of anything but nodes and cameras' angles are left out"
_NO_SHAPES = "Animated weights on nodes without morph targets change nothing"


@dataclass(frozen=True)
class Target:
    """The animated property: one of RESTS or WEIGHTS of a node, or ANGLE of a camera."""

    path: str
    number: int


def target_of(gltf: GltfFile, channel: Record) -> Target | None:
    """Return what a channel changes; None if unsupported, with a note if that loses anything.

    Raises InputError if it is a node that is given by a matrix.
    """
    told = channel.inside("target")
    path, node = told.text("path"), gltf.index(told, "node", "nodes")
    found = None if node is None else Target(path, node)
    if path == "pointer":
        found = _pointed(gltf, told.inside("extensions", _POINTER).text("pointer"))
    if found is None or found.path not in (*RESTS, WEIGHTS, ANGLE):
        gltf.lose(_NOT_FOLLOWED, channel)
        return None
    if found.path == WEIGHTS and not _has_shapes(gltf, found.number):
        gltf.lose(_NO_SHAPES, channel)
        return None
    if found.path in RESTS and gltf.listed("nodes")[found.number].has("matrix"):
        told.refuse(f"node {found.number} has a matrix, which cannot be moved by its {found.path}")
    return found


def _pointed(gltf: GltfFile, pointer: str) -> Target | None:
    for pattern, name in ((_OF_NODE, "nodes"), (_OF_CAMERA, "cameras")):
        match = pattern.fullmatch(pointer)
        if match and int(match[1]) < len(gltf.listed(name)):
            return Target(match[2], int(match[1]))
    return None


def _has_shapes(gltf: GltfFile, node: int) -> bool:
    mesh = gltf.index(gltf.listed("nodes")[node], "mesh", "meshes")
    parts = [] if mesh is None else gltf.listed("meshes")[mesh].records("primitives")
    return any(part.has("targets") for part in parts)
