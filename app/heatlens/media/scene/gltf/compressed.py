"""Compressed meshes and pictures of glTF files, unpacked by libraries of the extra `scene`.

Sources: Khronos, KHR_draco_mesh_compression, KHR_texture_basisu; EXT_meshopt_compression.
"""

import importlib
import importlib.util
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.media.files.limits import is_bounded
from heatlens.media.scene.gltf.json_values import Record

_BYTES_MOST = 1 << 30  # largest unpacked size of a compressed part of a file
_SIDE_MOST_PX = 16384
KTX2_HEAD = b"\xabKTX 20\xbb\r\n\x1a\n"


class OwnProcessNeededError(Exception):
    """A file is compressed; its bytes, which may crash a library, are not unpacked here."""


def _import_library(name: str, label: str) -> ModuleType:
    """Import a library that unpacks data.

    Raises OwnProcessNeededError outside the separate process, because it may crash.
    """
    if importlib.util.find_spec(name) is not None and not is_bounded():
        raise OwnProcessNeededError
    return import_extra(name, label)


def unpack_draco(
    record: Record, data: memoryview
) -> tuple[NDArray[np.uint32], dict[int, NDArray[np.generic]]]:
    """Return triangles (T, 3) and the attributes (V, width) by their numbers in the bytes.

    Raises InputError if the bytes are damaged, MissingPackageError without DracoPy.
    """
    library = _import_library("DracoPy", f"{record.entry.path}: a mesh compressed by Draco")
    try:
        mesh = library.decode(bytes(data))
        faces = np.asarray(mesh.faces).reshape(-1, 3).astype(np.uint32)
        parts = {part["unique_id"]: np.asarray(part["data"]) for part in mesh.attributes}
    except Exception as error:  # DracoPy raises any exception for damaged bytes, or for points
        record.refuse(f"its bytes are not a Draco mesh ({_short_message(error)}); export it again")
    return faces, parts


def unpack_meshopt(record: Record, data: memoryview) -> bytes:
    """Return the unpacked bytes of a buffer view.

    Raises InputError if they are damaged, MissingPackageError without meshopt.
    """
    library = _import_library(
        "meshopt", f"{record.entry.path}: a buffer compressed by meshoptimizer"
    )
    count, stride = record.whole_number("count"), record.whole_number("byteStride")
    if count * stride > _BYTES_MOST:
        record.refuse(f"it claims to hold {count * stride:,} bytes, which is too much")
    mode_and_filter = record.text("mode"), record.text("filter", "NONE")
    try:
        decoded = library.decode_gltf_buffer(
            bytes(data), count, stride, mode_and_filter[0], mode_and_filter[1]
        )
    except (ValueError, MemoryError) as error:
        record.refuse(f"its bytes cannot be unpacked ({_short_message(error)}); export it again")
    return np.ascontiguousarray(decoded).tobytes()


def decode_ktx2(data: bytes, label: str) -> NDArray[np.uint8]:
    """Return a picture in KTX 2 with Basis Universal as (H, W, 4); errors call it `label`.

    Raises InputError if it is damaged or too large, MissingPackageError without opengl_basisu.
    """
    library = _import_library("opengl_basisu", f"{label}: a picture in KTX 2")
    try:
        texture = library.open(data)
        if max(texture.width, texture.height) > _SIDE_MOST_PX:
            raise ValueError(f"{texture.width} x {texture.height} pixels are too many")
        pixels = texture.transcode(library.Target.RGBA8).data
    except (ValueError, MemoryError) as error:
        raise InputError(f"{label}: the picture is damaged ({_short_message(error)}).") from error
    return np.array(pixels, np.uint8)


def _short_message(error: BaseException) -> str:
    """Return the message of an error in one short line, or its type if it has none."""
    return " ".join(str(error).split())[:100].rstrip(".") or type(error).__name__
