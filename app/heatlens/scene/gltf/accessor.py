"""Read numbers from the buffers of a glTF file through its accessors.

Source: Khronos, glTF 2.0 specification, section 3.6.2.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record

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
    found = as_shares(raw) if record.entry.value.get("normalized") is True else raw
    return found.astype(np.float32)


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
