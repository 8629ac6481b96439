"""Open the lens input that `--lens-in` names.

The samples of cameras are received on a thread; MIDI controllers are read with `mido`.
"""

import math
import selectors
import socket
import time
from collections.abc import Callable
from threading import Thread
from types import ModuleType
from typing import Any, cast

from heatlens.base.errors import InputError
from heatlens.live.ring.address import Protocol, RingAddress, listening_socket, parse_ring_address
from heatlens.live.ring.hearing import Decoder, Hearing, OpenTrackIODecoder
from heatlens.live.ring.osc import OscDecoder
from heatlens.live.ring.ring_input import Controls, PadInput, RingInput
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


_CONTROL_MOST, _BEND_MOST = 127.0, 16383.0


class MidiInput(Controls):
    """Reads one port until `close`. The library calls it on its own thread."""

    def __init__(self, name: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Open the port whose name contains `name`; "" opens the first port.

        Raise InputError if the library or the port is missing.
        """
        super().__init__(f"midi:{name}", clock, math.inf)
        mido = _library()
        port = _port_named(mido, name)
        self.address = f"midi:{port}"
        try:
            self._port = mido.open_input(port, callback=self.hear)
        except Exception as error:  # each backend of the library has its own errors
            raise InputError(f"The MIDI port {port!r} cannot be opened ({error}).") from error

    def hear(self, message: Any) -> None:
        """Handle a message of the port; only control changes and wheels are used."""
        if message.type == "control_change":
            name = f"control {message.control} of channel {message.channel + 1}"
            self.take("", {name: message.value / _CONTROL_MOST})
        elif message.type == "pitchwheel":
            name = f"wheel of channel {message.channel + 1}"
            self.take("", {name: (message.pitch + 8192) / _BEND_MOST})

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self._port.close()


def _library() -> ModuleType:
    try:
        import mido

        mido.backend.load()
    except ImportError as error:  # the backend is a second package
        raise InputError(
            "MIDI needs: pip install 'heatlens[ring]' python-rtmidi, and the sound library of the "
            f"system ({error})."
        ) from error
    return cast(ModuleType, mido)


def _port_named(mido: ModuleType, name: str) -> str:
    ports = [str(port) for port in mido.get_input_names()]
    found = next((port for port in ports if name.lower() in port.lower()), None)
    if found is None:
        there = f"there are {', '.join(ports)}" if ports else "there is none on this machine"
        raise InputError(f"No MIDI port is called {name!r}; {there}.")
    return found


def open_ring(text: str) -> RingInput:
    """Open "opentrackio...", "osc...", "midi[:NAME]" or "pad". Raise InputError."""
    kind, _, name = text.strip().partition(":")
    if kind.lower() == "midi":
        return MidiInput(name.removeprefix("//"))
    if text.strip().lower() == "pad":
        return PadInput()
    return LensReceiver(parse_ring_address(text))
