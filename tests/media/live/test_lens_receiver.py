"""Test a lens receiver with senders on this machine: what it accepts, refuses and follows."""

import math
import socket
import time
from threading import Event

import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.live.ring.address import Protocol, RingAddress, parse_ring_address
from heatlens.media.live.ring.hearing import SampleCollector
from heatlens.media.live.ring.opentrackio import Encoding, source_id, split_into_datagrams
from heatlens.media.live.ring.receiver import LensReceiver
from heatlens.media.live.ring.sender import LensSender, send_at_rate
from heatlens.media.live.ring.sources import MAX_SOURCES, SILENT_AFTER_S, LensSample, RingSources
from support.patience import PATIENCE_S

A, B = source_id("A"), source_id("B")

LOOPBACK = RingAddress(protocol=Protocol.OPENTRACKIO, host="127.0.0.1", port=0)


@pytest.fixture
def receiver():
    with LensReceiver(LOOPBACK) as new_receiver:
        yield new_receiver


def wait_until(condition) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.002)


@pytest.mark.parametrize("encoding", Encoding)
def test_lens_receiver_hears_sent_samples(receiver, encoding):
    news = Event()
    receiver.listen(news.set)
    with LensSender(receiver.address, encoding) as sender:
        sender.send(LensSample(A, focus_distance_m=2.0, f_stop=2.8))
        sender.send(LensSample(A, focus_distance_m=1.5))
    assert news.wait(PATIENCE_S)
    wait_until(lambda: receiver.source_state().version == 2)
    assert receiver.source_state().sample == LensSample(A, focus_distance_m=1.5, f_stop=2.8)


def test_lens_receiver_separates_sources_by_name(receiver):
    with LensSender(receiver.address) as sender:
        for name, distance_m in ((A, 1.0), (B, 2.0)):
            sender.send(LensSample(name, focus_distance_m=distance_m))
        wait_until(lambda: len(receiver.source_state().sources) == 2)
    assert receiver.source_state().sample.focus_distance_m == 1.0  # the first that was heard
    assert receiver.source_state(B).sample.focus_distance_m == 2.0
    assert receiver.source_state("C").sample is None


def test_lens_receiver_counts_foreign_datagrams_without_effect(receiver):
    with LensSender(receiver.address) as sender:
        sender.send(LensSample(A, focus_distance_m=2.0))
        wait_until(lambda: receiver.source_state().version == 1)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            for noise in (b"", b"OTrk", b"GET / HTTP/1.1", bytes(60_000)):
                stranger.sendto(noise, (receiver.address.host, receiver.address.port))
        wait_until(lambda: receiver.refused == 4)
        assert receiver.source_state().sample == LensSample(A, focus_distance_m=2.0)
        sender.send(LensSample(A, focus_distance_m=3.0))
        wait_until(lambda: receiver.source_state().sample.focus_distance_m == 3.0)


def test_lens_receiver_limits_number_of_sources(receiver):
    with LensSender(receiver.address) as sender:
        for number in range(2 * MAX_SOURCES):
            sender.send(LensSample(str(number), f_stop=2.0))
            wait_until(lambda expected=number + 1: receiver.source_state().version == expected)
    assert len(receiver.source_state().sources) == MAX_SOURCES


def test_lens_receiver_rate_and_silence_follow_the_clock():
    now = [100.0]
    with LensReceiver(LOOPBACK, clock=lambda: now[0]) as receiver:
        with LensSender(receiver.address) as sender:
            for number in range(11):
                now[0] = 100.0 + number / 50
                sender.send(LensSample(A, f_stop=2.0))
                wait_until(lambda expected=number + 1: receiver.source_state().version == expected)
        assert receiver.source_state().rate_hz == pytest.approx(50.0)
        assert not receiver.source_state().is_silent
        now[0] += SILENT_AFTER_S + 0.1
        assert receiver.source_state().is_silent


def test_send_at_rate_catches_up_after_a_slow_send():
    clock_s, sent_at = [0.0], []

    class Slow:
        def send(self, sample) -> None:
            sent_at.append(clock_s[0])
            clock_s[0] += 0.3 if len(sent_at) == 2 else 0.0

    def sleep(seconds: float) -> None:
        clock_s[0] += seconds

    send_at_rate(Slow(), [LensSample()] * 6, 10.0, lambda: clock_s[0], sleep)
    assert sent_at == pytest.approx([0.0, 0.1, 0.4, 0.4, 0.4, 0.5])


def test_lens_receiver_close_frees_the_port():
    receiver = LensReceiver(LOOPBACK)
    with pytest.raises(InputError, match="another program may listen"):
        LensReceiver(receiver.address)
    receiver.close()
    receiver.close()
    LensReceiver(receiver.address).close()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("opentrackio", "opentrackio://127.0.0.1:55555"),
        ("opentrackio://", "opentrackio://127.0.0.1:55555"),
        ("OpenTrackIO://:6000", "opentrackio://127.0.0.1:6000"),
        ("opentrackio://239.135.1.1", "opentrackio://239.135.1.1:55555"),
        ("opentrackio://localhost:0", "opentrackio://127.0.0.1:0"),
    ],
)
def test_parse_ring_address_fills_in_defaults(text, expected):
    assert str(parse_ring_address(text)) == expected
    assert parse_ring_address(text).is_multicast == ("239" in text)


@pytest.mark.parametrize("place", ["a b", "1.2.3.4:x", "1.2.3.4:70000", "1.2.3.4:-1", "1.2.3:5"])
def test_parse_ring_address_rejects_bad_host_or_port(place):
    with pytest.raises(InputError, match=r"opentrackio://HOST:PORT"):
        parse_ring_address(f"opentrackio://{place}")


@pytest.mark.parametrize("text", ["", "tev", "midi", "opentrackio:55555", "://127.0.0.1"])
def test_parse_ring_address_rejects_text_that_is_no_address(text):
    with pytest.raises(InputError, match=r"opentrackio://HOST:PORT"):
        parse_ring_address(text)


def test_lens_receiver_survives_source_number_of_thousands_of_digits(receiver):
    huge = b"\xa1\x68sourceId\xc2\x59\x0f\xa0" + b"\xff" * 4000  # more digits than Python writes
    with (
        LensSender(receiver.address) as sender,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        for datagram in split_into_datagrams(huge, Encoding.CBOR, 1):
            stranger.sendto(datagram, (receiver.address.host, receiver.address.port))
        sender.send(LensSample(A, focus_distance_m=3.0))
        wait_until(lambda: receiver.source_state(A).sample is not None)
    assert receiver.source_state(A).sample.focus_distance_m == 3.0


class FaultyDecoder:
    """A decoder that raises an unexpected error for all but one datagram."""

    lost = 0

    def samples(self, datagram, sender):
        if datagram == b"good":
            return (LensSample("A", f_stop=2.0),)
        raise KeyError(datagram)


def test_hearing_counts_any_decoder_error_as_refused():
    collector = SampleCollector(FaultyDecoder())
    for datagram in (b"bad", b"good", b"bad"):
        collector.accept_datagram(datagram, ("stranger", 1))
    assert (collector.accepted, collector.refused) == (1, 2)
    assert collector.fault == "a datagram cannot be read"


def test_ring_sources_follow_restarted_tracker_once_old_one_is_silent():
    now = [100.0]
    sources = RingSources(lambda: now[0])

    def heard(*names: str) -> str:
        for name in names:
            now[0] += 0.1
            sources.add_sample(LensSample(name, f_stop=2.0))
        return sources.source_state().sample.source

    assert heard("A", "B", "A") == "A"
    assert heard("new", "B") == "A"  # which is not silent yet
    now[0] += SILENT_AFTER_S
    assert heard("B") == "A"  # B is another camera, which was there before
    assert heard("B", "new") == "new"
    assert [sample.source for _, sample in sources.samples_since(0)] == ["new", "new"]
    assert heard("A", "B") == "new"  # which speaks
    assert sources.source_state("A").sample.source == "A"  # who asks for A gets A


def test_ring_sources_keep_following_idle_controller():
    now = [0.0]
    sources = RingSources(lambda: now[0], math.inf)
    for name in "AB":
        sources.add_sample(LensSample(name, channels={"/focus": 0.5}))
        now[0] += 1e6
    assert sources.source_state().sample.source == "A"
