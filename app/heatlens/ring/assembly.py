"""Reassemble samples that were sent in several datagrams."""

from dataclasses import dataclass, field

from heatlens.ring.otrk_packet import Encoding, Segment

MAX_SENDERS = 64
Sender = tuple[object, ...]  # the address of a sender, as a socket reports it


@dataclass
class _Unfinished:
    encoding: Encoding
    sequence: int
    parts: dict[int, bytes] = field(default_factory=dict)  # by offset
    length: int | None = None  # known once the last segment has arrived

    def joined(self) -> bytes | None:
        """Return the text once it is complete, regardless of the order of its segments."""
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
    """Keeps at most one incomplete sample for each of a few senders.

    An incomplete sample is lost when the next one begins; `lost` counts these.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._unfinished: dict[Sender, _Unfinished] = {}

    def add(self, sender: Sender, segment: Segment) -> bytes | None:
        """Add a segment; return the text of its sample if that is now complete."""
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
        """Drop an incomplete sample of this sender, or the oldest one to make room."""
        self.lost += self._unfinished.pop(sender, None) is not None
        if len(self._unfinished) >= MAX_SENDERS:
            self._unfinished.pop(next(iter(self._unfinished)))
            self.lost += 1
        return self._unfinished.setdefault(sender, _Unfinished(segment.encoding, segment.sequence))
