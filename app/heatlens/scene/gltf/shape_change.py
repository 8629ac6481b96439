"""Which bones and which blended shapes change a mesh of a glTF file on one of its nodes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from heatlens.scene.gltf.animation import Animation
from heatlens.scene.gltf.deform import Deformed, Skin, read_binding, read_skin, read_targets
from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.gltf.vertices import Vertices
from heatlens.scene.scene import Array, Mesh

_BONELESS = "Meshes with weights for bones, but on a node without a skeleton, stay as they are"


@dataclass(eq=False)
class ShapeChange:
    """How the primitives of one mesh change their shape on a node.

    skin    number of its bones, None for none
    blends  the node whose weights blend its shapes, None for those of the mesh
    """

    gltf: GltfFile
    animation: Animation
    skin: int | None
    blends: int | None
    mesh: Record

    def of(self, vertices: Vertices, mesh: Mesh, is_thin: bool) -> Deformed | None:
        """Return the mesh as it changes; None where neither bones nor shapes change it."""
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
        """The bones that the mesh hangs on."""
        return None if self.skin is None else read_skin(self.gltf, self.animation, self.skin)

    @property
    def moves(self) -> bool:
        """Return whether the shape differs from frame to frame."""
        is_blending = self.blends is not None and self.blends in self.animation.weights
        return is_blending or (self.bones is not None and self.bones.moves)

    def weights(self, frame: float) -> Array:
        """Return the weights of the shapes at a frame, none where nobody tells them."""
        if self.blends is not None and self.blends in self.animation.weights:
            return self.animation.weights_of(self.blends, frame)
        return self._still_weights

    @cached_property
    def _still_weights(self) -> Array:
        node = None if self.blends is None else self.animation.tree.records[self.blends]
        told = node if node is not None and node.has("weights") else self.mesh
        return np.array(told.numbers("weights"))
