"""Decode Open Sound Control messages of a controller or tablet as values of channels.

Source: the OSC 1.0 specification, decoded by `python-osc`. The address of a message is the name of
its channel, and its first number is the value. Addresses that end in /focus_distance_m, /f_stop or
/focal_length_mm are values of the lens itself.
"""

import logging
import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from threading import get_ident

from heatlens.base.extras import import_extra
from heatlens.live.ring.hearing import Sender
from heatlens.live.ring.opentrackio import RingPacketError
from heatlens.live.ring.sources import LensSample
from heatlens.model.option import Values

_VALUES = ("focus_distance_m", "f_stop", "focal_length_mm")
_NAME_LETTERS = 80
_MOST = 1e9


class OscDecoder:
    """Decodes OSC messages and bundles. Raises InputError without the library."""

    lost = 0  # every datagram is complete

    def __init__(self) -> None:
        self._packets = import_extra("pythonosc.osc_packet", "OSC", "ring")

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return one sample of all messages of a datagram. Raise RingPacketError if not OSC."""
        try:
            with _warnings_refused():
                messages = [timed.message for timed in self._packets.OscPacket(datagram).messages]
            told = [(message.address, tuple(message.params)) for message in messages]
        except Exception as error:  # the library raises various errors for invalid data
            raise RingPacketError("a datagram is not OSC") from error
        channels = dict(_numbers(told))
        if not channels:
            raise RingPacketError("an OSC message holds no number")
        return (_sample(channels, sender),)


class _Refusing(logging.Handler):
    """Raises an error for a warning of the thread that made this handler."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._thread = get_ident()

    def handle(self, record: logging.LogRecord) -> bool:
        """Raise RingPacketError."""
        if record.thread == self._thread:
            raise RingPacketError("an OSC datagram holds an unknown type")
        return False


@contextmanager
def _warnings_refused() -> Iterator[None]:
    """Treat the library's warnings as errors: it would print untrusted bytes."""
    root, refusing = logging.getLogger(), _Refusing()
    root.addHandler(refusing)
    try:
        yield
    finally:
        root.removeHandler(refusing)


def _numbers(told: Iterable[tuple[str, tuple[object, ...]]]) -> Iterable[tuple[str, float]]:
    for address, parameters in told:
        first = next((p for p in parameters if isinstance(p, int | float)), None)
        if first is not None and math.isfinite(first) and abs(first) <= _MOST:
            yield address[:_NAME_LETTERS], float(first)


def _sample(channels: dict[str, float], sender: Sender) -> LensSample:
    values: Values = {
        name: value
        for address, value in channels.items()
        for name in _VALUES
        if address.rpartition("/")[2] == name and value > 0
    }
    others = {a: v for a, v in channels.items() if a.rpartition("/")[2] not in _VALUES}
    return LensSample(str(sender[0]) if sender else "", **values, channels=others)
