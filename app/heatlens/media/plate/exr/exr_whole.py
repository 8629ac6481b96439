"""Tell whether an EXR file is whole, without reading its pixels.

A file that was cut short by a full disk, a broken copy or a power cut still has a valid header; its
tables of chunks tell what is missing. Source: OpenEXR, "File Layout".
"""

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from heatlens.core.base.paths import open_regular_file
from heatlens.media.plate.exr.exr_scan import RawHeader, scan_headers

# Lines in a chunk of each compression, by its number in the file.
_LINES_OF_CHUNK = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}
_DEEP_SIZES = "<3Q"  # bytes of the packed table, the packed samples and the unpacked samples


def is_whole_exr(path: Path) -> bool:
    """Return True if every chunk of every part of the file at `path` ends within the file."""
    try:
        with open_regular_file(path) as file:
            end = end_of_chunks(file)
            return end is None or 0 < end <= os.fstat(file.fileno()).st_size
    except (OSError, struct.error, ValueError, LookupError):  # the structure itself is cut off
        return False


def end_of_chunks(file: BinaryIO) -> int | None:
    """Return the offset at which the last chunk ends; 0 if a chunk is missing, None if unknown.

    Raises struct.error, ValueError or LookupError if headers or tables are cut off.
    """
    headers = scan_headers(file)
    counts = [count for header in headers if (count := _chunk_count(header)) is not None]
    if len(counts) < len(headers):
        return None  # reading the pixels reports the problem
    tables = [struct.unpack(f"<{count}Q", file.read(8 * count)) for count in counts]
    if min(min(offsets) for offsets in tables) < file.tell():
        return 0
    return max(
        _end_of_chunk(file, max(offsets), header, len(headers) > 1)
        for header, offsets in zip(headers, tables, strict=True)
    )


def _chunk_count(header: RawHeader) -> int | None:
    """Return the number of chunks in a part; None if it is unknown.

    It is unknown for levels of detail, and for compressions that _LINES_OF_CHUNK lacks.
    """
    if "chunkCount" in header:
        return int(struct.unpack("<i", header["chunkCount"])[0])
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    if "tiles" not in header:
        lines = _LINES_OF_CHUNK.get(header["compression"][0])
        return None if lines is None else _divide_rounding_up(y1 - y0 + 1, lines)
    width, height, mode = struct.unpack("<IIB", header["tiles"])
    return (
        None
        if mode & 0xF
        else _divide_rounding_up(x1 - x0 + 1, width) * _divide_rounding_up(y1 - y0 + 1, height)
    )


def _divide_rounding_up(length: int, size: int) -> int:
    """Return how many pieces of `size` cover `length`."""
    return -(-length // size)


def _end_of_chunk(file: BinaryIO, offset: int, header: RawHeader, has_part_number: bool) -> int:
    """Return the offset at which the chunk at `offset` ends.

    A chunk holds the number of its part if there are several, its coordinates, its sizes and its
    data.
    """
    part_type = header.get("type", b"")
    is_tiled = "tiles" in header or b"tile" in part_type
    file.seek(offset + 4 * has_part_number + (16 if is_tiled else 4))
    sizes = "<I" if not part_type.startswith(b"deep") else _DEEP_SIZES
    packed_sizes: tuple[int, ...] = struct.unpack(sizes, file.read(struct.calcsize(sizes)))[:2]
    return file.tell() + sum(packed_sizes)


def find_incomplete(paths: Iterator[Path]) -> list[Path]:
    """Return those of `paths` that are empty files, or EXR files that lack pixels.

    A missing file is left out, because it is reported when it is read.
    """
    return [path for path in dict.fromkeys(paths) if path.is_file() and _is_incomplete(path)]


def _is_incomplete(path: Path) -> bool:
    """Return True for an EXR file that lacks pixels, and for any other file that is empty."""
    if path.suffix.lower() != ".exr":
        return path.stat().st_size == 0
    return not is_whole_exr(path)
