"""Read numbers from the buffers of a glTF file by its accessors, and the vertices of primitives.

The bytes of a primitive may be plain or packed by Draco. Sources: Khronos, glTF 2.0 specification,
sections 3.6.2 and 3.7; KHR_draco_mesh_compression.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import MissingPackageError
from heatlens.media.scene.gltf.compressed import draco_parts
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def read_floats(gltf: GltfFile, index: int, width: int) -> NDArray[np.float32]:
    """Return finite numbers (count, width); `normalized` integers become fractions of 1.

    Raises InputError for another width, for NaN and infinity, and if bytes are missing.
    """
    return _finite(gltf.listed("accessors")[index], read_numbers(gltf, index, width))


def read_numbers(gltf: GltfFile, index: int, width: int) -> NDArray[np.float32]:
    """Return numbers as `read_floats` does, but allow NaN and infinity."""
    record = gltf.listed("accessors")[index]
    raw = _values(gltf, record, width)
    shares = as_shares(raw) if record.entry.value.get("normalized") is True else raw
    return shares.astype(np.float32)


def read_colors(gltf: GltfFile, index: int) -> NDArray[np.float32]:
    """Return numbers (count, 3) or (count, 4); integers always become fractions of 1.

    Some may be NaN or infinite. Raises InputError if bytes are missing.
    """
    record = gltf.listed("accessors")[index]
    width = 4 if record.text("type") == "VEC4" else 3
    return as_shares(_values(gltf, record, width)).astype(np.float32)


def _finite(record: Record, values: NDArray[np.float32]) -> NDArray[np.float32]:
    if not np.isfinite(values).all():
        record.refuse("some of its numbers are NaN or infinite; export it again")
    return values


def read_indices(gltf: GltfFile, index: int, below: int) -> NDArray[np.uint32]:
    """Return integers (count,) less than `below`; raise InputError for others."""
    record = gltf.listed("accessors")[index]
    raw = _values(gltf, record, 1)[:, 0]
    if raw.dtype.kind != "u":
        record.refuse("indices should be whole numbers without a sign")
    if raw.size and int(raw.max()) >= below:
        record.refuse(f"index {int(raw.max())} is beyond the {below} vertices there are")
    return raw.astype(np.uint32)


def _values(gltf: GltfFile, record: Record, width: int) -> NDArray[np.generic]:
    """Return (count, width) values in the type of the file."""
    dtype, count = _dtype(record), record.whole("count")
    kind = record.text("type")
    if _WIDTHS.get(kind) != width:
        record.refuse(f"there should be {width} number(s) each here, not {kind[:20] or 'none'!r}")
    if record.has("bufferView"):
        values = _elements(gltf, record, dtype, (count, width))
        gltf.spend(record, count * width, is_empty=False)
    else:
        gltf.spend(record, count * width, is_empty=True)
        values = np.zeros((count, width), dtype)
    return _with_sparse(gltf, record, values) if record.has("sparse") else values


def _dtype(record: Record) -> np.dtype[np.generic]:
    code = record.whole("componentType")
    if code not in _TYPES:
        record.refuse(f"{code} is not a number type of glTF")
    return np.dtype(_TYPES[code])


def _elements(
    gltf: GltfFile, record: Record, dtype: np.dtype[np.generic], shape: tuple[int, int]
) -> NDArray[np.generic]:
    """Return a copy of the elements in the view that `record` names, which may be strided."""
    view = gltf.needed(record, "bufferView", "bufferViews")
    strided = gltf.listed("bufferViews")[view]
    data, offset = gltf.view(view), record.whole("byteOffset", 0)
    size = shape[1] * dtype.itemsize
    stride = strided.whole("byteStride", size)
    if stride < size:
        strided.refuse(f"elements of {size} bytes cannot lie {stride} bytes apart")
    if shape[0] and offset + stride * (shape[0] - 1) + size > len(data):
        record.refuse(f"its {shape[0]} elements reach past the {len(data)} bytes there are")
    if not shape[0]:
        return np.zeros(shape, dtype)
    return np.ndarray(shape, dtype, data, offset, (stride, dtype.itemsize)).copy()


def _with_sparse(
    gltf: GltfFile, record: Record, values: NDArray[np.generic]
) -> NDArray[np.generic]:
    """Return the values after applying the replacements in the sparse part."""
    sparse = record.inside("sparse")
    count = sparse.whole("count")
    if count > len(values):
        sparse.refuse(f"{count} of {len(values)} elements cannot be replaced")
    places = sparse.inside("indices")
    where = _elements(gltf, places, _dtype(places), (count, 1))[:, 0]
    if where.dtype.kind != "u" or (count and int(where.max()) >= len(values)):
        places.refuse("an index is beyond what it replaces")
    values[where] = _elements(gltf, sparse.inside("values"), values.dtype, (count, values.shape[1]))
    return values


def as_shares(values: NDArray[Any]) -> NDArray[np.generic]:
    """Convert normalised integers to fractions of 1; return floats unchanged."""
    if values.dtype.kind == "f":
        return values
    return np.maximum(values / np.iinfo(values.dtype).max, -1.0)


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
            places = packed.astype(np.float32)
            if places.shape[1:] != (3,) or not np.isfinite(places).all():
                self.primitive.refuse("its packed positions are invalid")
            return places
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
            values = read_numbers(self.gltf, accessor, width)
        else:
            is_share = self.gltf.listed("accessors")[accessor].entry.value.get("normalized") is True
            values = np.asarray(as_shares(packed) if is_share else packed, np.float32)
            if values.shape[1:] != (width,):
                self.primitive.refuse(f"its packed {name} has {values.shape[1:]} numbers each")
        values = self._checked(name, values)
        return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)

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
            numbers = self._unpacked[0].reshape(-1)
            if numbers.size and int(numbers.max()) >= count:
                self.primitive.refuse("a packed triangle refers to a vertex that is not there")
            return numbers
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
        draco = self.primitive.inside("extensions", _DRACO)
        view = self.gltf.index(draco, "bufferView", "bufferViews")
        if view is None:
            return None
        try:
            faces, parts = draco_parts(draco, self.gltf.view(view))
        except MissingPackageError:
            if self._has_plain_data():
                return None
            raise
        self.gltf.spend(draco, faces.size + sum(p.size for p in parts.values()), is_empty=False)
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

    def _checked(self, name: str, values: Floats) -> Floats:
        """Note NaN values; raise InputError unless there is one value for each vertex."""
        if len(values) != len(self.positions):
            self.primitive.inside("attributes").refuse(
                f"there are {len(self.positions)} positions, but {len(values)} of {name}"
            )
        if not np.isfinite(values).all():
            self.gltf.lose(_NAN, self.primitive)
        return values
