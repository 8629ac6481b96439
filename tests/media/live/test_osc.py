"""Test OSC: numbers from a controller become channels, other datagrams are refused."""

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
from heatlens.media.live.ring.hearing import SampleCollector
from heatlens.media.live.ring.receiver import LensReceiver, OscDecoder
from heatlens.media.live.ring.sources import CHANNELS_MOST, LensSample
from support.patience import PATIENCE_S

SENDER = ("127.0.0.1", 5)


def message(address: str, *values: object):
    builder = OscMessageBuilder(address)
    for value in values:
        builder.add_arg(value)
    return builder.build()


@pytest.fixture
def collector() -> SampleCollector:
    return SampleCollector(OscDecoder())


def test_osc_message_is_a_channel_of_its_sender(collector):
    collector.accept_datagram(message("/1/fader2", 0.25).dgram, SENDER)
    collector.accept_datagram(message("/focus", "label", 3).dgram, SENDER)
    sample = collector.sources.source_state().sample
    assert sample == LensSample("127.0.0.1", channels={"/1/fader2": 0.25, "/focus": 3.0})


def test_osc_bundle_is_one_sample(collector):
    bundle = OscBundleBuilder(IMMEDIATELY)
    for name in "ab":
        bundle.add_content(message(f"/{name}", 0.5))
    collector.accept_datagram(bundle.build().dgram, SENDER)
    assert collector.sources.version == 1
    assert collector.sources.source_state().sample.channels == {"/a": 0.5, "/b": 0.5}


def test_osc_message_named_as_lens_field_sets_it(collector):
    collector.accept_datagram(message("/camera/focus_distance_m", 2.5).dgram, SENDER)
    collector.accept_datagram(message("/f_stop", -1.0).dgram, SENDER)
    assert collector.sources.source_state().sample == LensSample("127.0.0.1", focus_distance_m=2.5)


@given(st.binary(max_size=120))
def test_osc_counts_any_bytes_as_taken_or_refused(noise):
    collector = SampleCollector(OscDecoder())
    for datagram in (noise, b"/focus\0\0" + noise, b"#bundle\0" + noise):
        collector.accept_datagram(datagram, SENDER)
    assert collector.accepted + collector.refused == 3


@pytest.mark.parametrize("values", [(), ("word",), (float("nan"),), (float("inf"),), (1e30,)])
def test_osc_message_without_number_is_refused(collector, values):
    collector.accept_datagram(message("/focus", *values).dgram, SENDER)
    assert (collector.accepted, collector.refused) == (0, 1)


def test_osc_limits_number_of_channels(collector):
    for number in range(2 * CHANNELS_MOST):
        collector.accept_datagram(message(f"/{number}", 1.0).dgram, SENDER)
    assert len(collector.sources.source_state().sample.channels) <= CHANNELS_MOST
    collector.accept_datagram(message("/0", 0.5).dgram, SENDER)
    assert collector.sources.source_state().sample.channels["/0"] == 0.5


def test_osc_controller_that_rests_is_not_silent():
    clock_s = [0.0]
    with LensReceiver(
        RingAddress(protocol=Protocol.OSC, host="127.0.0.1", port=0), clock=lambda: clock_s[0]
    ) as receiver:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as fader:
            place = receiver.address.host, receiver.address.port
            fader.sendto(message("/focus", 0.5).dgram, place)
        end = time.monotonic() + PATIENCE_S
        while receiver.source_state().version == 0:
            assert time.monotonic() < end
            time.sleep(0.002)
        clock_s[0] = 1000.0
        assert not receiver.source_state().is_silent
        assert receiver.source_state().sample.channels == {"/focus": 0.5}


def test_parse_ring_address_of_osc_defaults_to_this_machine_and_port_9000():
    assert str(parse_ring_address("osc")) == "osc://127.0.0.1:9000"
    assert str(parse_ring_address("osc://:8000")) == "osc://127.0.0.1:8000"


@pytest.mark.parametrize("tags", [b"\x1b", b"\x0e", b"f\x1b", b"z"])
def test_osc_refuses_unknown_type_tags_without_printing(tags, capfd):
    tagged = b"," + tags
    datagram = b"/x\0\0" + tagged + bytes(4 - len(tagged) % 4) + struct.pack("!f", 0.5)
    collector = SampleCollector(OscDecoder())
    collector.accept_datagram(datagram, ("stranger", 1))
    assert (collector.accepted, collector.refused) == (0, 1)
    assert capfd.readouterr() == ("", "")


def test_osc_prints_no_control_characters_to_stderr():
    code = (
        "from heatlens.media.live.ring.hearing import SampleCollector\n"
        "from heatlens.media.live.ring.receiver import OscDecoder\n"
        "import logging; hearing = SampleCollector(OscDecoder())\n"
        "hearing.accept_datagram(b'/x\\0\\0,\\x1b\\0\\0', ('stranger', 1))\n"
        "assert hearing.refused == 1; logging.getLogger('others').warning('heard')"
    )
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert (process.stdout, process.stderr.strip()) == (b"", b"heard")


def test_opentrackio_address_rejects_other_protocols():
    with pytest.raises(InputError) as error:
        opentrackio_address("udp://x")
    assert "opentrackio" in str(error.value) and "osc" not in str(error.value)
