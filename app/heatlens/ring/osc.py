"""Open Sound Control: what a controller or a tablet sends becomes values of channels.

Source: the OSC 1.0 specification, read by `python-osc`. The address of a message is the name of its
channel and its first number the value. Three addresses are values of the lens themselves:
/focus_distance_m, /f_stop and /focal_length_mm, under whatever path they stand.
"""

import math
from collections.abc import Iterable
from typing import Any

from heatlens.errors import InputError
from heatlens.ring.assembly import Sender
from heatlens.ring.lens_sample import LensSample
from heatlens.ring.otrk_packet import RingPacketError

_VALUES = ("focus_distance_m", "f_stop", "focal_length_mm")
_NAME_LETTERS = 80
_MOST = 1e9


class OscDecoder:
    """Understands OSC: messages and bundles of them. Raises InputError without the library."""

    lost = 0  # a datagram is whole

    def __init__(self) -> None:
        try:
            from pythonosc import osc_packet
        except ImportError as error:
            raise InputError("OSC needs: pip install 'heatlens[ring]'") from error
        self._packets = osc_packet

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return one sample of all messages of a datagram. Raises RingPacketError for no OSC."""
        try:
            messages = [timed.message for timed in self._packets.OscPacket(datagram).messages]
            told = [(message.address, tuple(message.params)) for message in messages]
        except Exception as error:  # the library has no one error for all that a stranger sends
            raise RingPacketError("a datagram is not one of OSC") from error
        channels = dict(_numbers(told))
        if not channels:
            raise RingPacketError("a message of OSC holds no number")
        return (_sample(channels, sender),)


def _numbers(told: Iterable[tuple[str, tuple[object, ...]]]) -> Iterable[tuple[str, float]]:
    for address, parameters in told:
        first = next((p for p in parameters if isinstance(p, int | float)), None)
        if first is not None and math.isfinite(first) and abs(first) <= _MOST:
            yield address[:_NAME_LETTERS], float(first)


def _sample(channels: dict[str, float], sender: Sender) -> LensSample:
    values: dict[str, Any] = {
        name: value
        for address, value in channels.items()
        for name in _VALUES
        if address.rpartition("/")[2] == name and value > 0
    }
    others = {a: v for a, v in channels.items() if a.rpartition("/")[2] not in _VALUES}
    return LensSample(str(sender[0]) if sender else "", **values, channels=others)
