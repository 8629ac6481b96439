"""A controller that sends OSC: its fader is learned with the mouse, and then turns the focus."""

import socket

import pytest
from pythonosc.osc_message_builder import OscMessageBuilder

from heatlens.media.live.ring.address import Protocol
from support.ring_window import draw_until, window_following_ring


@pytest.fixture(scope="module")
def gui(session_context, tmp_path_factory):
    with window_following_ring(
        session_context, Protocol.OSC, tmp_path_factory.mktemp("osc")
    ) as new_gui:
        yield new_gui


@pytest.fixture
def receiver(gui):
    return gui.session.lens.ring.receiver


def move_fader(gui, receiver, value: float) -> None:
    """Send the position of the fader, and draw frames until the window has received it."""
    version = receiver.source_state().version
    builder = OscMessageBuilder("/1/fader1")
    builder.add_arg(value)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as fader:
        fader.sendto(builder.build().dgram, (receiver.address.host, receiver.address.port))
    draw_until(gui, lambda: receiver.source_state().version != version)
    gui.frame(2)


def test_learned_fader_turns_the_focus(gui, receiver):
    assert "learn focus" not in gui.drawn
    move_fader(gui, receiver, 0.25)
    gui.click(gui.middle("learn focus"))
    for value in (0.25, 0.5, 0.75):
        move_fader(gui, receiver, value)
    gui.click(gui.middle("learn focus"))
    assert "/1/fader1 turns the focus" in gui.session.messages.text
    move_fader(gui, receiver, 0.5)
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(1.0)  # half of two dioptres
    move_fader(gui, receiver, 0.25)
    assert gui.session.facts.lens.focus_distance_m == 0.5
    assert gui.session.preferences.values.ring_maps[0].channel == "/1/fader1"
