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
from heatlens.live.ring.sources import SILENT_AFTER_S

_MAX_DATAGRAM = 65535
_DECODERS: dict[Protocol, Callable[[], Decoder]] = {
    Protocol.OPENTRACKIO: OpenTrackIODecoder,
    Protocol.OSC: OscDecoder,
}
_AT_ONCE = 256  # datagrams between checks whether the thread should end


class LensReceiver(Hearing, RingInput):
    """Receives samples until `close`; its methods may be called from any thread."""

    def __init__(self, address: RingAddress, clock: Callable[[], float] = time.monotonic) -> None:
        """Listen at `address`; raise InputError if it cannot be used."""
        decoder, is_stream = _DECODERS[address.protocol](), address.protocol.is_stream
        super().__init__(decoder, clock, SILENT_AFTER_S if is_stream else math.inf)
        self._socket = listening_socket(address)
        self.address = RingAddress(address.protocol, *self._socket.getsockname()[:2])
        self._wake, self._waker = socket.socketpair()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._socket, selectors.EVENT_READ)
        self._selector.register(self._wake, selectors.EVENT_READ)
        self._thread = Thread(target=self._listen, name="lens-receiver", daemon=True)
        self._thread.start()

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
        before = self.sources.version
        for _ in range(_AT_ONCE):
            try:
                datagram, sender = self._socket.recvfrom(_MAX_DATAGRAM)
            except OSError:  # no datagram is left, or the network reports a lost one
                break
            self.take(datagram, sender)
        if self.sources.version != before and self.on_news is not None:
            self.on_news()
