"""Parse the headers of an EXR file from its bytes, before any library opens it.

A few flipped bits can make a header claim a million channels or tiles of gigabytes, for which a
library allocates memory before it looks at the pixels. Source: OpenEXR, "File Layout".
"""

import struct
from dataclasses import dataclass
from typing import BinaryIO

MAGIC = b"\x76\x2f\x31\x01"
_MANY_PARTS = 0x1000
_PARTS_MOST = 1000
_NAME_MOST = 256  # the format allows 255
_BYTES_MOST = 1 << 26  # bytes in all headers; Cryptomatte manifests are the largest entries
_TYPES = {0: "<u4", 1: "<f2", 2: "<f4"}  # pixel type number -> NumPy type

RawHeader = dict[str, bytes]


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
