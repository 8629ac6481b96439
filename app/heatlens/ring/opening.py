"""Open the lens input that `--lens-in` names."""

from heatlens.ring.address import parse_ring_address
from heatlens.ring.midi import MidiInput
from heatlens.ring.pad import PadInput
from heatlens.ring.receiver import LensReceiver
from heatlens.ring.ring_input import RingInput


def open_ring(text: str) -> RingInput:
    """Open "opentrackio...", "osc...", "midi[:NAME]" or "pad". Raise InputError."""
    kind, _, name = text.strip().partition(":")
    if kind.lower() == "midi":
        return MidiInput(name.removeprefix("//"))
    if text.strip().lower() == "pad":
        return PadInput()
    return LensReceiver(parse_ring_address(text))
