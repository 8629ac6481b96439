"""Turn untrusted datagrams into the newest lens values of each sender, without using sockets.

No datagram can raise an error here or use unlimited memory. Invalid datagrams are counted and
ignored.

Samples that were sent in several datagrams are reassembled.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

from heatlens.media.live.ring.opentrackio import (
    SEQUENCES,
    RingPacketError,
    Segment,
    parse_sample,
    parse_segment,
)
from heatlens.media.live.ring.sources import SILENT_AFTER_S, LensSample, RingSources

MAX_SENDERS = 64
MAX_SEGMENTS = 256  # most segments of a sample; 64 kB in datagrams of usual size are 45
Sender = tuple[object, ...]  # the address of a sender, as a socket reports it


class Decoder(Protocol):
    """Decodes one protocol.

    lost   number of samples that were never complete
    """

    @property
    def lost(self) -> int: ...

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return the samples that a datagram completes. Raise RingPacketError if it is invalid."""
        ...


class SampleCollector:
    """Decodes datagrams and keeps the newest samples.

    accepted  number of valid datagrams
    refused   number of invalid datagrams; `fault` says why the last one was refused
    """

    def __init__(
        self,
        decoder: Decoder,
        clock: Callable[[], float] = time.monotonic,
        silent_after_s: float = SILENT_AFTER_S,
    ) -> None:
        """Decode with `decoder`; for the other arguments see `RingSources`."""
        self.sources = RingSources(clock, silent_after_s)
        self.accepted = 0
        self.refused = 0
        self.fault: str | None = None
        self._decoder = decoder

    @property
    def lost(self) -> int:
        """The number of samples that were never complete."""
        return self._decoder.lost

    def accept_datagram(self, datagram: bytes, sender: Sender) -> None:
        """Decode a datagram and add its samples, or count it as refused and store why."""
        try:
            samples = self._decoder.samples(datagram, sender)
            for sample in samples:
                self.sources.add_sample(sample)
        except Exception as error:  # the thread must go on, whatever error a library raises
            self.refused += 1
            is_known = isinstance(error, RingPacketError)
            self.fault = str(error) if is_known else "a datagram cannot be read"
        else:
            self.accepted += 1


@dataclass
class _UnfinishedSample:
    """Segments of a sample that do not overlap, in the order of their offsets."""

    segments: list[Segment] = field(default_factory=list)

    # Segments are ordered by offset and not by number, because the reference sender of the standard
    # numbers datagrams and others number samples. With one numbering expected, samples of several
    # datagrams were lost. A segment that overlaps ends the sample, which keeps its size bounded.
    def add_segment(self, segment: Segment) -> bool:
        """Add a segment, or return False if it cannot belong to the same sample as the others."""
        known_segments = self.segments
        if segment in known_segments:  # the network has sent it twice
            return True
        ordered = sorted((*known_segments, segment), key=lambda entry: entry.offset)
        if len(ordered) > MAX_SEGMENTS or not all(_can_follow(*pair) for pair in pairwise(ordered)):
            return False
        self.segments = ordered
        return True

    @property
    def is_complete(self) -> bool:
        """True if the segments together are the whole text of the sample."""
        byte_count = sum(len(segment.payload) for segment in self.segments)
        return self.segments[-1].is_last and self.segments[-1].end == byte_count

    @property
    def text(self) -> bytes | None:
        """The text of a complete sample; None if datagrams of two samples were mixed up."""
        is_single_sample = _is_consistently_numbered(
            [segment.sequence for segment in self.segments]
        )
        return b"".join(segment.payload for segment in self.segments) if is_single_sample else None


class Assembly:
    """Keeps at most one incomplete sample for each of a few senders.

    An incomplete sample is lost when a datagram of another one arrives; `lost` counts these.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._unfinished: dict[Sender, _UnfinishedSample] = {}

    def add(self, sender: Sender, segment: Segment) -> bytes | None:
        """Add a segment; return the text of its sample if that is now complete."""
        unfinished = self._unfinished.get(sender)
        if unfinished is None or not unfinished.add_segment(segment):
            unfinished = self._start_sample(sender, segment)
        if not unfinished.is_complete:
            return None
        del self._unfinished[sender]
        self.lost += unfinished.text is None
        return unfinished.text

    # Each sender has at most one unfinished sample, and the oldest is dropped if there are too many
    # senders: anybody on the network can send first segments under new addresses without end.
    def _start_sample(self, sender: Sender, segment: Segment) -> _UnfinishedSample:
        """Begin a sample with `segment`, in place of an incomplete one of this sender."""
        self.lost += self._unfinished.pop(sender, None) is not None
        if len(self._unfinished) >= MAX_SENDERS:
            self._unfinished.pop(next(iter(self._unfinished)))
            self.lost += 1
        return self._unfinished.setdefault(sender, _UnfinishedSample([segment]))


class OpenTrackIODecoder(Assembly):
    """Decodes OpenTrackIO: segments with a checksum, which form samples."""

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return the sample that a datagram completes, if any. Raise RingPacketError if invalid."""
        segment = parse_segment(datagram)
        text = self.add(sender, segment)
        return () if text is None else (parse_sample(text, segment.encoding),)


def _can_follow(previous: Segment, following: Segment) -> bool:
    """Return whether `following` can come after `previous` in the text of one sample."""
    is_behind = (
        previous.offset < following.offset
        and previous.end <= following.offset
        and not previous.is_last
    )
    steps = (following.sequence - previous.sequence) % SEQUENCES
    return is_behind and previous.encoding is following.encoding and steps < MAX_SEGMENTS


def _is_consistently_numbered(sequences: Sequence[int]) -> bool:
    """Return whether all numbers are equal, or each is the next after the one before.

    The sender of the standard numbers datagrams; others number samples.
    """
    steps = {(next_number - number) % SEQUENCES for number, next_number in pairwise(sequences)}
    return steps <= {1} or steps == {0}
