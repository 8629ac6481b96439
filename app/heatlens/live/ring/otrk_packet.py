"""Read and write OpenTrackIO datagrams: a header of 16 bytes and a segment of a sample's text.

Source: SMPTE RIS OSVP, OpenTrackIO 1.0.1, "transport"; the reference parser is in the public
repository SMPTE/ris-osvp-metadata-camdkit. All numbers are in network order:

    4  "OTrk"        1  reserved         1  encoding
    2  sequence      4  segment offset   2  last segment (1 bit) and length (15 bits)
    2  checksum      n  segment
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from heatlens.base.errors import InputError

IDENTIFIER = b"OTrk"
HEADER_BYTES = 16
MAX_SEGMENT_BYTES = 1500 - HEADER_BYTES
MAX_SAMPLE_BYTES = 1 << 16  # a usual complete sample has about 3 kB
SEQUENCES = 1 << 16  # sequence numbers begin again after these
_HEADER = struct.Struct("!4sBBHIHH")
_BEFORE_CHECKSUM = HEADER_BYTES - 2
_LAST = 1 << 15


class RingPacketError(InputError):
    """A datagram is invalid; all of it was ignored."""


class Encoding(IntEnum):
    """How the text of a sample is encoded."""

    JSON = 1
    CBOR = 2


@dataclass(frozen=True)
class Segment:
    """A datagram: its bytes, their offset in the sample, and its sequence number."""

    encoding: Encoding
    sequence: int
    offset: int
    is_last: bool
    payload: bytes

    @property
    def end(self) -> int:
        """The offset of the next segment in the sample."""
        return self.offset + len(self.payload)


def fletcher16(data: bytes) -> int:
    """Return Fletcher's checksum of `data` modulo 256, the second sum in the high byte."""
    values = np.frombuffer(data, np.uint8).astype(np.int64)
    first = int(values.sum()) % 256
    second = int(values @ np.arange(len(values), 0, -1)) % 256
    return second << 8 | first


def segment_of(datagram: bytes) -> Segment:
    """Parse a datagram; raise RingPacketError if it is incomplete or inconsistent."""
    if len(datagram) < HEADER_BYTES or not datagram.startswith(IDENTIFIER):
        raise RingPacketError("a datagram is not OpenTrackIO")
    _, _, encoding, sequence, offset, last_length, checksum = _HEADER.unpack_from(datagram)
    payload = datagram[HEADER_BYTES:]
    if len(payload) != last_length & ~_LAST:
        raise RingPacketError("a datagram is not as long as its header says")
    if fletcher16(datagram[:_BEFORE_CHECKSUM] + payload) != checksum:
        raise RingPacketError("the checksum of a datagram is wrong")
    if encoding not in tuple(Encoding):
        raise RingPacketError(f"a sample has encoding {encoding}, which is neither JSON nor CBOR")
    if offset + len(payload) > MAX_SAMPLE_BYTES:
        raise RingPacketError(f"a sample is longer than {MAX_SAMPLE_BYTES} bytes")
    return Segment(Encoding(encoding), sequence, offset, bool(last_length & _LAST), payload)


def datagrams_of(payload: bytes, encoding: Encoding, sequence: int) -> Iterator[bytes]:
    """Divide the text of a sample into datagrams, numbered from `sequence`, modulo 65,536."""
    offsets = range(0, max(len(payload), 1), MAX_SEGMENT_BYTES)
    for number, offset in enumerate(offsets, sequence):
        part = payload[offset : offset + MAX_SEGMENT_BYTES]
        is_last = offset + len(part) >= len(payload)
        length = len(part) | (_LAST if is_last else 0)
        words = (IDENTIFIER, 0, encoding, number % SEQUENCES, offset, length)
        header = _HEADER.pack(*words, 0)[:_BEFORE_CHECKSUM]
        yield header + struct.pack("!H", fletcher16(header + part)) + part
