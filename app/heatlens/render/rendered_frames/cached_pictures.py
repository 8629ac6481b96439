"""Keep pictures within a size limit, in memory or in a folder; the least recently used go first.

Several windows may share the folder: files are written completely or not at all, and a file that is
damaged or was deleted by another window counts as missing. `CachedPicture` is a rendered picture in
half floats with its windows, and its file format.
"""

import json
import math
import os
import re
import struct
import threading
import zlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from heatlens.core.base.byte_lru import ByteLru
from heatlens.core.base.errors import InputError
from heatlens.core.base.memory import free_memory_bytes
from heatlens.core.base.paths import read_file_bytes
from heatlens.core.model.boxes import Box
from heatlens.media.files.atomic_file import FOR_THE_USER, remove_leftovers, replace_atomically
from heatlens.render.gpu.textures import FloatArray

HalfImage = npt.NDArray[np.float16]
_F = TypeVar("_F", np.float16, np.float32)
_Parts = tuple[npt.NDArray[_F], Box, Box, float]  # of a picture

_HALF_MOST = 65504.0  # the largest half float; larger values would become infinite
_MAGIC = b"HLframe1"  # how every file of a picture begins
_HEAD = struct.Struct("<8sII")  # magic, CRC-32 of the rest, length of the description


@dataclass(frozen=True, eq=False)
class RenderedPicture:
    """One frame as it was rendered: a CachedPicture with (H, W, 4) float32 pixels."""

    pixels: FloatArray
    data_window: Box
    display_window: Box
    pixel_aspect: float = 1.0

    def as_kept(self) -> "CachedPicture":
        """Return the picture in half floats; this takes a while."""
        half = to_half(self.pixels)
        return CachedPicture(half, self.data_window, self.display_window, self.pixel_aspect)


@dataclass(frozen=True, eq=False)
class CachedPicture:
    """One frame.

    pixels          (H, W, 4) half floats, scene-linear, premultiplied
    data_window     that of the plate it was rendered from, in pixels of the plate
    display_window  that of the same plate
    pixel_aspect    width of a pixel divided by its height
    """

    pixels: HalfImage
    data_window: Box
    display_window: Box
    pixel_aspect: float = 1.0

    def as_kept(self) -> "CachedPicture":
        """Return the picture itself."""
        return self


def to_half(pixels: FloatArray) -> HalfImage:
    """Round float32 pixels to half floats, clamped to the largest half float."""
    return np.clip(pixels, -_HALF_MOST, _HALF_MOST).astype(np.float16)


def encode_picture(picture: CachedPicture | RenderedPicture, key: str) -> bytes:
    """Return the bytes of a file with `picture`, `key` and a checksum."""
    height, width = picture.pixels.shape[:2]
    windows = [box.corners for box in (picture.data_window, picture.display_window)]
    entries = {"key": key, "size": [width, height], "windows": windows}
    description = json.dumps(entries | {"pixel_aspect": picture.pixel_aspect}).encode()
    pixels = np.ascontiguousarray(picture.pixels).data.cast("B")
    checksum = zlib.crc32(pixels, zlib.crc32(description))
    return b"".join((_HEAD.pack(_MAGIC, checksum, len(description)), description, pixels))


def decode_picture(data: bytes, key: str) -> CachedPicture | None:
    """Return what `encode_picture` wrote under `key`; None for other or damaged data."""
    parts = _decode_parts(data, key, np.float16)
    return None if parts is None else CachedPicture(*parts)


def decode_float_picture(data: bytes, key: str) -> RenderedPicture | None:
    """Return a picture in float32, where `decode_picture` returns one in half floats."""
    parts = _decode_parts(data, key, np.float32)
    return None if parts is None else RenderedPicture(*parts)


def _decode_parts(data: bytes, key: str, floats: type[_F]) -> _Parts[_F] | None:
    """Return the fields of a stored picture; None for other or damaged data."""
    if len(data) < _HEAD.size:
        return None
    magic, checksum, description_bytes = _HEAD.unpack_from(data)
    if magic != _MAGIC or zlib.crc32(memoryview(data)[_HEAD.size :]) != checksum:
        return None
    try:
        entries = json.loads(data[_HEAD.size : _HEAD.size + description_bytes])
        pixels = np.frombuffer(data, floats, offset=_HEAD.size + description_bytes)
        return _checked_parts(entries, pixels) if entries["key"] == key else None
    except (ValueError, KeyError, TypeError):  # intact, but written by another program
        return None


def _checked_parts(entries: dict[str, Any], floats: npt.NDArray[_F]) -> _Parts[_F]:
    """Return the fields of a picture. Raises ValueError for values that no renderer writes."""
    width, height = entries["size"]
    pixels = floats.reshape(height, width, 4)
    aspect, corners = float(entries["pixel_aspect"]), np.array(entries["windows"])
    is_whole = corners.dtype.kind == "i" and np.abs(corners).max() < 1 << 31
    is_possible = is_whole and 0 < aspect < math.inf and (corners[:, 2:] > corners[:, :2]).all()
    if not (is_possible and np.isfinite(pixels).all()):
        raise ValueError("this is not a rendered picture")
    data_window, display_window = (Box(*map(int, box)) for box in corners)
    return pixels, data_window, display_window, aspect


_FREE_SHARE = 4  # the default limit is a quarter of the free memory
_UNKNOWN_FREE = 4 << 30  # bytes, if the free memory is unknown


class MemoryStore(ByteLru[str, CachedPicture]):
    """Holds pictures by key."""

    def __init__(self, limit_bytes: int) -> None:
        super().__init__(limit_bytes, lambda picture: picture.pixels.nbytes)


def default_memory_bytes() -> int:
    """Return a quarter of the currently free memory in bytes."""
    free = free_memory_bytes()
    return (_UNKNOWN_FREE if free is None else free) // _FREE_SHARE


DEFAULT_BYTES = 4 << 30  # limit of the folder if the user sets none
_NAME = re.compile(r"([0-9a-f]{32})\.frame")


class DiskStore:
    """Files by key, for any thread; `keys` and `bytes_in_use` are of the last listing."""

    def __init__(self, folder: Path, limit_bytes: int = DEFAULT_BYTES) -> None:
        """Make a store; the first picture creates `folder`, and `list_folder` lists its files."""
        self._lock = threading.Lock()
        self._sizes: dict[str, int] = {}  # bytes by key; guarded by the lock
        self.limit_bytes = limit_bytes
        self.folder = folder

    @property
    def bytes_in_use(self) -> int:
        """The bytes of all stored pictures."""
        with self._lock:
            return sum(self._sizes.values())

    def keys(self) -> frozenset[str]:
        """Return the keys of all stored pictures, without waiting for a disk."""
        with self._lock:
            return frozenset(self._sizes)

    def list_folder(self) -> None:
        """List the pictures in the folder, and delete those beyond the limit."""
        remove_leftovers(self.folder)
        self._trim(0)

    def resize(self, limit_bytes: int) -> None:
        """Set another limit, and delete files beyond it at once."""
        self.limit_bytes = limit_bytes
        self._trim(0)

    def load(self, key: str) -> CachedPicture | None:
        """Return the picture and mark its file as used; delete a damaged file and return None."""
        path = self._path(key)
        try:
            picture = decode_picture(read_file_bytes(path), key)
        except OSError:
            picture = None
        if picture is None:
            self._delete(key)
        else:
            with suppress(OSError):
                os.utime(path)
        return picture

    def save(self, key: str, picture: CachedPicture) -> None:
        """Write a picture, unless it is larger than the limit.

        Raises InputError if the file cannot be written.
        """
        data = encode_picture(picture, key)
        if len(data) > self.limit_bytes:
            return
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.folder} cannot be made: {error.strerror}.") from error
        self._trim(len(data))
        with replace_atomically(
            self._path(key), FOR_THE_USER
        ) as temporary_path:  # shots may be confidential
            temporary_path.write_bytes(data)
        with self._lock:
            self._sizes[key] = len(data)
        self._trim(0)  # another window may have written at the same time

    def clear(self) -> None:
        """Delete every picture in the folder."""
        for key in self._list_files():
            self._delete(key)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.frame"

    def _delete(self, key: str) -> None:
        """Delete the file of a picture, and forget its size."""
        with suppress(OSError):
            self._path(key).unlink(missing_ok=True)
        with self._lock:
            self._sizes.pop(key, None)

    def _trim(self, extra_bytes: int) -> None:
        """Delete the oldest files until `extra_bytes` more fit into the limit."""
        files = self._list_files()
        with self._lock:
            self._sizes = {key: size for key, (_, size) in files.items()}
        total = sum(size for _, size in files.values()) + extra_bytes
        for key in sorted(files, key=lambda key: files[key][0]):
            if total <= self.limit_bytes:
                break
            self._delete(key)
            total -= files[key][1]

    def _list_files(self) -> Mapping[str, tuple[int, int]]:
        """Return the time of last use in nanoseconds and the size of every file, by key."""
        files: dict[str, tuple[int, int]] = {}
        with suppress(OSError), os.scandir(self.folder) as entries:
            for entry in entries:
                match = _NAME.fullmatch(entry.name)
                if match:
                    with suppress(OSError):  # another window has deleted it
                        status = entry.stat()
                        files[match[1]] = status.st_mtime_ns, status.st_size
        return files
