"""Parse the network protocol of the image viewer tev from bytes into messages.

A packet consists of its length in bytes (uint32, which counts itself), the number of an operation
(a byte) and the arguments of the operation: little-endian integers, strings that end in a zero byte
and float32 pixels. Renderers use it to show a picture while it is rendered. Source: README.md of
tev, "Over the Network", and its Python client, tevclient.
"""

import struct
from dataclasses import dataclass

import numpy as np

from heatlens.media.plate.exr.exr_scan import MAX_SIDE_PX
from heatlens.media.plate.plate import FloatImage

# The text of an HTTP request reads as a greater length, and ends the connection.
MAX_PACKET_BYTES = 1 << 28
MAX_NAME_BYTES = 1024
MAX_CHANNELS = 64

_LENGTH_BYTES = 4  # size of the length of a packet, which counts itself
_OPEN, _RELOAD, _CLOSE, _UPDATE, _CREATE, _UPDATE_2, _UPDATE_3, _OPEN_2, _GRAPHICS = range(9)


class TevStreamError(Exception):
    """The start of the next packet cannot be found, so the connection is unusable."""


class TevPacketError(Exception):
    """A packet is invalid; later ones may be valid."""


@dataclass(frozen=True)
class CreateImage:
    """Create a blank image; it replaces one of the same name."""

    name: str
    width: int
    height: int
    channels: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class UpdateImage:
    """Set a rectangle of values: `tiles[channel]` is (H, W) float32, a view into the packet."""

    name: str
    x: int
    y: int
    tiles: dict[str, FloatImage]


@dataclass(frozen=True)
class CloseImage:
    """Forget an image."""

    name: str


@dataclass(frozen=True)
class ReadFile:
    """Open, or read again, a file on the disk of the listener."""

    name: str


@dataclass(frozen=True)
class Graphics:
    """Draw lines over an image; plates ignore this."""


Message = CreateImage | UpdateImage | CloseImage | ReadFile | Graphics


class PacketStream:
    """Cuts the bytes of one connection into packets; holds at most one unfinished packet."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._length = _LENGTH_BYTES  # bytes expected next: the length, then the whole packet

    @property
    def buffered_bytes(self) -> int:
        """Number of bytes of an unfinished packet that are in memory."""
        return len(self._bytes)

    @property
    def expected_bytes(self) -> int:
        """The most bytes that the next `feed` accepts, at least 1."""
        return self._length - len(self._bytes)

    def feed(self, chunk: bytes) -> bytearray | None:
        """Add the next bytes; return the packet without its length once it is complete, else None.

        Raises TevStreamError for a length after which no packet can be found.
        """
        self._bytes += chunk
        if self._length == _LENGTH_BYTES == len(self._bytes):
            self._length = self._check_length(*struct.unpack("<I", self._bytes))
        if self.expected_bytes > 0:
            return None
        packet, self._bytes, self._length = self._bytes, bytearray(), _LENGTH_BYTES
        del packet[:_LENGTH_BYTES]
        return packet

    def _check_length(self, length: int) -> int:
        """Return the length of a packet; raise TevStreamError if it is impossible or too large."""
        if _LENGTH_BYTES <= length <= MAX_PACKET_BYTES:
            return length
        raise TevStreamError(
            f"it says that it has {length} bytes, but {_LENGTH_BYTES} to {MAX_PACKET_BYTES} are "
            "accepted; send a large picture in tiles"
        )


def parse_message(packet: bytes | bytearray) -> Message:
    """Parse `packet`, without its length. Raises TevPacketError for an invalid one."""
    fields = _Fields(packet)
    operation = fields.byte()
    if operation in (_OPEN, _OPEN_2, _RELOAD):
        _skip_flag(fields)
        return ReadFile(fields.text())
    if operation == _CLOSE:
        return CloseImage(fields.text())
    if operation == _CREATE:
        return _create_image(fields)
    if operation in (_UPDATE, _UPDATE_2, _UPDATE_3):
        return _update_image(fields, operation)
    if operation == _GRAPHICS:
        return Graphics()
    raise TevPacketError(f"it has an operation {operation}, which the protocol of tev lacks")


class _Fields:
    """Reads the fields of a packet in order; raises TevPacketError past its end."""

    def __init__(self, packet: bytes | bytearray) -> None:
        self._packet = packet
        self._offset = 0

    def byte(self) -> int:
        return self._numbers("B", 1)[0]

    def int32s(self, count: int) -> tuple[int, ...]:
        return self._numbers("i", count)

    def int64s(self, count: int) -> tuple[int, ...]:
        return self._numbers("q", count)

    def text(self) -> str:
        """Read on to the next zero byte, and return the string before it. Raises TevPacketError."""
        end = self._packet.find(b"\0", self._offset, self._offset + MAX_NAME_BYTES + 1)
        if end < 0:
            raise TevPacketError(f"a name does not end within {MAX_NAME_BYTES} bytes")
        raw, self._offset = bytes(self._packet[self._offset : end]), end + 1
        try:
            return raw.decode()
        except UnicodeDecodeError as error:
            raise TevPacketError(f"the name {raw[:40]!r} is not UTF-8") from error

    def channels(self, count: int) -> tuple[str, ...]:
        """Return `count` different names of channels. Raises TevPacketError."""
        if not 1 <= count <= MAX_CHANNELS:
            raise TevPacketError(f"it has {count} channels; 1 to {MAX_CHANNELS} are accepted")
        names = tuple(self.text() for _ in range(count))
        if len(set(names)) < count or "" in names:
            raise TevPacketError("two of its channels share a name, or one has none")
        return names

    def floats(self) -> FloatImage:
        """Return the rest of the packet as floats, without a copy."""
        count = (len(self._packet) - self._offset) // 4
        if count == 0:
            return np.empty(0, np.float32)
        return np.frombuffer(self._packet, "<f4", count, self._offset)

    def _numbers(self, type_code: str, count: int) -> tuple[int, ...]:
        """Read `count` numbers of the type that `struct` gives this code. Raises TevPacketError."""
        layout = struct.Struct(f"<{count}{type_code}")
        if self._offset + layout.size > len(self._packet):
            raise TevPacketError("it ends too early")
        numbers: tuple[int, ...] = layout.unpack_from(self._packet, self._offset)
        self._offset += layout.size
        return numbers


def _skip_flag(fields: _Fields) -> None:
    """Skip the byte that asks the viewer to bring the image to the front, which plates ignore."""
    fields.byte()


def _create_image(fields: _Fields) -> CreateImage:
    """Parse the creation of an image; raise TevPacketError if it is invalid."""
    _skip_flag(fields)
    name = fields.text()
    width, height, count = fields.int32s(3)
    _check_size(name, width, height)
    return CreateImage(name, width, height, fields.channels(count))


def _update_image(fields: _Fields, operation: int) -> UpdateImage:
    """Parse an update of pixels in one of its three versions.

    The first version has one channel; the second has several planes, one after the other; the third
    gives an offset and a stride for each channel, both counted in values.
    """
    _skip_flag(fields)
    name = fields.text()
    channels = fields.channels(1 if operation == _UPDATE else fields.int32s(1)[0])
    x, y, width, height = fields.int32s(4)
    _check_size(name, width, height)
    count = len(channels)
    offsets = tuple(index * width * height for index in range(count))
    strides = (1,) * count
    if operation == _UPDATE_3:
        offsets, strides = fields.int64s(count), fields.int64s(count)
    values = fields.floats()
    tiles = {
        channel: _tile(values, offset, stride, width, height)
        for channel, offset, stride in zip(channels, offsets, strides, strict=True)
    }
    return UpdateImage(name, x, y, tiles)


def _check_size(name: str, width: int, height: int) -> None:
    """Raise TevPacketError for an empty picture, or one that is too large for a GPU."""
    if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
        raise TevPacketError(
            f"{name[:40]!r} has {width} x {height} pixels; 1 to {MAX_SIDE_PX} a side are accepted"
        )


def _tile(values: FloatImage, offset: int, stride: int, width: int, height: int) -> FloatImage:
    """Return every `stride`-th of `values` from `offset` on as (height, width), without a copy."""
    last = offset + (width * height - 1) * stride
    if offset < 0 or stride < 1 or last >= values.size:
        raise TevPacketError(
            f"it has {values.size} values, too few for {width} x {height} pixels from value "
            f"{offset} on with a step of {stride}"
        )
    return values[offset : last + 1 : stride].reshape(height, width)
