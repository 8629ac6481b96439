"""Read and write the lens and the timecode of OpenTrackIO samples.

Source: SMPTE RIS OSVP, OpenTrackIO 1.0.1. The sample is JSON, or CBOR (RFC 8949) with the same
names; `lens` holds `focusDistance` in meters, `pinholeFocalLength` in millimeters, `fStop`,
`tStop`, and `encoders` from 0 to 1. Samples and their sources are named by `urn:uuid:...`.

A datagram is a header of 16 bytes and a segment of a sample's text ("transport"; the reference
parser is in the public repository SMPTE/ris-osvp-metadata-camdkit), all numbers in network order:

    4  "OTrk"        1  reserved         1  encoding
    2  sequence      4  segment offset   2  last segment (1 bit) and length (15 bits)
    2  checksum      n  segment
"""

import json
import math
import re
import socket
import struct
import uuid
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from heatlens.core.base.errors import InputError, MissingPackageError
from heatlens.core.base.extras import import_extra
from heatlens.core.model.curves.frames import exact_rate
from heatlens.core.model.option import Values
from heatlens.core.model.timecode import Timecode
from heatlens.media.live.ring.sources import LensSample

_VERSION = [1, 0, 1]
_LENS_KEYS = {
    "focus_distance_m": "focusDistance",
    "f_stop": "fStop",
    "t_stop": "tStop",
    "focal_length_mm": "pinholeFocalLength",
}
_ENCODER_KEYS = {"focus_turn": "focus", "iris_turn": "iris", "zoom_turn": "zoom"}
_TIME = ("hours", "minutes", "seconds", "frames")
_NAME_LETTERS = 80
_NUMBER_MOST = 2**63  # larger than any source number; CBOR has numbers of any length
_RATE_MOST = 10_000.0  # samples per second
_ID = re.compile("urn:uuid:[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
_OFFSET_MOST_M = 2.0  # largest offset of the entrance pupil, to either side
_POSITIVE_LEAST = math.ulp(0.0)  # smallest allowed number above 0

IDENTIFIER = b"OTrk"
HEADER_BYTES = 16
MAX_SEGMENT_BYTES = 1500 - HEADER_BYTES
MAX_SAMPLE_BYTES = 1 << 16  # a usual complete sample has about 3 kB
SEQUENCES = 1 << 16  # sequence numbers begin again after these
_HEADER = struct.Struct("!4sBBHIHH")
_BEFORE_CHECKSUM = HEADER_BYTES - 2
_LAST_SEGMENT_BIT = 1 << 15


class RingPacketError(InputError):
    """A datagram is invalid; all of it was ignored."""


class Encoding(IntEnum):
    """How the text of a sample is encoded."""

    JSON = 1
    CBOR = 2


@dataclass(frozen=True)
class Segment:
    """A datagram: a segment of a sample's text, its offset there, and its sequence number."""

    encoding: Encoding
    sequence: int
    offset: int
    is_last: bool
    payload: bytes

    @property
    def end(self) -> int:
        """The offset of the next segment in the sample."""
        return self.offset + len(self.payload)


# The second sum is a weighted sum of all bytes. Both are therefore one expression over an array,
# instead of a loop over up to 1,500 bytes for every datagram.
def fletcher16(data: bytes) -> int:
    """Return Fletcher's checksum of `data` modulo 256, the second sum in the high byte."""
    values = np.frombuffer(data, np.uint8).astype(np.int64)
    sum_of_bytes = int(values.sum()) % 256
    sum_of_sums = int(values @ np.arange(len(values), 0, -1)) % 256
    return sum_of_sums << 8 | sum_of_bytes


def parse_segment(datagram: bytes) -> Segment:
    """Parse a datagram; raise RingPacketError if it is incomplete or inconsistent."""
    if len(datagram) < HEADER_BYTES or not datagram.startswith(IDENTIFIER):
        raise RingPacketError("a datagram is not OpenTrackIO")
    _, _, encoding, sequence, offset, last_length, checksum = _HEADER.unpack_from(datagram)
    payload = datagram[HEADER_BYTES:]
    if len(payload) != last_length & ~_LAST_SEGMENT_BIT:
        raise RingPacketError("a datagram is not as long as its header says")
    if fletcher16(datagram[:_BEFORE_CHECKSUM] + payload) != checksum:
        raise RingPacketError("the checksum of a datagram is wrong")
    if encoding not in tuple(Encoding):
        raise RingPacketError(f"a sample has encoding {encoding}: only JSON and CBOR are read")
    if offset + len(payload) > MAX_SAMPLE_BYTES:
        raise RingPacketError(f"a sample is longer than {MAX_SAMPLE_BYTES} bytes")
    return Segment(
        Encoding(encoding), sequence, offset, bool(last_length & _LAST_SEGMENT_BIT), payload
    )


def split_into_datagrams(payload: bytes, encoding: Encoding, sequence: int) -> Iterator[bytes]:
    """Divide the text of a sample into datagrams, numbered from `sequence`, modulo 65,536."""
    offsets = range(0, max(len(payload), 1), MAX_SEGMENT_BYTES)
    for number, offset in enumerate(offsets, sequence):
        segment = payload[offset : offset + MAX_SEGMENT_BYTES]
        is_last = offset + len(segment) >= len(payload)
        length = len(segment) | (_LAST_SEGMENT_BIT if is_last else 0)
        header_fields = (IDENTIFIER, 0, encoding, number % SEQUENCES, offset, length)
        header = _HEADER.pack(*header_fields, 0)[:_BEFORE_CHECKSUM]
        yield header + struct.pack("!H", fletcher16(header + segment)) + segment


def parse_sample(text: bytes, encoding: Encoding) -> LensSample:
    """Read a sample; impossible values are left out.

    Raise RingPacketError for a text that is not a sample.
    """
    root = _decode(text, encoding)
    if not isinstance(root, dict):
        raise RingPacketError("a sample has no names, so it is not OpenTrackIO")
    lens = _member_object(root, "lens")
    values: Values = {name: _number(lens, key, _POSITIVE_LEAST) for name, key in _LENS_KEYS.items()}
    encoders = _member_object(lens, "encoders")
    values |= {name: _number(encoders, key, 0.0, 1.0) for name, key in _ENCODER_KEYS.items()}
    offset_m = _number(lens, "entrancePupilOffset", -_OFFSET_MOST_M, _OFFSET_MOST_M)
    values["pupil_offset_mm"] = None if offset_m is None else 1e3 * offset_m
    values |= {"timecode": _parse_timecode(root), "frames_per_second": _parse_rate(root)}
    return LensSample(_source_name(root), **values)


def source_id(name: str) -> str:
    """Return the identifier of the source called `name` on this machine.

    A name that is an identifier already is returned unchanged.
    """
    if _ID.fullmatch(name):
        return name
    return uuid.uuid5(uuid.NAMESPACE_URL, f"heatlens:{socket.gethostname()}:{name}").urn


def format_sample(sample: LensSample, encoding: Encoding, source_number: int = 1) -> bytes:
    """Write a sample with the values that it has."""
    lens: Values = {
        key: getattr(sample, name) for name, key in _LENS_KEYS.items() if _is_known(sample, name)
    }
    if _is_known(sample, "pupil_offset_mm"):
        lens["entrancePupilOffset"] = 1e-3 * float(sample.pupil_offset_mm or 0.0)
    encoders = {
        key: getattr(sample, name) for name, key in _ENCODER_KEYS.items() if _is_known(sample, name)
    }
    root: dict[str, object] = {"protocol": {"name": "OpenTrackIO", "version": _VERSION}}
    root |= {"sampleId": uuid.uuid4().urn, "sourceId": source_id(sample.source)}
    root |= {"sourceNumber": source_number, "timing": _timing(sample)}
    root["lens"] = lens | ({"encoders": encoders} if encoders else {})
    return _encode(root, encoding)


def _timing(sample: LensSample) -> dict[str, object]:
    """Return the entry `timing`: the rate and the timecode, which needs a rate."""
    if sample.frames_per_second is None:
        return {}
    exact_frame_rate, timecode = exact_rate(sample.frames_per_second), sample.timecode
    rate = {"num": exact_frame_rate.numerator, "denom": exact_frame_rate.denominator}
    if timecode is None:
        return {"sampleRate": rate}
    time = {name: getattr(timecode, name) for name in _TIME} | {"frameRate": rate}
    return {"sampleRate": rate, "timecode": time | ({"dropFrame": True} if timecode.drop else {})}


def _is_known(sample: LensSample, name: str) -> bool:
    """Return True if the value is present and finite; JSON has no infinity."""
    value = getattr(sample, name)
    return value is not None and math.isfinite(value)


def _decode(text: bytes, encoding: Encoding) -> object:
    """Decode an untrusted text of at most 64 kB; every failure is a RingPacketError."""
    decode, errors = _decoder(encoding)
    try:
        return decode(text)
    except errors as error:
        raise RingPacketError(f"a sample cannot be decoded as {encoding.name}") from error


def _decoder(encoding: Encoding) -> tuple[Callable[[bytes], object], tuple[type[Exception], ...]]:
    """Return the decoding function, and the errors that it raises for a damaged text."""
    errors = (ValueError, RecursionError, OverflowError, TypeError)
    if encoding is Encoding.JSON:
        return json.loads, errors
    try:
        cbor2 = import_extra("cbor2", "A sample in CBOR")
    except MissingPackageError as error:
        raise RingPacketError(str(error)) from error
    return cbor2.loads, (*errors, cbor2.CBORError)


def _encode(root: Mapping[str, object], encoding: Encoding) -> bytes:
    """Return the text of a sample in JSON or CBOR."""
    if encoding is Encoding.JSON:
        return json.dumps(root, separators=(",", ":")).encode()
    import cbor2

    return cbor2.dumps(root)


def _member_object(parent: Mapping[str, object], key: str) -> Mapping[str, Any]:
    """Return the object that is the member `key` of another; an empty one if it is missing."""
    member = parent.get(key)
    return member if isinstance(member, dict) else {}


def _number(parent: Mapping[str, Any], key: str, least: float, most: float = 1e9) -> float | None:
    """Return the number called `key` if it is in [least, most]; else None."""
    number = parent.get(key)
    if isinstance(number, bool) or not isinstance(number, (int, float)):
        return None
    return float(number) if least <= number <= most else None


def _source_name(root: Mapping[str, object]) -> str:
    """Return the name of the sender, shortened to fit on a line; "" without one."""
    for key in ("sourceId", "sourceNumber"):
        name = root.get(key)
        is_number = type(name) is int and abs(name) < _NUMBER_MOST
        if isinstance(name, str) or is_number:
            return str(name)[:_NAME_LETTERS]
    return ""


def _parse_rate(root: Mapping[str, object]) -> float | None:
    """Return the number of samples per second; None if it is missing or impossible."""
    rate = _member_object(_member_object(root, "timing"), "sampleRate")
    numerator = _number(rate, "num", _POSITIVE_LEAST)
    denominator = _number(rate, "denom", _POSITIVE_LEAST)
    hertz = None if numerator is None or denominator is None else numerator / denominator
    return hertz if hertz is not None and hertz <= _RATE_MOST else None


def _parse_timecode(root: Mapping[str, object]) -> Timecode | None:
    """Return the timecode of a sample; None if it is missing or impossible."""
    fields = _member_object(_member_object(root, "timing"), "timecode")
    hours, minutes, seconds, frames = (fields.get(name, -1) for name in _TIME)
    if not all(type(number) is int for number in (hours, minutes, seconds, frames)):
        return None
    timecode = Timecode(hours, minutes, seconds, frames, fields.get("dropFrame") is True)
    return timecode if timecode.is_possible else None
