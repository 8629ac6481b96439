"""Receive the lens samples of cameras on a thread."""

import math
import selectors
import socket
import time
from collections.abc import Callable
from threading import Thread

from heatlens.live.ring.address import Protocol, RingAddress, listening_socket
from heatlens.live.ring.hearing import Decoder, Hearing, OpenTrackIODecoder
from heatlens.live.ring.osc import OscDecoder
from heatlens.live.ring.ring_input import RingInput
from heatlens.live.ring.sources import SILENT_AFTER_S, Heard, Numbered

_MAX_DATAGRAM = 65535
_DECODERS: dict[Protocol, Callable[[], Decoder]] = {
    Protocol.OPENTRACKIO: OpenTrackIODecoder,
    Protocol.OSC: OscDecoder,
}
_AT_ONCE = 256  # datagrams between checks whether the thread should end


class LensReceiver(RingInput):
    """Receives samples until `close`; its methods may be called from any thread."""

    def __init__(
        self,
        address: RingAddress,
        on_news: Callable[[], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Listen at `address`; `on_news` is called on the thread after each sample.

        Raise InputError if the address cannot be used.
        """
        decoder, is_stream = _DECODERS[address.protocol](), address.protocol.is_stream
        self._hearing = Hearing(decoder, clock, SILENT_AFTER_S if is_stream else math.inf)
        self._socket = listening_socket(address)
        self.address = RingAddress(address.protocol, *self._socket.getsockname()[:2])
        self.on_news = on_news
        self._wake, self._waker = socket.socketpair()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._socket, selectors.EVENT_READ)
        self._selector.register(self._wake, selectors.EVENT_READ)
        self._thread = Thread(target=self._listen, name="lens-receiver", daemon=True)
        self._thread.start()

    @property
    def taken(self) -> int:
        """The number of valid datagrams."""
        return self._hearing.taken

    @property
    def refused(self) -> int:  # type: ignore[override]  # a count that goes up
        """The number of invalid datagrams."""
        return self._hearing.refused

    @property
    def fault(self) -> str | None:  # type: ignore[override]
        """Why the last invalid datagram was refused; None if there was none."""
        return self._hearing.fault

    @property
    def lost(self) -> int:  # type: ignore[override]
        """The number of samples that were never complete."""
        return self._hearing.lost

    def heard(self, source: str | None = None) -> Heard:
        """Return the present state of a source; see `RingSources.heard`."""
        return self._hearing.sources.heard(source)

    def since(self, version: int, source: str | None = None) -> tuple[Numbered, ...]:
        """Return the samples of a source after a version of `heard`; see `RingSources.since`."""
        return self._hearing.sources.since(version, source)

    def close(self) -> None:
        """End the thread and release the port; a second call does nothing."""
        if self._thread.is_alive():
            self._waker.send(b"x")
            self._thread.join()
        self._waker.close()

    def _listen(self) -> None:
        try:
            while all(key.fileobj is not self._wake for key, _ in self._selector.select()):
                self._hear_waiting()
        finally:
            self._selector.close()
            self._socket.close()
            self._wake.close()

    def _hear_waiting(self) -> None:
        """Handle all waiting datagrams, and call `on_news` once."""
        before = self._hearing.sources.version
        for _ in range(_AT_ONCE):
            try:
                datagram, sender = self._socket.recvfrom(_MAX_DATAGRAM)
            except OSError:  # no datagram is left, or the network reports a lost one
                break
            self._hearing.take(datagram, sender)
        if self._hearing.sources.version != before and self.on_news is not None:
            self.on_news()
