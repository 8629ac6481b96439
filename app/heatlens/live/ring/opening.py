"""Open the lens input that `--lens-in` names."""

from heatlens.live.ring.address import parse_ring_address
from heatlens.live.ring.midi import MidiInput
from heatlens.live.ring.pad import PadInput
from heatlens.live.ring.receiver import LensReceiver
from heatlens.live.ring.ring_input import RingInput


def open_ring(text: str) -> RingInput:
    """Open "opentrackio...", "osc...", "midi[:NAME]" or "pad". Raise InputError."""
    kind, _, name = text.strip().partition(":")
    if kind.lower() == "midi":
        return MidiInput(name.removeprefix("//"))
    if text.strip().lower() == "pad":
        return PadInput()
    return LensReceiver(parse_ring_address(text))
