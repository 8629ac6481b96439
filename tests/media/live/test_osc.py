"""OSC: what a controller sends becomes channels; strangers are refused."""

import socket
import struct
import subprocess
import sys
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from heatlens.core.base.errors import InputError
from heatlens.media.live.ring.address import (
    Protocol,
    RingAddress,
    opentrackio_address,
    parse_ring_address,
)
from heatlens.media.live.ring.hearing import Hearing
from heatlens.media.live.ring.receiver import LensReceiver, OscDecoder
from heatlens.media.live.ring.sources import CHANNELS_MOST, LensSample

SENDER = ("127.0.0.1", 5)
PATIENCE_S = 30.0


def message(address: str, *values: object):
    builder = OscMessageBuilder(address)
    for value in values:
        builder.add_arg(value)
    return builder.build()


@pytest.fixture
def hearing() -> Hearing:
    return Hearing(OscDecoder())


def test_a_message_is_a_channel_of_its_sender(hearing):
    hearing.take(message("/1/fader2", 0.25).dgram, SENDER)
    hearing.take(message("/focus", "label", 3).dgram, SENDER)
    sample = hearing.sources.heard().sample
    assert sample == LensSample("127.0.0.1", channels={"/1/fader2": 0.25, "/focus": 3.0})


def test_a_bundle_is_one_sample(hearing):
    bundle = OscBundleBuilder(IMMEDIATELY)
    for name in "ab":
        bundle.add_content(message(f"/{name}", 0.5))
    hearing.take(bundle.build().dgram, SENDER)
    assert hearing.sources.version == 1
    assert hearing.sources.heard().sample.channels == {"/a": 0.5, "/b": 0.5}


def test_values_of_the_lens_are_taken_as_they_are(hearing):
    hearing.take(message("/camera/focus_distance_m", 2.5).dgram, SENDER)
    hearing.take(message("/f_stop", -1.0).dgram, SENDER)
    assert hearing.sources.heard().sample == LensSample("127.0.0.1", focus_distance_m=2.5)


@given(st.binary(max_size=120))
def test_noise_is_counted_and_changes_nothing(noise):
    hearing = Hearing(OscDecoder())
    for datagram in (noise, b"/focus\0\0" + noise, b"#bundle\0" + noise):
        hearing.take(datagram, SENDER)
    assert hearing.taken + hearing.refused == 3


@pytest.mark.parametrize("values", [(), ("word",), (float("nan"),), (float("inf"),), (1e30,)])
def test_a_message_without_a_number_is_refused(hearing, values):
    hearing.take(message("/focus", *values).dgram, SENDER)
    assert (hearing.taken, hearing.refused) == (0, 1)


def test_channels_are_bounded(hearing):
    for number in range(2 * CHANNELS_MOST):
        hearing.take(message(f"/{number}", 1.0).dgram, SENDER)
    assert len(hearing.sources.heard().sample.channels) <= CHANNELS_MOST
    hearing.take(message("/0", 0.5).dgram, SENDER)
    assert hearing.sources.heard().sample.channels["/0"] == 0.5


def test_a_controller_that_rests_is_not_silent():
    now = [0.0]
    with LensReceiver(RingAddress(Protocol.OSC, "127.0.0.1", 0), clock=lambda: now[0]) as receiver:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as fader:
            place = receiver.address.host, receiver.address.port
            fader.sendto(message("/focus", 0.5).dgram, place)
        end = time.monotonic() + PATIENCE_S
        while receiver.heard().version == 0:
            assert time.monotonic() < end
            time.sleep(0.002)
        now[0] = 1000.0
        assert not receiver.heard().is_silent
        assert receiver.heard().sample.channels == {"/focus": 0.5}


def test_the_port_of_osc_is_9000_and_this_machine():
    assert str(parse_ring_address("osc")) == "osc://127.0.0.1:9000"
    assert str(parse_ring_address("osc://:8000")) == "osc://127.0.0.1:8000"


@pytest.mark.parametrize("tags", [b"\x1b", b"\x0e", b"f\x1b", b"z"])
def test_what_the_library_only_warns_of_is_refused_without_a_word(tags, capfd):
    tagged = b"," + tags
    datagram = b"/x\0\0" + tagged + bytes(4 - len(tagged) % 4) + struct.pack("!f", 0.5)
    hearing = Hearing(OscDecoder())
    hearing.take(datagram, ("stranger", 1))
    assert (hearing.taken, hearing.refused) == (0, 1)
    assert capfd.readouterr() == ("", "")


def test_osc_prints_no_control_characters_in_a_process_of_its_own():
    code = (
        "from heatlens.media.live.ring.hearing import Hearing\n"
        "from heatlens.media.live.ring.receiver import OscDecoder\n"
        "import logging; hearing = Hearing(OscDecoder())\n"
        "hearing.take(b'/x\\0\\0,\\x1b\\0\\0', ('stranger', 1))\n"
        "assert hearing.refused == 1; logging.getLogger('others').warning('heard')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert (done.stdout, done.stderr.strip()) == (b"", b"heard")


def test_a_controller_is_no_place_to_send_a_lens_to():
    with pytest.raises(InputError) as refused:
        opentrackio_address("udp://x")
    assert "opentrackio" in str(refused.value) and "osc" not in str(refused.value)
