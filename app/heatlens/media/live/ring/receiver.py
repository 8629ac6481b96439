"""Open the lens input that `--lens-in` names.

The samples of cameras are received on a thread; MIDI controllers are read with `mido`. Open Sound
Control messages of a controller or tablet are decoded as values of channels by `python-osc`, after
the OSC 1.0 specification. The address of a message is the name of its channel, and its first number
is the value. Addresses that end in /focus_distance_m, /f_stop or /focal_length_mm are values of the
lens itself.
"""

import logging
import math
import selectors
import socket
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from threading import Thread, get_ident
from types import ModuleType
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import extra, import_extra
from heatlens.core.model.option import Values
from heatlens.media.live.ring.address import (
    Protocol,
    RingAddress,
    listening_socket,
    parse_ring_address,
)
from heatlens.media.live.ring.hearing import Decoder, OpenTrackIODecoder, SampleCollector, Sender
from heatlens.media.live.ring.opentrackio import RingPacketError
from heatlens.media.live.ring.sources import (
    SILENT_AFTER_S,
    Controls,
    LensSample,
    PadInput,
    RingInput,
)

_LENS_FIELDS = ("focus_distance_m", "f_stop", "focal_length_mm")
_NAME_LETTERS = 80  # longest name of a channel
_MOST = 1e9  # largest magnitude of a value


class OscDecoder:
    """Decodes OSC messages and bundles. Raises InputError without the library."""

    lost = 0  # every datagram is complete

    def __init__(self) -> None:
        self._packets = import_extra("pythonosc.osc_packet", "OSC")

    def samples(self, datagram: bytes, sender: Sender) -> tuple[LensSample, ...]:
        """Return one sample of all messages of a datagram. Raise RingPacketError if not OSC."""
        try:
            with _raise_on_warnings():
                messages = [timed.message for timed in self._packets.OscPacket(datagram).messages]
            values = [(message.address, tuple(message.params)) for message in messages]
        except Exception as error:  # the library raises various errors for invalid data
            raise RingPacketError("a datagram is not OSC") from error
        channels = dict(_first_numbers(values))
        if not channels:
            raise RingPacketError("an OSC message holds no number")
        return (_sample(channels, sender),)


class _RaisingHandler(logging.Handler):
    """Raises an error when the thread that made this handler logs a warning."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._thread = get_ident()

    def handle(self, record: logging.LogRecord) -> bool:
        """Raise RingPacketError."""
        if record.thread == self._thread:
            raise RingPacketError("an OSC datagram holds something other than numbers and text")
        return False


@contextmanager
def _raise_on_warnings() -> Iterator[None]:
    """Raise RingPacketError for the library's warnings, which would print untrusted bytes."""
    root, handler = logging.getLogger(), _RaisingHandler()
    root.addHandler(handler)
    try:
        yield
    finally:
        root.removeHandler(handler)


def _first_numbers(
    messages: Iterable[tuple[str, tuple[object, ...]]],
) -> Iterable[tuple[str, float]]:
    """Yield the address and the first number of each message that has a finite one."""
    for address, parameters in messages:
        number = next(
            (parameter for parameter in parameters if isinstance(parameter, int | float)), None
        )
        if number is not None and math.isfinite(number) and abs(number) <= _MOST:
            yield address[:_NAME_LETTERS], float(number)


def _sample(channels: dict[str, float], sender: Sender) -> LensSample:
    """Return a sample of the channels; addresses in _LENS_FIELDS become values of the lens."""
    values: Values = {
        name: value
        for address, value in channels.items()
        for name in _LENS_FIELDS
        if address.rpartition("/")[2] == name and value > 0
    }
    other_channels = {
        channel: channel_value
        for channel, channel_value in channels.items()
        if channel.rpartition("/")[2] not in _LENS_FIELDS
    }
    return LensSample(str(sender[0]) if sender else "", **values, channels=other_channels)


_MAX_DATAGRAM = 65535
_DECODERS: dict[Protocol, Callable[[], Decoder]] = {
    Protocol.OPENTRACKIO: OpenTrackIODecoder,
    Protocol.OSC: OscDecoder,
}
_DATAGRAMS_AT_ONCE = 256  # datagrams between checks whether the thread should end


class LensReceiver(SampleCollector, RingInput):
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
        """Receive datagrams until `close` is called; runs on a thread."""
        try:
            while all(key.fileobj is not self._wake for key, _ in self._selector.select()):
                self._receive_waiting()
        finally:
            self._selector.close()
            self._socket.close()
            self._wake.close()

    def _receive_waiting(self) -> None:
        """Handle all waiting datagrams, and tell once who listens."""
        previous_version = self.sources.version
        for _ in range(_DATAGRAMS_AT_ONCE):
            try:
                datagram, sender = self._socket.recvfrom(_MAX_DATAGRAM)
            except OSError:  # no datagram is left, or the network reports a lost one
                break
            self.accept_datagram(datagram, sender)
        if self.sources.version != previous_version and self._on_news is not None:
            self._on_news()


_CONTROL_MOST, _BEND_MOST = 127.0, 16383.0


class MidiInput(Controls):
    """Reads one port until `close`. The library calls it on its own thread."""

    def __init__(self, name: str) -> None:
        """Open the port whose name contains `name`; "" opens the first port.

        Raise InputError if the library or the port is missing.
        """
        super().__init__(f"midi:{name}", silent_after_s=math.inf)
        mido = _import_mido()
        port = _find_port(mido, name)
        self.address = f"midi:{port}"
        try:
            self._port = mido.open_input(port, callback=self.handle_message)
        except Exception as error:  # each backend of the library has its own errors
            raise InputError(f"The MIDI port {port!r} cannot be opened ({error}).") from error

    def handle_message(self, message: Any) -> None:
        """Handle a message of the port; only control changes and wheels are used."""
        if message.type == "control_change":
            name = f"control {message.control} of channel {message.channel + 1}"
            self.store_channels("", {name: message.value / _CONTROL_MOST})
        elif message.type == "pitchwheel":
            name = f"wheel of channel {message.channel + 1}"
            self.store_channels("", {name: (message.pitch + 8192) / _BEND_MOST})

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self._port.close()


def _import_mido() -> ModuleType:
    """Import mido and its backend. Raises MissingPackageError."""
    mido = import_extra("mido", "MIDI")
    with extra("ring").require("MIDI"):
        mido.backend.load()  # the backend is a second package
    return mido


def _find_port(mido: ModuleType, name: str) -> str:
    """Return the first MIDI port whose name contains `name`. Raises InputError without one."""
    ports = [str(port) for port in mido.get_input_names()]
    port_name = next((port for port in ports if name.lower() in port.lower()), None)
    if port_name is None:
        port_list = f"there are {', '.join(ports)}" if ports else "there is none on this machine"
        raise InputError(f"No MIDI port is called {name!r}; {port_list}.")
    return port_name


def open_ring(text: str) -> RingInput:
    """Open "opentrackio...", "osc...", "midi[:NAME]" or "pad". Raise InputError."""
    kind, _, name = text.strip().partition(":")
    if kind.lower() == "midi":
        return MidiInput(name.removeprefix("//"))
    if text.strip().lower() == "pad":
        return PadInput()
    return LensReceiver(parse_ring_address(text))
