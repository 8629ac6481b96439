"""Turn untrusted datagrams into the newest lens of each sender; without sockets.

No datagram can raise an error here or use unlimited memory. Invalid datagrams are counted and
ignored.
"""

import time
from collections.abc import Callable
from typing import Protocol

from heatlens.live.ring.assembly import Assembly, Sender
from heatlens.live.ring.lens_sample import LensSample
from heatlens.live.ring.opentrackio import sample_of
from heatlens.live.ring.otrk_packet import RingPacketError, segment_of
from heatlens.live.ring.sources import SILENT_AFTER_S, RingSources


class Decoder(Protocol):
    """Decodes one protocol.

    lost   number of samples that were never complete
    """

    @property
    def lost(self) -> int: ...

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return the samples that a datagram completes. Raise RingPacketError if it is invalid."""
        ...


class OpenTrackIODecoder:
    """Decodes OpenTrackIO: segments with a checksum, which form samples."""

    def __init__(self) -> None:
        self._assembly = Assembly()

    @property
    def lost(self) -> int:
        """How many samples were never whole."""
        return self._assembly.lost

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return the sample that a datagram completes, if any. Raise RingPacketError if invalid."""
        segment = segment_of(datagram)
        text = self._assembly.add(sender, segment)
        return () if text is None else (sample_of(text, segment.encoding),)


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
        """How many samples were never whole."""
        return self._decoder.lost

    def take(self, datagram: bytes, sender: Sender) -> None:
        """Decode a datagram, or count it as refused."""
        try:
            samples = self._decoder.samples(datagram, sender)
            for sample in samples:
                self.sources.keep(sample)
        except Exception as error:  # the thread has to go on, whatever a library makes of it
            self.refused += 1
            is_known = isinstance(error, RingPacketError)
            self.fault = str(error) if is_known else "a datagram cannot be read"
        else:
            self.taken += 1
