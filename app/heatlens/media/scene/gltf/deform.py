"""Deform meshes by skins (bones) and morph targets (blend shapes).

Sources: Khronos, glTF 2.0 specification, section 3.7.2.2 (morph targets) and 3.7.3 (skins).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.gltf.animation import Animation
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.vertices import Vertices, read_floats
from heatlens.media.scene.mesh_make import smooth_normals
from heatlens.media.scene.scene import Array, Mesh

Floats = NDArray[np.float32]

_FAR_MOST_M = 1e9
_UNBOUND_NOTE = "Meshes with bones but without weights keep their modelled shape"
_VALUE_MOST = 1e30  # beyond this, products overflow float32


@dataclass(frozen=True, eq=False)
class Skin:
    """The bones of a skin.

    joints         the node of each of J bones
    inverse_binds  (J, 4, 4) from the mesh's own axes to those of each bone
    """

    animation: Animation
    joints: tuple[int, ...]
    inverse_binds: Array

    @property
    def is_moving(self) -> bool:
        """Whether any of the bones moves."""
        return any(self.animation.is_moving(joint) for joint in self.joints)

    def matrices(self, frame: float) -> Floats:
        """Return the matrices (J, 3, 4) of the bones, from the mesh to the world, at a frame."""
        to_world = self.animation.worlds(frame)[list(self.joints)] @ self.inverse_binds
        return np.nan_to_num(np.clip(to_world[:, :3], -_VALUE_MOST, _VALUE_MOST)).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Binding:
    """The skinning of V vertices: the numbers (V, K) of the bones of each, and their weights."""

    skin: Skin
    joints: NDArray[np.intp]
    weights: Floats

    def apply(self, mesh: Mesh, frame: float) -> Mesh:
        """Return the mesh with its vertices in the world, as the bones move them at a frame."""
        bones = self.skin.matrices(frame)
        blend = np.zeros((len(self.joints), 3, 4), np.float32)
        for joint, weight in zip(self.joints.T, self.weights.T, strict=True):
            blend += weight[:, None, None] * bones[joint]
        rotations = blend[:, :, :3]
        positions = np.einsum("vij,vj->vi", rotations, mesh.positions_m) + blend[:, :, 3]
        tangents = mesh.tangents
        if tangents is not None:
            tangent_directions = np.einsum("vij,vj->vi", rotations, tangents[:, :3])
            tangents = np.concatenate([_normalize(tangent_directions), tangents[:, 3:]], axis=1)
        normals = _normalize(np.einsum("vij,vj->vi", rotations, mesh.normals))
        return replace(mesh, positions_m=positions, normals=normals, tangents=tangents)


@dataclass(frozen=True, eq=False)
class Targets:
    """Morph targets: changes (S, V, 3) that are added to a mesh, times their weights.

    `weights` returns the weights (S,) at a frame. An attribute that no target changes is None.
    """

    weights: Callable[[float], Array]
    positions: Floats
    normals: Floats | None
    tangents: Floats | None

    def apply(self, mesh: Mesh, frame: float) -> Mesh:
        """Return the mesh with its morph targets applied at a frame."""
        weights = np.clip(self.weights(frame), -_VALUE_MOST, _VALUE_MOST).astype(np.float32)
        used_shapes = np.flatnonzero(weights)
        if not len(used_shapes):
            return mesh

        def weighted_sum(shapes: Floats | None) -> Floats | float:
            """Return the sum of the shapes by their weights; 0 if there are none."""
            return (
                0.0
                if shapes is None
                else np.tensordot(weights[used_shapes], shapes[used_shapes], 1)
            )

        tangents = mesh.tangents
        if tangents is not None:
            tangent_directions = _normalize(tangents[:, :3] + weighted_sum(self.tangents))
            tangents = np.concatenate([tangent_directions, tangents[:, 3:]], axis=1)
        positions = np.asarray(mesh.positions_m + weighted_sum(self.positions), np.float32)
        normals = _normalize(mesh.normals + weighted_sum(self.normals))
        return replace(mesh, positions_m=positions, normals=normals, tangents=tangents)


@dataclass(frozen=True, eq=False)
class DeformedMesh:
    """A mesh that changes from frame to frame.

    mesh        the undeformed mesh
    is_faceted  flat shading: each triangle has its own vertices and one normal
    """

    mesh: Mesh
    targets: Targets | None
    binding: Binding | None
    is_faceted: bool

    @np.errstate(over="ignore", invalid="ignore")  # positions are limited below
    def __call__(self, frame: float) -> Mesh:
        """Return the mesh at a frame; its triangles are always the same."""
        mesh = self.mesh
        for change in (self.targets, self.binding):
            mesh = mesh if change is None else change.apply(mesh, frame)
        positions = np.nan_to_num(mesh.positions_m, nan=0.0)
        positions = np.clip(positions, -_FAR_MOST_M, _FAR_MOST_M).astype(np.float32)
        normals = mesh.normals
        if self.is_faceted:
            normals = smooth_normals(positions, mesh.triangles)
        return replace(mesh, positions_m=positions, normals=normals)


def _normalize(vectors: Floats) -> Floats:
    """Normalise vectors (V, 3); those without a direction point upwards."""
    finite = np.nan_to_num(vectors, nan=0.0, posinf=0.0, neginf=0.0)
    lengths = np.linalg.norm(finite, axis=1, keepdims=True)
    has_direction = (lengths > 1e-20) & np.isfinite(lengths)
    upwards = np.array([0.0, 1.0, 0.0], np.float32)
    return np.where(has_direction, finite / np.where(has_direction, lengths, 1.0), upwards).astype(
        np.float32
    )


def read_skin(gltf: GltfFile, animation: Animation, index: int) -> Skin:
    """Read a skin; raise InputError if it is damaged."""
    record = gltf.top_level("skins")[index]
    joints = record.indices("joints", len(gltf.top_level("nodes")))
    accessor = gltf.index(record, "inverseBindMatrices", "accessors")
    if not joints:
        record.refuse("it has no joints")
    if accessor is None:
        return Skin(animation, tuple(joints), np.tile(np.eye(4), (len(joints), 1, 1)))
    rows = read_floats(gltf, accessor, 16).astype(float)
    if len(rows) < len(joints):
        record.refuse(f"it has {len(joints)} joints, but {len(rows)} matrices")
    matrices = rows[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    return Skin(animation, joints=tuple(joints), inverse_binds=matrices)


def read_binding(vertices: Vertices, mesh: Mesh, skin: Skin) -> Binding | None:
    """Return the skinning of a mesh; None if the file has none, with a note if it is incomplete."""
    joints, weights = [], []
    number = 0
    while (joint_set := vertices.floats(f"JOINTS_{number}", 4)) is not None:
        joints.append(joint_set)
        weights.append(vertices.floats(f"WEIGHTS_{number}", 4))
        number += 1
    if not joints or any(weight_set is None for weight_set in weights):
        vertices.gltf.note_loss(_UNBOUND_NOTE, vertices.primitive)
        return None
    weight_shares = np.concatenate(
        [weight_set for weight_set in weights if weight_set is not None], axis=1
    )
    bones = np.where(
        weight_shares == 0, 0, np.concatenate(joints, axis=1)
    )  # indices without weight are arbitrary
    if bones.size and not (0 <= bones.min() and bones.max() < len(skin.joints)):
        vertices.primitive.refuse(
            f"a vertex refers to bone {int(bones.max())} of {len(skin.joints)}"
        )
    sums = weight_shares.sum(axis=1, keepdims=True)
    weight_shares = np.asarray(weight_shares / np.where(np.abs(sums) > 1e-6, sums, 1.0), np.float32)
    used_columns = np.flatnonzero(
        (weight_shares != 0).any(axis=0)
    )  # most files have columns of zeros
    vertex_index = slice(None) if mesh.sources is None else mesh.sources
    return Binding(
        skin,
        joints=bones[vertex_index][:, used_columns].astype(np.intp),
        weights=weight_shares[vertex_index][:, used_columns],
    )


def read_targets(
    vertices: Vertices, mesh: Mesh, weights: Callable[[float], Array], count: int
) -> Targets | None:
    """Return the first `count` morph targets of a mesh, those with weights; None for none."""
    records = vertices.primitive.records("targets")[:count]
    if count > len(vertices.primitive.records("targets")):
        vertices.gltf.note_loss(
            "Weights of missing morph targets change nothing", vertices.primitive
        )
    if not records:
        return None
    positions, normals, tangents = (
        _read_shapes(vertices, mesh, records, name) for name in ("POSITION", "NORMAL", "TANGENT")
    )
    if positions is None:
        positions = np.zeros((len(records), len(mesh.positions_m), 3), np.float32)
    return Targets(lambda frame: weights(frame)[: len(records)], positions, normals, tangents)


def _read_shapes(vertices: Vertices, mesh: Mesh, records: list[Record], name: str) -> Floats | None:
    """Return an attribute of all morph targets, (S, V, 3); None if no target has it."""
    gltf = vertices.gltf
    shapes = np.zeros((len(records), len(mesh.positions_m), 3), np.float32)
    vertex_index = slice(None) if mesh.sources is None else mesh.sources
    has_any = False
    for shape, record in zip(shapes, records, strict=True):
        accessor = gltf.index(record, name, "accessors")
        if accessor is None:
            continue
        values = read_floats(gltf, accessor, 3)
        if len(values) != len(vertices.positions):
            record.refuse(f"there are {len(vertices.positions)} positions, but {len(values)} here")
        shape[:], has_any = values[vertex_index], True
    return shapes if has_any else None
