"""Check that an exported file is complete, by its structure and without reading its pixels.

A file that was cut short by a full disk, a broken copy or a power cut still has a valid header.
Each of these formats contains the length that the file must have.

Sources: W3C, PNG specification, section 5; ISO/IEC 10918-1, annex B;
Adobe, TIFF revision 6.0, section 2; ISO/IEC 14496-12, section 4.2.
"""

import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from heatlens.plate.exr.exr_scan import end_of_chunks

_JPEG_END = b"\xff\xd9"
_BYTES_OF_TIFF = (0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8)  # bytes of a value, by type number
_STRIP_OFFSETS, _STRIP_LENGTHS = 273, 279


def is_whole(path: Path, suffix: str = "") -> bool:
    """Return whether a file is as long as its own structure says.

    `suffix`, such as .exr, gives its kind if its name does not.
    """
    check = _CHECKS[(suffix or path.suffix).lower()]
    try:
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            return size > 0 and check(file, size)
    except (OSError, struct.error, ValueError, LookupError):  # the structure itself is cut off
        return False


def _is_whole_png(file: BinaryIO, size: int) -> bool:
    """Return True if the chunks lead to IEND as the last one."""
    end, kind = 8, b""
    while end < size and kind != b"IEND":
        file.seek(end)
        length, kind = struct.unpack(">I4s", file.read(8))
        end += 12 + length
    return kind == b"IEND" and end == size


def _is_whole_jpeg(file: BinaryIO, size: int) -> bool:
    file.seek(size - len(_JPEG_END))
    return file.read() == _JPEG_END


def _is_whole_tiff(file: BinaryIO, size: int) -> bool:
    """Return True if the file contains all of its directory, its values and its pixel strips."""
    order = {b"II*\0": "<", b"MM\0*": ">"}[file.read(4)]
    (start,) = struct.unpack(f"{order}I", file.read(4))
    file.seek(start)
    (count,) = struct.unpack(f"{order}H", file.read(2))
    entries = [struct.unpack(f"{order}HHI4s", file.read(12)) for _ in range(count)]
    ends, found = [start + 2 + 12 * count + 4], {}
    for tag, kind, number, data in entries:
        length = _BYTES_OF_TIFF[kind] * number
        if length > 4:
            (at,) = struct.unpack(f"{order}I", data)
            ends.append(at + length)
            file.seek(at)
            data = file.read(length)
        if tag in (_STRIP_OFFSETS, _STRIP_LENGTHS):
            found[tag] = struct.unpack(f"{order}{number}{'H' if kind == 3 else 'I'}", data[:length])
    strips = zip(found[_STRIP_OFFSETS], found[_STRIP_LENGTHS], strict=True)
    ends += [offset + length for offset, length in strips]
    return bool(max(ends) == size)


def _is_whole_movie(file: BinaryIO, size: int) -> bool:
    """Return True if the boxes of QuickTime or MP4 reach to the end, and one holds the pictures."""
    end, kinds = 0, set()
    while end < size:
        file.seek(end)
        length, kind = struct.unpack(">I4s", file.read(8))
        head = 8
        if length == 1:  # the length has 64 bits, after the kind
            (length,), head = struct.unpack(">Q", file.read(8)), 16
        if length < head:
            return False
        kinds.add(kind)
        end += length
    return end == size and {b"moov", b"mdat"} <= kinds


_CHECKS: dict[str, Callable[[BinaryIO, int], bool]] = {
    ".exr": lambda file, size: end_of_chunks(file) == size,
    ".png": _is_whole_png,
    ".jpg": _is_whole_jpeg,
    ".jpeg": _is_whole_jpeg,
    ".tif": _is_whole_tiff,
    ".tiff": _is_whole_tiff,
    ".mov": _is_whole_movie,
    ".mp4": _is_whole_movie,
}
