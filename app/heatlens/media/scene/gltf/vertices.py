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
from heatlens.media.scene.gltf.compressed import unpack_draco
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def read_floats(gltf: GltfFile, index: int, width: int) -> NDArray[np.float32]:
    """Return finite numbers (count, width); `normalized` integers become fractions of 1.

    Raises InputError for another width, for NaN and infinity, and if bytes are missing.
    """
    return _require_finite(gltf.top_level("accessors")[index], read_numbers(gltf, index, width))


def read_numbers(gltf: GltfFile, index: int, width: int) -> NDArray[np.float32]:
    """Return numbers as `read_floats` does, but allow NaN and infinity."""
    record = gltf.top_level("accessors")[index]
    stored_values = _read_values(gltf, record, width)
    numbers = (
        convert_to_fractions(stored_values)
        if record.entry.value.get("normalized") is True
        else stored_values
    )
    return numbers.astype(np.float32)


def read_colors(gltf: GltfFile, index: int) -> NDArray[np.float32]:
    """Return numbers (count, 3) or (count, 4); integers always become fractions of 1.

    Some may be NaN or infinite. Raises InputError if bytes are missing.
    """
    record = gltf.top_level("accessors")[index]
    width = 4 if record.text("type") == "VEC4" else 3
    return convert_to_fractions(_read_values(gltf, record, width)).astype(np.float32)


def _require_finite(record: Record, values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the values; raise InputError if some are NaN or infinite."""
    if not np.isfinite(values).all():
        record.refuse("some of its numbers are NaN or infinite; export it again")
    return values


def read_indices(gltf: GltfFile, index: int, vertex_count: int) -> NDArray[np.uint32]:
    """Return integers (count,) less than `vertex_count`; raise InputError for others."""
    record = gltf.top_level("accessors")[index]
    stored_values = _read_values(gltf, record, 1)[:, 0]
    if stored_values.dtype.kind != "u":
        record.refuse("indices should be whole numbers without a sign")
    if stored_values.size and int(stored_values.max()) >= vertex_count:
        record.refuse(
            f"index {int(stored_values.max())} is beyond the {vertex_count} vertices there are"
        )
    return stored_values.astype(np.uint32)


def _read_values(gltf: GltfFile, record: Record, width: int) -> NDArray[np.generic]:
    """Return the values (count, width) of an accessor in the type of the file."""
    dtype, count = _read_dtype(record), record.whole_number("count")
    type_name = record.text("type")
    if _WIDTHS.get(type_name) != width:
        record.refuse(
            f"there should be {width} number(s) each here, not {type_name[:20] or 'none'!r}"
        )
    if record.has("bufferView"):
        values = _read_elements(gltf, record, dtype, (count, width))
        gltf.count_numbers(record, count * width, is_empty=False)
    else:
        gltf.count_numbers(record, count * width, is_empty=True)
        values = np.zeros((count, width), dtype)
    return _apply_sparse(gltf, record, values) if record.has("sparse") else values


def _read_dtype(record: Record) -> np.dtype[np.generic]:
    """Return the NumPy type of the numbers of an accessor."""
    code = record.whole_number("componentType")
    if code not in _TYPES:
        record.refuse(f"{code} is not a number type of glTF")
    return np.dtype(_TYPES[code])


def _read_elements(
    gltf: GltfFile, record: Record, dtype: np.dtype[np.generic], shape: tuple[int, int]
) -> NDArray[np.generic]:
    """Return a copy of the elements in the view that `record` names, which may be strided."""
    view = gltf.required_index(record, "bufferView", "bufferViews")
    view_record = gltf.top_level("bufferViews")[view]
    data, offset = gltf.view(view), record.whole_number("byteOffset", 0)
    size = shape[1] * dtype.itemsize
    stride = view_record.whole_number("byteStride", size)
    if stride < size:
        view_record.refuse(f"elements of {size} bytes cannot lie {stride} bytes apart")
    if shape[0] and offset + stride * (shape[0] - 1) + size > len(data):
        record.refuse(f"its {shape[0]} elements reach past the {len(data)} bytes there are")
    if not shape[0]:
        return np.zeros(shape, dtype)
    return np.ndarray(shape, dtype, data, offset, (stride, dtype.itemsize)).copy()


def _apply_sparse(
    gltf: GltfFile, record: Record, values: NDArray[np.generic]
) -> NDArray[np.generic]:
    """Replace the values that the sparse part of an accessor lists, and return all."""
    sparse = record.object_at("sparse")
    count = sparse.whole_number("count")
    if count > len(values):
        sparse.refuse(f"{count} of {len(values)} elements cannot be replaced")
    index_record = sparse.object_at("indices")
    replaced = _read_elements(gltf, index_record, _read_dtype(index_record), (count, 1))[:, 0]
    if replaced.dtype.kind != "u" or (count and int(replaced.max()) >= len(values)):
        index_record.refuse("an index is beyond what it replaces")
    values[replaced] = _read_elements(
        gltf, sparse.object_at("values"), values.dtype, (count, values.shape[1])
    )
    return values


def convert_to_fractions(values: NDArray[Any]) -> NDArray[np.generic]:
    """Convert normalized integers to fractions of 1; return floats unchanged."""
    if values.dtype.kind == "f":
        return values
    return np.maximum(values / np.iinfo(values.dtype).max, -1.0)


Floats = NDArray[np.float32]

_DRACO_EXTENSION = "KHR_draco_mesh_compression"
_NAN_NOTE = "Normals, colours or texture coordinates that are NaN are replaced"


@dataclass(eq=False)
class Vertices:
    """The attributes and the corners of a primitive.

    Every method raises InputError if the file is damaged.
    """

    gltf: GltfFile
    primitive: Record

    @cached_property
    def positions(self) -> Floats:
        """The positions (V, 3), all finite."""
        draco_values = self._draco_values("POSITION")
        if draco_values is not None:
            positions = draco_values.astype(np.float32)
            if positions.shape[1:] != (3,) or not np.isfinite(positions).all():
                self.primitive.refuse("its packed positions are invalid")
            return positions
        accessor = self._accessor_index("POSITION")
        if accessor is None:
            self.primitive.refuse("it has no POSITION for its vertices")
        return read_floats(self.gltf, accessor, 3)

    def has(self, name: str) -> bool:
        """Return whether there is an attribute of this name."""
        return self.primitive.object_at("attributes").has(name)

    def floats(self, name: str, width: int) -> Floats | None:
        """Return the values (V, width) of an attribute, None if it is missing; NaN becomes 0."""
        accessor, draco_values = self._accessor_index(name), self._draco_values(name)
        if accessor is None:
            return None
        if draco_values is None:
            values = read_numbers(self.gltf, accessor, width)
        else:
            is_normalized = (
                self.gltf.top_level("accessors")[accessor].entry.value.get("normalized") is True
            )
            values = np.asarray(
                convert_to_fractions(draco_values) if is_normalized else draco_values, np.float32
            )
            if values.shape[1:] != (width,):
                self.primitive.refuse(f"its packed {name} has {values.shape[1:]} numbers each")
        values = self._check_values(name, values)
        return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)

    def colors(self) -> Floats | None:
        """Return the first set of colors, (V, 3) or (V, 4), or None; some may be NaN."""
        accessor, draco_values = self._accessor_index("COLOR_0"), self._draco_values("COLOR_0")
        if accessor is None:
            return None
        if draco_values is None:
            return self._check_values("COLOR_0", read_colors(self.gltf, accessor))
        if draco_values.shape[1] not in (3, 4):
            self.primitive.refuse(f"its packed colours have {draco_values.shape[1]} channels")
        return self._check_values(
            "COLOR_0", np.asarray(convert_to_fractions(draco_values), np.float32)
        )

    def corners(self) -> NDArray[np.uint32]:
        """Return the indices of vertices (N,), in the order of the primitive's mode."""
        count = len(self.positions)
        if self._draco_data is not None:
            numbers = self._draco_data[0].reshape(-1)
            if numbers.size and int(numbers.max()) >= count:
                self.primitive.refuse("a packed triangle refers to a vertex that is not there")
            return numbers
        accessor = self.gltf.index(self.primitive, "indices", "accessors")
        if accessor is None:
            return np.arange(count, dtype=np.uint32)
        return read_indices(self.gltf, accessor, count)

    @property
    def is_packed(self) -> bool:
        """Whether Draco packed the primitive; then its corners always form triangles."""
        return self._draco_data is not None

    @cached_property
    def _draco_data(self) -> tuple[NDArray[np.uint32], dict[int, NDArray[np.generic]]] | None:
        """Triangles and attributes that Draco unpacked; None if there is no Draco data.

        It is None as well if Draco is not installed and the primitive also has plain data.
        """
        draco = self.primitive.object_at("extensions", _DRACO_EXTENSION)
        view = self.gltf.index(draco, "bufferView", "bufferViews")
        if view is None:
            return None
        try:
            faces, attributes = unpack_draco(draco, self.gltf.view(view))
        except MissingPackageError:
            if self._has_plain_data():
                return None
            raise
        self.gltf.count_numbers(
            draco, faces.size + sum(values.size for values in attributes.values()), is_empty=False
        )
        return faces, attributes

    def _has_plain_data(self) -> bool:
        """Return True if the positions are stored without compression, too."""
        accessor = self._accessor_index("POSITION")
        return accessor is not None and self.gltf.top_level("accessors")[accessor].has("bufferView")

    def _draco_values(self, name: str) -> NDArray[np.generic] | None:
        """Return the values (V, width) of an attribute that Draco packed; None for a plain one."""
        if self._draco_data is None:
            return None
        numbers = self.primitive.object_at("extensions", _DRACO_EXTENSION, "attributes")
        if not numbers.has(name):
            return None
        values = self._draco_data[1].get(numbers.whole_number(name))
        if values is None or values.ndim != 2:
            self.primitive.refuse(f"its packed bytes hold no {name}")
        return values

    def _accessor_index(self, name: str) -> int | None:
        """Return the index of the accessor of an attribute; None if there is none."""
        return self.gltf.index(self.primitive.object_at("attributes"), name, "accessors")

    def _check_values(self, name: str, values: Floats) -> Floats:
        """Note NaN values; raise InputError unless there is one value for each vertex."""
        if len(values) != len(self.positions):
            self.primitive.object_at("attributes").refuse(
                f"there are {len(self.positions)} positions, but {len(values)} of {name}"
            )
        if not np.isfinite(values).all():
            self.gltf.note_loss(_NAN_NOTE, self.primitive)
        return values
