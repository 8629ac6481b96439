"""Samples that were sent in several datagrams, put together again."""

from dataclasses import dataclass, field

from heatlens.ring.otrk_packet import Encoding, Segment

MAX_SENDERS = 64
Sender = tuple[object, ...]  # the address that a socket tells


@dataclass
class _Unfinished:
    encoding: Encoding
    sequence: int
    parts: dict[int, bytes] = field(default_factory=dict)  # by offset
    length: int | None = None  # known from the last segment

    def joined(self) -> bytes | None:
        """Return the text once it is whole, in whatever order its segments came."""
        if self.length is None:
            return None
        text = b""
        while len(text) < self.length:
            part = self.parts.get(len(text))
            if not part:
                return None
            text += part
        return text


class Assembly:
    """Holds at most one unfinished sample for each sender, and few senders.

    A sample that is followed by another before it is whole is lost, and counted in `lost`.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._unfinished: dict[Sender, _Unfinished] = {}

    def add(self, sender: Sender, segment: Segment) -> bytes | None:
        """Take a segment; return the text of its sample where that makes it whole."""
        held = self._unfinished.get(sender)
        if held is None or (held.sequence, held.encoding) != (segment.sequence, segment.encoding):
            held = self._begin(sender, segment)
        held.parts[segment.offset] = segment.payload
        if segment.is_last:
            held.length = segment.offset + len(segment.payload)
        text = held.joined()
        if text is not None:
            del self._unfinished[sender]
        return text

    def _begin(self, sender: Sender, segment: Segment) -> _Unfinished:
        """Drop what the sender left unfinished; the one that began first makes room."""
        self.lost += self._unfinished.pop(sender, None) is not None
        if len(self._unfinished) >= MAX_SENDERS:
            self._unfinished.pop(next(iter(self._unfinished)))
            self.lost += 1
        return self._unfinished.setdefault(sender, _Unfinished(segment.encoding, segment.sequence))
