"""Check whether picture files are complete or cut short, without reading their pixels.

Each of these formats contains the length that a file must have, or ends with a mark.

Sources: W3C, PNG specification, section 5; ISO/IEC 10918-1, annex B; Adobe, TIFF revision 6.0,
section 2; Google, WebP Container Specification, WebP File Header.
"""

import struct
from typing import BinaryIO

_JPEG_END = b"\xff\xd9"
_BYTES_OF_TIFF = (0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8)  # bytes of a value, by type number
_STRIP_OFFSETS, _STRIP_LENGTHS = 273, 279  # tags of TIFF


def is_complete_png(file: BinaryIO, size: int) -> bool:
    """Return True if the chunks lead to IEND as the last one."""
    end, kind = 8, b""
    while end < size and kind != b"IEND":
        file.seek(end)
        length, kind = struct.unpack(">I4s", file.read(8))
        end += 12 + length
    return kind == b"IEND" and end == size


def is_complete_jpeg(file: BinaryIO, size: int) -> bool:
    """Return True if the file ends with the marker for the end of an image."""
    file.seek(size - len(_JPEG_END))
    return file.read() == _JPEG_END


def is_complete_tiff(file: BinaryIO, size: int) -> bool:
    """Return True if the file contains all of its directory, its values and its pixel strips."""
    order = {b"II*\0": "<", b"MM\0*": ">"}[file.read(4)]
    (start,) = struct.unpack(f"{order}I", file.read(4))
    file.seek(start)
    (count,) = struct.unpack(f"{order}H", file.read(2))
    entries = [struct.unpack(f"{order}HHI4s", file.read(12)) for _ in range(count)]
    ends, tags = [start + 2 + 12 * count + 4], {}
    for tag, value_type, value_count, data in entries:
        length = _BYTES_OF_TIFF[value_type] * value_count
        if length > 4:
            (value_offset,) = struct.unpack(f"{order}I", data)
            ends.append(value_offset + length)
            file.seek(value_offset)
            data = file.read(length)
        if tag in (_STRIP_OFFSETS, _STRIP_LENGTHS):
            tags[tag] = struct.unpack(
                f"{order}{value_count}{'H' if value_type == 3 else 'I'}", data[:length]
            )
    strips = zip(tags[_STRIP_OFFSETS], tags[_STRIP_LENGTHS], strict=True)
    ends += [offset + length for offset, length in strips]
    return bool(max(ends) == size)


def is_complete_webp(file: BinaryIO, size: int) -> bool:
    """Return True if the file has the length in its first chunk, which contains all others."""
    riff, length, kind = struct.unpack("<4sI4s", file.read(12))
    return (riff, kind) == (b"RIFF", b"WEBP") and length + 8 == size
