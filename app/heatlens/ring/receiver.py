"""Hears what cameras send of their lenses, on a thread of its own.

Whoever sends is a stranger: nothing that arrives can raise here or take more memory than the bounds
say. Datagrams that are no samples are counted, and change nothing.
"""

import selectors
import socket
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Lock, Thread

from heatlens.closing import Closing
from heatlens.ring.address import RingAddress, listening_socket
from heatlens.ring.assembly import Assembly, Sender
from heatlens.ring.lens_sample import LensSample
from heatlens.ring.opentrackio import sample_of
from heatlens.ring.otrk_packet import RingPacketError, segment_of

MAX_SOURCES = 16
SILENT_AFTER_S = 1.0  # the lens then stays where it is, and that is said
_MAX_DATAGRAM = 65535
_RATE_OVER = 50  # samples
_AT_ONCE = 256  # datagrams, before it is looked whether the thread shall end


@dataclass
class RingSource:
    """A camera: what it has told so far, and when.

    `sample` holds every value that was ever sent, each as it was last; `heard_s` is on the clock of
    the receiver.
    """

    sample: LensSample
    heard_s: float
    times_s: deque[float] = field(default_factory=lambda: deque(maxlen=_RATE_OVER))

    @property
    def rate_hz(self) -> float:
        """How many samples come a second; 0 before the second one."""
        span_s = self.times_s[-1] - self.times_s[0] if self.times_s else 0.0
        return (len(self.times_s) - 1) / span_s if span_s > 0 else 0.0


@dataclass(frozen=True)
class Heard:
    """What was heard at a moment.

    sample    the newest values of the source that is listened to; None before its first
    sources   the names of all that send, in the order in which they were first heard
    rate_hz, age_s   how often its samples come, and how long ago the last one did
    version   goes up with every sample of that source
    """

    sample: LensSample | None
    sources: tuple[str, ...]
    rate_hz: float
    age_s: float
    version: int

    @property
    def is_silent(self) -> bool:
        """Return True where the source has stopped sending."""
        return self.sample is not None and self.age_s > SILENT_AFTER_S


class LensReceiver(Closing):
    """Listens until `close`; its methods may be called from any thread."""

    def __init__(
        self,
        address: RingAddress,
        on_news: Callable[[], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Listen at `address`; `on_news` is called on the thread after a sample was taken.

        Raises InputError where the address cannot be used.
        """
        self._socket = listening_socket(address)
        self.address = RingAddress(address.protocol, *self._socket.getsockname()[:2])
        self.on_news = on_news
        self.refused = 0  # datagrams that were no part of a sample
        self.fault: str | None = None  # why the last of them was refused
        self._clock = clock
        self._assembly = Assembly()
        self._sources: dict[str, RingSource] = {}
        self._version = 0
        self._lock = Lock()  # over the sources
        self._wake, self._waker = socket.socketpair()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._socket, selectors.EVENT_READ)
        self._selector.register(self._wake, selectors.EVENT_READ)
        self._thread = Thread(target=self._listen, name="lens-receiver", daemon=True)
        self._thread.start()

    @property
    def lost(self) -> int:
        """How many samples were never whole."""
        return self._assembly.lost

    def heard(self, source: str | None = None) -> Heard:
        """Return what `source` tells now; None listens to the one that was heard first."""
        with self._lock:
            names = tuple(self._sources)
            chosen = self._sources.get(names[0] if source is None and names else source or "")
            if chosen is None:
                return Heard(None, names, 0.0, 0.0, self._version)
            age_s = self._clock() - chosen.heard_s
            return Heard(chosen.sample, names, chosen.rate_hz, age_s, self._version)

    def close(self) -> None:
        """End the thread and let go of the port; a second call does nothing."""
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
        """Take the datagrams that wait, and tell of them once."""
        before = self._version
        for _ in range(_AT_ONCE):
            try:
                datagram, sender = self._socket.recvfrom(_MAX_DATAGRAM)
            except OSError:  # none is left, or the network told of one that was lost
                break
            self._take(datagram, sender)
        if self._version != before and self.on_news is not None:
            self.on_news()

    def _take(self, datagram: bytes, sender: Sender) -> None:
        try:
            segment = segment_of(datagram)
            text = self._assembly.add(sender, segment)
            if text is not None:
                self._keep(sample_of(text, segment.encoding))
        except RingPacketError as error:
            self.refused += 1
            self.fault = str(error)

    def _keep(self, sample: LensSample) -> None:
        """Add a sample to its source; the source that was silent for longest makes room."""
        now_s = self._clock()
        with self._lock:
            known = self._sources.get(sample.source)
            if known is None:
                self._make_room()
                known = self._sources[sample.source] = RingSource(sample, now_s)
            known.sample, known.heard_s = sample.after(known.sample), now_s
            known.times_s.append(now_s)
            self._version += 1

    def _make_room(self) -> None:
        while len(self._sources) >= MAX_SOURCES:
            del self._sources[min(self._sources, key=lambda name: self._sources[name].heard_s)]
