"""Find the bones and morph targets that change a mesh of a glTF file on one of its nodes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from heatlens.scene.gltf.animation import Animation
from heatlens.scene.gltf.deform import Deformed, Skin, read_binding, read_skin, read_targets
from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.gltf.vertices import Vertices
from heatlens.scene.scene import Array, Mesh

_BONELESS = "Skinned meshes on nodes without a skeleton keep their modelled shape"


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
        told = node if node is not None and node.has("weights") else self.mesh
        return np.array(told.numbers("weights"))
