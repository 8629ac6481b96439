"""From the datagrams of strangers to the newest lens of each sender, without a socket.

Nothing that arrives can raise here or take more memory than the bounds say. Datagrams that are no
samples are counted, and change nothing.
"""

import time
from collections.abc import Callable
from typing import Protocol

from heatlens.ring.assembly import Assembly, Sender
from heatlens.ring.lens_sample import LensSample
from heatlens.ring.opentrackio import sample_of
from heatlens.ring.otrk_packet import RingPacketError, segment_of
from heatlens.ring.sources import SILENT_AFTER_S, RingSources


class Decoder(Protocol):
    """What understands one protocol.

    lost   how many samples were never whole
    """

    @property
    def lost(self) -> int: ...

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return the samples that a datagram completes. Raises RingPacketError for no datagram."""
        ...


class OpenTrackIODecoder:
    """Understands OpenTrackIO: segments with a checksum, put together to samples."""

    def __init__(self) -> None:
        self._assembly = Assembly()

    @property
    def lost(self) -> int:
        """How many samples were never whole."""
        return self._assembly.lost

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return the sample that a datagram completes, or none. Raises RingPacketError."""
        segment = segment_of(datagram)
        text = self._assembly.add(sender, segment)
        return () if text is None else (sample_of(text, segment.encoding),)


class Hearing:
    """Takes datagrams and keeps what they tell.

    taken     datagrams that were understood: a sample, or a part of one
    refused   datagrams that were not; `fault` says why the last of them was refused
    """

    def __init__(
        self,
        decoder: Decoder,
        clock: Callable[[], float] = time.monotonic,
        silent_after_s: float = SILENT_AFTER_S,
    ) -> None:
        """Understand what `decoder` does; the rest is as in `RingSources`."""
        self.sources = RingSources(clock, silent_after_s)
        self.taken = 0
        self.refused = 0
        self.fault: str | None = None
        self._decoder = decoder

    @property
    def lost(self) -> int:
        """How many samples were never whole."""
        return self._decoder.lost

    def take(self, datagram: bytes, sender: Sender) -> None:
        """Keep what a datagram tells, or count it as refused."""
        try:
            samples = self._decoder.samples(datagram, sender)
        except RingPacketError as error:
            self.refused += 1
            self.fault = str(error)
            return
        self.taken += 1
        for sample in samples:
            self.sources.keep(sample)
