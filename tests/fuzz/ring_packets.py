"""Datagrams of OpenTrackIO for the fuzzers: JSON and CBOR, whole and in segments.

A file is what one sender sent, one datagram after the other; each begins with "OTrk".
"""

import random
import re
import struct
from collections.abc import Iterable, Iterator
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
from mutate import mutated

from heatlens.core.base.errors import HeatlensError
from heatlens.media.live.ring.hearing import OpenTrackIODecoder, SampleCollector
from heatlens.media.live.ring.opentrackio import (
    HEADER_BYTES,
    IDENTIFIER,
    Encoding,
    RingPacketError,
    fletcher16,
    parse_segment,
    split_into_datagrams,
)
from heatlens.media.live.ring.sources import LensSample
from support.opentrackio_samples import COMPLETE, READ_AS, RECOMMENDED, encoded_sample

_LONG = RECOMMENDED | {"tracker": {"notes": "x" * 3000}}
_HUGE = 1 << 16_000  # more digits than Python writes; only CBOR can hold it
_NUMBERED = RECOMMENDED | {"sourceId": _HUGE, "sourceNumber": -_HUGE, "lens": {"fStop": _HUGE}}
_EARLIER_SAMPLE = READ_AS["complete"]  # what was heard before the damaged file


def packets(folder: Path) -> list[Path]:
    """Write small, complete and long samples in both encodings, huge numbers, and a stream."""
    files = {
        f"{name}-{encoding.name.lower()}": _datagrams(sample, encoding, 7)
        for name, sample in (("small", RECOMMENDED), ("complete", COMPLETE), ("long", _LONG))
        for encoding in Encoding
    }
    files["huge"] = _datagrams(_NUMBERED, Encoding.CBOR, 7)
    files["stream"] = b"".join(
        _datagrams(_LONG, encoding, 3 * number)
        for number, encoding in enumerate([*Encoding, *Encoding])
    )
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return [folder / name for name in files]


def received_values(path: Path) -> Iterable[np.ndarray]:
    """Take the datagrams as the receiver does, and check what the receiver promises of each.

    Every datagram is taken or refused; a refused one changes nothing; every value that is
    taken could be one of a lens.
    """
    collector = SampleCollector(OpenTrackIODecoder())
    collector.sources.add_sample(_EARLIER_SAMPLE)
    datagrams = list(_split_datagrams(path.read_bytes()))
    for number, datagram in enumerate(datagrams):
        state_before = (collector.sources.version, collector.sources.source_state().sample)
        refused_before = collector.refused
        collector.accept_datagram(datagram, ("stranger", 1))
        assert collector.accepted + collector.refused == number + 1, "a datagram is not counted"
        if collector.refused > refused_before:
            state_after = (collector.sources.version, collector.sources.source_state().sample)
            assert state_after == state_before, "a datagram that was refused has changed something"
    values = list(_sample_values(collector))
    if collector.refused:
        raise HeatlensError(str(collector.fault))
    return values


def with_checksums(data: bytes) -> bytes:
    """Correct the length and the checksum of damaged datagrams."""
    return b"".join(_with_checksum(datagram) for datagram in _split_datagrams(data))


def _datagrams(sample: object, encoding: Encoding, sequence: int) -> bytes:
    return b"".join(split_into_datagrams(encoded_sample(sample, encoding), encoding, sequence))


def _split_datagrams(data: bytes) -> Iterator[bytes]:
    yield from (part for part in re.split(b"(?=%b)" % IDENTIFIER, data) if part)


def _with_checksum(datagram: bytes) -> bytes:
    if len(datagram) < HEADER_BYTES:
        return datagram
    payload = datagram[HEADER_BYTES:][:0x7FFF]
    (last_length,) = struct.unpack_from("!H", datagram, 12)
    head = datagram[:12] + struct.pack("!H", last_length & 0x8000 | len(payload))
    return head + struct.pack("!H", fletcher16(head + payload)) + payload


def _sample_values(collector: SampleCollector) -> Iterator[np.ndarray]:
    for name in collector.sources.source_state().sources:
        sample = collector.sources.source_state(name).sample
        assert isinstance(sample, LensSample)
        offset_mm = sample.pupil_offset_mm or 0.0  # which may lie behind the film plane
        assert abs(offset_mm) <= 2000.0
        fields = astuple(replace(sample, pupil_offset_mm=None))
        values = [value for value in fields if isinstance(value, float)]
        assert all(value >= 0.0 for value in values)
        yield np.array([*values, offset_mm])


def hostile_datagrams(count: int, seed: int) -> Iterator[bytes]:
    """Yield datagrams that are no samples: damaged, cut, random, and of other protocols."""
    rng = random.Random(seed)
    good = _datagrams(RECOMMENDED, Encoding.JSON, 1)
    while count:
        noise = rng.randbytes(rng.randrange(200))
        datagram = rng.choice((mutated(good, rng), noise, IDENTIFIER + noise))[:60_000]
        try:
            parse_segment(datagram)
        except RingPacketError:
            count -= 1
            yield datagram
