"""Controllers that are plugged in: MIDI ports and game pads, without any hardware."""

import math

import mido
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.live.ring.receiver import MidiInput, open_ring
from heatlens.media.live.ring.sources import PadInput


class Port:
    """A MIDI port of a machine that has two."""

    names = ("Through 14:0", "Fader Box 20:0")

    def __init__(self, name, callback) -> None:
        self.name, self.callback, self.is_closed = name, callback, False

    def close(self) -> None:
        self.is_closed = True


@pytest.fixture
def ports(monkeypatch):
    monkeypatch.setattr(mido.backend, "load", lambda: None)
    monkeypatch.setattr(mido, "get_input_names", lambda: list(Port.names))
    monkeypatch.setattr(mido, "open_input", Port)


def test_controls_and_wheels_of_a_port_are_channels(ports):
    with open_ring("midi:fader") as midi:
        assert str(midi.address) == "midi:Fader Box 20:0"
        news = []
        midi.on_news = lambda: news.append(1)
        for message in (
            mido.Message("control_change", channel=0, control=7, value=127),
            mido.Message("pitchwheel", channel=1, pitch=-8192),
            mido.Message("note_on", note=60),
        ):
            midi._port.callback(message)
        assert midi.heard().sample.channels == {
            "control 7 of channel 1": 1.0,
            "wheel of channel 2": 0.0,
        }
        assert len(news) == 2
        assert midi.heard().silent_after_s == math.inf
    assert midi._port.is_closed


def test_the_first_port_is_opened_where_none_is_named(ports):
    with MidiInput("") as midi:
        assert midi._port.name == "Through 14:0"


def test_a_port_that_is_not_there_is_explained(ports, monkeypatch):
    with pytest.raises(InputError, match=r"is called 'organ'"):
        open_ring("midi:organ")
    monkeypatch.setattr(mido, "get_input_names", list)
    with pytest.raises(InputError, match="there is none on this machine"):
        open_ring("midi:")


def test_without_the_backend_it_is_said_what_to_install(monkeypatch):
    def load() -> None:
        raise ModuleNotFoundError("rtmidi")

    monkeypatch.setattr(mido.backend, "load", load)
    with pytest.raises(InputError, match="python-rtmidi"):
        open_ring("midi:fader")


def test_a_pad_is_read_when_it_is_asked_and_freezes_when_it_is_gone():
    now, axes = [0.0], {"axis 1": -0.5}
    with PadInput(lambda: now[0]) as pad:
        assert pad.heard().sample is None  # nothing is plugged in
        pad.read = lambda: axes
        now[0] = 0.03
        assert pad.heard().sample.channels == axes
        assert pad.heard().version == 1  # it was read a moment ago
        pad.read = lambda: None
        now[0] = 2.0
        assert pad.heard().is_silent and pad.heard().sample.channels == axes
        assert 0 < pad.seconds_until_due() <= 0.04


def test_a_pad_is_named_alone():
    with open_ring("pad") as pad:
        assert isinstance(pad, PadInput)
    with pytest.raises(InputError, match="osc://:9000"):
        open_ring("paddle")
