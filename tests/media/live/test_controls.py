"""Test plugged-in controllers, MIDI ports and game pads, without any hardware."""

import math

import mido
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.live.ring.receiver import MidiInput, open_ring
from heatlens.media.live.ring.sources import PadInput


class FakeMidiPort:
    """A MIDI port of a machine that has two."""

    names = ("Through 14:0", "Fader Box 20:0")

    def __init__(self, name, callback) -> None:
        self.name, self.callback, self.is_closed = name, callback, False

    def close(self) -> None:
        self.is_closed = True


@pytest.fixture
def ports(monkeypatch):
    monkeypatch.setattr(mido.backend, "load", lambda: None)
    monkeypatch.setattr(mido, "get_input_names", lambda: list(FakeMidiPort.names))
    monkeypatch.setattr(mido, "open_input", FakeMidiPort)


def test_midi_controls_and_pitch_wheels_are_channels(ports):
    with open_ring("midi:fader") as midi:
        assert str(midi.address) == "midi:Fader Box 20:0"
        news = []
        midi.listen(lambda: news.append(1))
        for message in (
            mido.Message("control_change", channel=0, control=7, value=127),
            mido.Message("pitchwheel", channel=1, pitch=-8192),
            mido.Message("note_on", note=60),
        ):
            midi._port.callback(message)
        assert midi.source_state().sample.channels == {
            "control 7 of channel 1": 1.0,
            "wheel of channel 2": 0.0,
        }
        assert len(news) == 2
        assert midi.source_state().silent_after_s == math.inf
    assert midi._port.is_closed


def test_midi_input_without_name_opens_first_port(ports):
    with MidiInput("") as midi:
        assert midi._port.name == "Through 14:0"


def test_open_ring_explains_missing_midi_port(ports, monkeypatch):
    with pytest.raises(InputError, match=r"is called 'organ'"):
        open_ring("midi:organ")
    monkeypatch.setattr(mido, "get_input_names", list)
    with pytest.raises(InputError, match="there is none on this machine"):
        open_ring("midi:")


def test_open_ring_without_midi_backend_names_package_to_install(monkeypatch):
    def load() -> None:
        raise ModuleNotFoundError("rtmidi")

    monkeypatch.setattr(mido.backend, "load", load)
    with pytest.raises(InputError, match="python-rtmidi"):
        open_ring("midi:fader")


def test_pad_input_reads_now_and_then_and_keeps_values_after_unplugging():
    now, axes = [0.0], {"axis 1": -0.5}
    with PadInput(lambda: now[0]) as pad:
        assert pad.source_state().sample is None  # nothing is plugged in
        now[0] = 0.03
        pad.poll(lambda: axes)
        pad.poll(lambda: {"axis 1": 1.0})  # it was read a moment ago
        assert pad.source_state().sample.channels == axes
        assert pad.source_state().version == 1
        now[0] = 2.0
        pad.poll(lambda: None)
        assert pad.source_state().is_silent and pad.source_state().sample.channels == axes
        assert 0 < pad.seconds_until_due() <= 0.04


def test_open_ring_opens_pad_by_exact_name_only():
    with open_ring("pad") as pad:
        assert isinstance(pad, PadInput)
    with pytest.raises(InputError, match="osc://:9000"):
        open_ring("paddle")
