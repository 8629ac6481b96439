"""Parse and check the headers of an EXR file from its bytes, before any library opens it.

A few flipped bits can make a header claim a million channels or tiles of gigabytes, for which a
library allocates memory before it looks at the pixels. Source: OpenEXR, "File Layout".
"""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import open_regular_file, unreadable_error
from heatlens.media.files.foreign_formats import describe_other_format

MAGIC = b"\x76\x2f\x31\x01"
_MULTI_PART_FLAG = 0x1000
_PARTS_MOST = 1000
_NAME_MOST = 256  # the format allows 255
_BYTES_MOST = 1 << 26  # bytes in all headers; Cryptomatte manifests are the largest entries
_TYPES = {0: "<u4", 1: "<f2", 2: "<f4"}  # pixel type number -> NumPy type
# No GPU takes a larger texture; a damaged header can claim any size.
MAX_SIDE_PX = 16384
MAX_CHANNELS = 4096  # channels in all parts; the library takes minutes for many more
MAX_BYTES = 16_000_000_000  # memory of all pixels
_TILE_LEAST_PX = 4096  # even small pictures may be stored in tiles of the usual sizes
_DEEP_PIXEL_BYTES = 32  # for a pixel without samples: its count, color and depth
# The greatest ratio of unpacked to packed bytes of each compression, by its number in the file:
# measured on black pictures, with a tenth or more added. Compressions that are not listed have no
# such bound.
_COMPRESSION_RATIO_MOST = {0: 1, 1: 70, 2: 1100, 3: 1100, 4: 1100, 5: 1500, 6: 4, 7: 16}

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


def scan_attributes(file: BinaryIO) -> Iterator[tuple[int, int, str, int]]:
    """Yield the offsets of each attribute of all parts: (start, type start, type, end).

    Offsets are in bytes from the start of the file. Raises CutError if the headers are incomplete.
    """
    file.seek(4)
    (flags,) = _read_numbers(file, "<I")
    is_in_part = True
    while True:
        start = file.tell()
        # An empty name ends a part; in a file of several parts, a second one ends the headers.
        if not _read_name(file):
            if not flags & _MULTI_PART_FLAG or not is_in_part:
                return
            is_in_part = False
            continue
        is_in_part, type_start = True, file.tell()
        type_name = _read_name(file)
        (length,) = _read_numbers(file, "<I")
        yield start, type_start, type_name, file.seek(length, 1)


def scan_headers(file: BinaryIO) -> list[RawHeader]:
    """Return the raw attributes of each part by name.

    The file's position is then at the end of the headers. Raises CutError if they are incomplete.
    """
    if file.read(4) != MAGIC:
        raise CutError("not an EXR file")
    (flags,) = _read_numbers(file, "<I")
    if not flags & _MULTI_PART_FLAG:
        return [_read_header(file)]
    headers = []
    while header := _read_header(file):
        headers.append(header)
        if len(headers) > _PARTS_MOST:
            raise CutError(f"there are more than {_PARTS_MOST} parts")
    return headers


def parse_channels(header: RawHeader) -> list[RawChannel]:
    """Return the channels of one part. Raises CutError if the list is incomplete."""
    encoded, name_start, channels = header.get("channels", b""), 0, []
    while name_start < len(encoded) and encoded[name_start]:
        name_end = encoded.find(b"\0", name_start)
        if name_end < 0 or name_end + 17 > len(encoded):
            raise CutError("the list of channels is cut off")
        type_number, _, x, y = struct.unpack_from("<i4sii", encoded, name_end + 1)
        if type_number not in _TYPES:
            raise CutError("a channel has an unknown type")
        channels.append(
            RawChannel(encoded[name_start:name_end], _TYPES[type_number], max(x, 1), max(y, 1))
        )
        name_start = name_end + 17
    return channels


def _read_header(file: BinaryIO) -> RawHeader:
    """Read the attributes of one part, up to the empty name that ends them. Raises CutError."""
    header = {}
    while name := _read_name(file):
        if "\\x" in _read_name(
            file
        ):  # OpenEXR for Python cannot tell such a type, nor print its value
            raise CutError(f"the type of the attribute {name[:40]!r} is not UTF-8")
        (length,) = _read_numbers(file, "<I")
        value = file.read(length) if file.tell() + length <= _BYTES_MOST else b""
        if len(value) != length:
            raise CutError(f"the attribute {name[:40]!r} is cut off")
        header[name] = value
    return header


def _read_name(file: BinaryIO) -> str:
    """Read a name that ends with a zero byte; bytes that are not UTF-8 become escapes."""
    start = file.tell()
    letters, terminator, _ = file.read(_NAME_MOST + 1).partition(b"\0")
    if not terminator:
        raise CutError("a name in it does not end")
    file.seek(start + len(letters) + 1)
    return letters.decode("utf-8", "backslashreplace")


def _read_numbers(file: BinaryIO, layout: str) -> tuple[int, ...]:
    """Read numbers of the `struct` layout. Raises CutError at the end of the file."""
    data = file.read(struct.calcsize(layout))
    if len(data) < struct.calcsize(layout):
        raise CutError("it ends in the middle of a number")
    return struct.unpack(layout, data)


def check_exr(path: Path) -> None:
    """Raise InputError for a file that is not an EXR, or whose header claims an impossible size.

    The error names the file, what was found and the limit.
    """
    if not os.path.isfile(path):  # opening a pipe would wait for its writer
        raise unreadable_error(path)
    try:
        with open_regular_file(path) as file:
            _check_magic(path, file.read(len(MAGIC)))
            file.seek(0)
            headers, size = scan_headers(file), os.fstat(file.fileno()).st_size
        _check_headers(path, headers, size)
    except OSError as error:
        raise unreadable_error(path, error) from error
    except (CutError, struct.error, LookupError) as error:
        raise InputError(
            f"{path} is damaged or cut short: its header is not whole ({error}). Write it again."
        ) from error


def _check_magic(path: Path, magic: bytes) -> None:
    """Raise InputError if these first bytes of a file are not those of an EXR."""
    if magic != MAGIC and (other_format := describe_other_format(path)):
        raise InputError(f"{path} is {other_format}.")
    if magic != MAGIC:
        problem = "is empty" if not magic else "is not an OpenEXR file"
        raise InputError(
            f"{path} {problem}. heatlens reads EXR files and, by their file extensions, PNG, JPEG, "
            "TIFF and others."
        )


def _check_headers(path: Path, headers: list[RawHeader], file_bytes: int) -> None:
    """Raise InputError for too many channels, too many pixels, or values that cannot be true."""
    count = sum(len(parse_channels(header)) for header in headers)
    if count > MAX_CHANNELS:
        raise InputError(f"{path} has {count:,} channels; heatlens takes {MAX_CHANNELS:,}.")
    for header in headers:
        _check_names(path, header)
        _check_tiles(path, header)
        _check_claimed_size(path, header, file_bytes)
    claimed_bytes = sum(_pixel_bytes(path, header) for header in headers)
    if claimed_bytes > MAX_BYTES:
        raise InputError(
            f"{path} claims {claimed_bytes / 1e9:.1f} GB of pixels; heatlens takes "
            f"{MAX_BYTES / 1e9:.1f} GB. Write fewer channels, or a smaller picture."
        )


def _check_names(path: Path, header: RawHeader) -> None:
    """Raise InputError if the name of the part, of its view or of a channel is not UTF-8."""
    names = [channel.name for channel in parse_channels(header)]
    for name in (*names, header.get("name", b""), header.get("view", b"")):
        try:
            name.decode("utf-8")
        except UnicodeDecodeError:
            raise InputError(
                f"{path} holds a name that is not UTF-8, {name[:40]!r}: it is damaged, or was "
                "written in another encoding. Write it again with other names."
            ) from None


def _data_window_size(path: Path, header: RawHeader) -> tuple[int, int]:
    """Return width and height of the data window in pixels."""
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    check_sides(f"{path} has a data window of", width, height)
    return width, height


def check_sides(label: str, width: int, height: int) -> None:
    """Raise InputError, beginning with `label`, for a picture that is empty or too large for a GPU.

    Width and height are in pixels.
    """
    if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
        raise InputError(
            f"{label} {width} x {height} pixels; heatlens takes 1 to {MAX_SIDE_PX} a side."
        )


def _check_tiles(path: Path, header: RawHeader) -> None:
    """Raise InputError for huge tiles, because the library keeps whole tiles in memory.

    It does so even for tiles that reach outside the picture.
    """
    if "tiles" not in header:
        return
    width, height = struct.unpack_from("<II", header["tiles"])
    largest = tuple(max(side, _TILE_LEAST_PX) for side in _data_window_size(path, header))
    if not (0 < width <= largest[0] and 0 < height <= largest[1]):
        raise InputError(
            f"{path} claims tiles of {width} x {height} pixels; for a picture of this size, "
            f"heatlens takes up to {largest[0]} x {largest[1]}. The file is damaged: write it "
            "again."
        )


def _pixel_bytes(path: Path, header: RawHeader) -> int:
    """Return how many bytes the pixels of a part take in memory."""
    width, height = _data_window_size(path, header)
    channels = parse_channels(header)
    if header.get("type", b"").startswith(b"deep"):
        return width * height * _DEEP_PIXEL_BYTES
    return sum(
        (width // channel.x_sampling) * (height // channel.y_sampling) * channel.bytes_each
        for channel in channels
    )


def _check_claimed_size(path: Path, header: RawHeader, file_bytes: int) -> None:
    """Raise InputError for a file that is too short for the size that its header claims."""
    greatest_ratio = _COMPRESSION_RATIO_MOST.get(header["compression"][0])
    if greatest_ratio is None or header.get("type", b"").startswith(b"deep"):
        return
    claimed_bytes = _pixel_bytes(path, header)
    if claimed_bytes > file_bytes * greatest_ratio:
        raise InputError(
            f"{path} is damaged or cut short: its {file_bytes:,} bytes cannot hold the "
            f"{claimed_bytes:,} of "
            "its pixels, however they are compressed. Write it again."
        )
