"""Read the vertices of a glTF primitive, whether its bytes are plain or packed by Draco.

Source: Khronos, glTF 2.0 specification, section 3.7; KHR_draco_mesh_compression.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heatlens.scene.gltf.accessor import (
    as_shares,
    read_colors,
    read_floats,
    read_indices,
    read_numbers,
)
from heatlens.scene.gltf.compressed import LibraryMissingError, draco_parts
from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record

Floats = NDArray[np.float32]

_DRACO = "KHR_draco_mesh_compression"
_NAN = "Normals, colours or texture coordinates that are NaN are replaced"


@dataclass(eq=False)
class Vertices:
    """The attributes and the corners of a primitive.

    Every method raises InputError if the file is damaged.
    """

    gltf: GltfFile
    primitive: Record

    @cached_property
    def positions(self) -> Floats:
        """(V, 3), all finite."""
        packed = self._packed("POSITION")
        if packed is not None:
            found = packed.astype(np.float32)
            if found.shape[1:] != (3,) or not np.isfinite(found).all():
                self.primitive.refuse("its packed positions are invalid")
            return found
        accessor = self._accessor("POSITION")
        if accessor is None:
            self.primitive.refuse("it has no POSITION for its vertices")
        return read_floats(self.gltf, accessor, 3)

    def has(self, name: str) -> bool:
        """Return whether there is an attribute of this name."""
        return self.primitive.inside("attributes").has(name)

    def floats(self, name: str, width: int) -> Floats | None:
        """Return the values (V, width) of an attribute, None if it is missing; NaN becomes 0."""
        accessor, packed = self._accessor(name), self._packed(name)
        if accessor is None:
            return None
        if packed is None:
            found = read_numbers(self.gltf, accessor, width)
        else:
            is_share = self.gltf.listed("accessors")[accessor].entry.value.get("normalized") is True
            found = np.asarray(as_shares(packed) if is_share else packed, np.float32)
            if found.shape[1:] != (width,):
                self.primitive.refuse(f"its packed {name} has {found.shape[1:]} numbers each")
        found = self._checked(name, found)
        return np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)

    def colors(self) -> Floats | None:
        """Return the first set of colours, (V, 3) or (V, 4); some may be NaN."""
        accessor, packed = self._accessor("COLOR_0"), self._packed("COLOR_0")
        if accessor is None:
            return None
        if packed is None:
            return self._checked("COLOR_0", read_colors(self.gltf, accessor))
        if packed.shape[1] not in (3, 4):
            self.primitive.refuse(f"its packed colours have {packed.shape[1]} channels")
        return self._checked("COLOR_0", np.asarray(as_shares(packed), np.float32))

    def corners(self) -> NDArray[np.uint32]:
        """Return (N,) indices of vertices, in the order of the primitive's mode."""
        count = len(self.positions)
        if self._unpacked is not None:
            found = self._unpacked[0].reshape(-1)
            if found.size and int(found.max()) >= count:
                self.primitive.refuse("a packed triangle refers to a vertex that is not there")
            return found
        accessor = self.gltf.index(self.primitive, "indices", "accessors")
        if accessor is None:
            return np.arange(count, dtype=np.uint32)
        return read_indices(self.gltf, accessor, count)

    @property
    def is_packed(self) -> bool:
        """Return whether Draco packed the primitive; then its corners always form triangles."""
        return self._unpacked is not None

    @cached_property
    def _unpacked(self) -> tuple[NDArray[np.uint32], dict[int, NDArray[np.generic]]] | None:
        """The data that Draco packed, or None if there is none.

        If Draco is not installed, plain data beside it is used.
        """
        told = self.primitive.inside("extensions", _DRACO)
        view = self.gltf.index(told, "bufferView", "bufferViews")
        if view is None:
            return None
        try:
            faces, parts = draco_parts(told, self.gltf.view(view))
        except LibraryMissingError:
            if self._has_plain_data():
                return None
            raise
        self.gltf.spend(told, faces.size + sum(p.size for p in parts.values()), is_empty=False)
        return faces, parts

    def _has_plain_data(self) -> bool:
        accessor = self._accessor("POSITION")
        return accessor is not None and self.gltf.listed("accessors")[accessor].has("bufferView")

    def _packed(self, name: str) -> NDArray[np.generic] | None:
        """Return the values (V, width) of an attribute that Draco packed; None for a plain one."""
        if self._unpacked is None:
            return None
        numbers = self.primitive.inside("extensions", _DRACO, "attributes")
        if not numbers.has(name):
            return None
        part = self._unpacked[1].get(numbers.whole(name))
        if part is None or part.ndim != 2:
            self.primitive.refuse(f"its packed bytes hold no {name}")
        return part

    def _accessor(self, name: str) -> int | None:
        return self.gltf.index(self.primitive.inside("attributes"), name, "accessors")

    def _checked(self, name: str, found: Floats) -> Floats:
        """Note NaN values; raise InputError unless there is one value for each vertex."""
        if len(found) != len(self.positions):
            self.primitive.inside("attributes").refuse(
                f"there are {len(self.positions)} positions, but {len(found)} of {name}"
            )
        if not np.isfinite(found).all():
            self.gltf.lose(_NAN, self.primitive)
        return found
