"""Parse the headers of an EXR file from its bytes, before any library opens it.

A few flipped bits can make a header claim a million channels or tiles of gigabytes, for which a
library allocates memory before it looks at the pixels. A file that was cut short by a full disk, a
broken copy or a power cut still has a valid header; its tables of chunks tell what is missing,
without reading the pixels. Source: OpenEXR, "File Layout".
"""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from heatlens.core.base.paths import opened_file

MAGIC = b"\x76\x2f\x31\x01"
_MANY_PARTS = 0x1000
_PARTS_MOST = 1000
_NAME_MOST = 256  # the format allows 255
_BYTES_MOST = 1 << 26  # bytes in all headers; Cryptomatte manifests are the largest entries
_TYPES = {0: "<u4", 1: "<f2", 2: "<f4"}  # pixel type number -> NumPy type

RawHeader = dict[str, bytes]
_LINES_OF_CHUNK = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}
_DEEP_SIZES = "<3Q"  # bytes of the packed table, the packed samples and the unpacked samples


class CutError(ValueError):
    """The headers are cut off, or are not valid headers at all."""


@dataclass(frozen=True)
class RawChannel:
    """A channel as the header lists it."""

    name: bytes
    numpy_type: str
    x_sampling: int
    y_sampling: int

    @property
    def bytes_each(self) -> int:
        """Size of one value in bytes."""
        return int(self.numpy_type[-1])


def attributes_of(file: BinaryIO) -> Iterator[tuple[int, int, str, int]]:
    """Yield the attributes of all parts: begin, begin of the type, type, and end in the file.

    Raises CutError if they are incomplete.
    """
    file.seek(4)
    (flags,) = _numbers(file, "<I")
    is_in_part = True
    while True:
        start = file.tell()
        if not _name(file):
            if not flags & _MANY_PARTS or not is_in_part:
                return
            is_in_part = False
            continue
        is_in_part, kind_at = True, file.tell()
        kind = _name(file)
        (length,) = _numbers(file, "<I")
        yield start, kind_at, kind, file.seek(length, 1)


def scanned_headers(file: BinaryIO) -> list[RawHeader]:
    """Return the raw attributes of each part by name; the file's position is then behind them.

    Raises CutError if they are incomplete.
    """
    if file.read(4) != MAGIC:
        raise CutError("not an EXR file")
    (flags,) = _numbers(file, "<I")
    if not flags & _MANY_PARTS:
        return [_header(file)]
    found = []
    while header := _header(file):
        found.append(header)
        if len(found) > _PARTS_MOST:
            raise CutError(f"there are more than {_PARTS_MOST} parts")
    return found


def channels_of(header: RawHeader) -> list[RawChannel]:
    """Return the channels of one part. Raises CutError if the list is incomplete."""
    stored, at, found = header.get("channels", b""), 0, []
    while at < len(stored) and stored[at]:
        end = stored.find(b"\0", at)
        if end < 0 or end + 17 > len(stored):
            raise CutError("the list of channels is cut off")
        kind, _, x, y = struct.unpack_from("<i4sii", stored, end + 1)
        if kind not in _TYPES:
            raise CutError("a channel has an unknown type")
        found.append(RawChannel(stored[at:end], _TYPES[kind], max(x, 1), max(y, 1)))
        at = end + 17
    return found


def _header(file: BinaryIO) -> RawHeader:
    found = {}
    while name := _name(file):
        if "\\x" in _name(file):  # OpenEXR for Python cannot tell such a type, nor print its value
            raise CutError(f"the type of the attribute {name[:40]!r} is not UTF-8")
        (length,) = _numbers(file, "<I")
        value = file.read(length) if file.tell() + length <= _BYTES_MOST else b""
        if len(value) != length:
            raise CutError(f"the attribute {name[:40]!r} is cut off")
        found[name] = value
    return found


def _name(file: BinaryIO) -> str:
    start = file.tell()
    letters, zero, _ = file.read(_NAME_MOST + 1).partition(b"\0")
    if not zero:
        raise CutError("a name in it does not end")
    file.seek(start + len(letters) + 1)
    return letters.decode("utf-8", "backslashreplace")


def _numbers(file: BinaryIO, form: str) -> tuple[int, ...]:
    data = file.read(struct.calcsize(form))
    if len(data) < struct.calcsize(form):
        raise CutError("it ends in the middle of a number")
    return struct.unpack(form, data)


def is_whole_exr(path: Path) -> bool:
    """Return True if every chunk of every part of the file at `path` ends within the file."""
    try:
        with opened_file(path) as file:
            end = end_of_chunks(file)
            return end is None or 0 < end <= os.fstat(file.fileno()).st_size
    except (OSError, struct.error, ValueError, LookupError):  # the structure itself is cut off
        return False


def end_of_chunks(file: BinaryIO) -> int | None:
    """Return where the last chunk of a file ends; 0 if a chunk is missing, None if unknown.

    Raises struct.error, ValueError or LookupError if headers or tables are cut off.
    """
    headers = scanned_headers(file)
    counts = [count for header in headers if (count := _chunk_count(header)) is not None]
    if len(counts) < len(headers):
        return None  # reading the pixels reports the problem
    tables = [struct.unpack(f"<{count}Q", file.read(8 * count)) for count in counts]
    if min(min(offsets) for offsets in tables) < file.tell():
        return 0
    return max(
        _end_of(file, max(offsets), header, len(headers) > 1)
        for header, offsets in zip(headers, tables, strict=True)
    )


def _chunk_count(header: RawHeader) -> int | None:
    """Return the number of chunks in a part.

    None for levels of detail, and for compressions newer than this table.
    """
    if "chunkCount" in header:
        return int(struct.unpack("<i", header["chunkCount"])[0])
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    if "tiles" not in header:
        lines = _LINES_OF_CHUNK.get(header["compression"][0])
        return None if lines is None else _parts(y1 - y0 + 1, lines)
    width, height, mode = struct.unpack("<IIB", header["tiles"])
    return None if mode & 0xF else _parts(x1 - x0 + 1, width) * _parts(y1 - y0 + 1, height)


def _parts(length: int, each: int) -> int:
    return -(-length // each)


def _end_of(file: BinaryIO, offset: int, header: RawHeader, is_one_of_many: bool) -> int:
    """Return where the chunk at `offset` ends: its part and place, its sizes and its data."""
    kind = header.get("type", b"")
    is_tiled = "tiles" in header or b"tile" in kind
    file.seek(offset + 4 * is_one_of_many + (16 if is_tiled else 4))
    sizes = "<I" if not kind.startswith(b"deep") else _DEEP_SIZES
    packed: tuple[int, ...] = struct.unpack(sizes, file.read(struct.calcsize(sizes)))[:2]
    return file.tell() + sum(packed)


def cut_short(paths: Iterator[Path]) -> list[Path]:
    """Return the `paths` of empty files, and of EXR files that lack pixels; others are not read.

    A missing file is left out, because it is reported when it is read.
    """
    return [path for path in dict.fromkeys(paths) if path.is_file() and _is_cut(path)]


def _is_cut(path: Path) -> bool:
    if path.suffix.lower() != ".exr":
        return path.stat().st_size == 0
    return not is_whole_exr(path)
