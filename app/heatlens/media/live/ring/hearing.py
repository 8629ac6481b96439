"""Turn untrusted datagrams into the newest lens of each sender; without sockets.

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
    sample_of,
    segment_of,
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


class Hearing:
    """Decodes datagrams and keeps the newest samples.

    taken     number of valid datagrams
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
        self.taken = 0
        self.refused = 0
        self.fault: str | None = None
        self._decoder = decoder

    @property
    def lost(self) -> int:
        """The number of samples that were never complete."""
        return self._decoder.lost

    def take(self, datagram: bytes, sender: Sender) -> None:
        """Decode a datagram, or count it as refused."""
        try:
            samples = self._decoder.samples(datagram, sender)
            for sample in samples:
                self.sources.keep(sample)
        except Exception as error:  # the thread must go on, whatever error a library raises
            self.refused += 1
            is_known = isinstance(error, RingPacketError)
            self.fault = str(error) if is_known else "a datagram cannot be read"
        else:
            self.taken += 1


@dataclass
class _Unfinished:
    """Segments of a sample that do not overlap, in the order of their offsets."""

    segments: list[Segment] = field(default_factory=list)

    # By offset and not by number: the reference sender of the standard numbers every datagram,
    # others number samples, and both are met. Samples of several datagrams were lost while only one
    # numbering was expected. One that overlaps ends the sample, so that unfinished ones stay
    # bounded.
    def take(self, segment: Segment) -> bool:
        """Add a segment, or return False if it cannot belong to the same sample as the others."""
        held = self.segments
        if segment in held:  # the network has sent it twice
            return True
        parts = sorted((*held, segment), key=lambda one: one.offset)
        if len(parts) > MAX_SEGMENTS or not all(_can_follow(*pair) for pair in pairwise(parts)):
            return False
        self.segments = parts
        return True

    @property
    def is_whole(self) -> bool:
        """True if the segments are all of the sample's text."""
        held = sum(len(one.payload) for one in self.segments)
        return self.segments[-1].is_last and self.segments[-1].end == held

    @property
    def text(self) -> bytes | None:
        """The text of a complete sample; None if datagrams of two samples were mixed up."""
        is_one = _is_numbered([one.sequence for one in self.segments])
        return b"".join(one.payload for one in self.segments) if is_one else None


class Assembly:
    """Keeps at most one incomplete sample for each of a few senders.

    An incomplete sample is lost when a datagram of another one arrives; `lost` counts these.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._unfinished: dict[Sender, _Unfinished] = {}

    def add(self, sender: Sender, segment: Segment) -> bytes | None:
        """Add a segment; return the text of its sample if that is now complete."""
        held = self._unfinished.get(sender)
        if held is None or not held.take(segment):
            held = self._begin(sender, segment)
        if not held.is_whole:
            return None
        del self._unfinished[sender]
        self.lost += held.text is None
        return held.text

    # Anybody on the network can send first segments under new addresses without end. So each sender
    # has one unfinished sample, and the oldest goes when there are too many senders.
    def _begin(self, sender: Sender, segment: Segment) -> _Unfinished:
        """Drop an incomplete sample of this sender, or the oldest one to make room."""
        self.lost += self._unfinished.pop(sender, None) is not None
        if len(self._unfinished) >= MAX_SENDERS:
            self._unfinished.pop(next(iter(self._unfinished)))
            self.lost += 1
        return self._unfinished.setdefault(sender, _Unfinished([segment]))


class OpenTrackIODecoder(Assembly):
    """Decodes OpenTrackIO: segments with a checksum, which form samples."""

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return the sample that a datagram completes, if any. Raise RingPacketError if invalid."""
        segment = segment_of(datagram)
        text = self.add(sender, segment)
        return () if text is None else (sample_of(text, segment.encoding),)


def _can_follow(before: Segment, after: Segment) -> bool:
    """Return whether a segment can follow another one in the text of a sample."""
    is_behind = before.offset < after.offset and before.end <= after.offset and not before.is_last
    steps = (after.sequence - before.sequence) % SEQUENCES
    return is_behind and before.encoding is after.encoding and steps < MAX_SEGMENTS


def _is_numbered(sequences: Sequence[int]) -> bool:
    """Return whether each datagram has the next number, or all have that of their sample.

    The sender of the standard numbers datagrams; others number samples.
    """
    steps = {(after - before) % SEQUENCES for before, after in pairwise(sequences)}
    return steps <= {1} or steps == {0}
