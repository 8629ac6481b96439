"""Open the lens input that `--lens-in` names; read MIDI controllers with `mido`."""

import math
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any, cast

from heatlens.base.errors import InputError
from heatlens.live.ring.address import parse_ring_address
from heatlens.live.ring.receiver import LensReceiver
from heatlens.live.ring.ring_input import Controls, PadInput, RingInput

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
