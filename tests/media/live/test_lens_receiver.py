"""A receiver and senders on this machine: what arrives, what is refused, who is heard."""

import math
import socket
import time
from threading import Event

import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.live.ring.address import Protocol, RingAddress, parse_ring_address
from heatlens.media.live.ring.hearing import Hearing
from heatlens.media.live.ring.opentrackio import Encoding, datagrams_of, source_id
from heatlens.media.live.ring.receiver import LensReceiver
from heatlens.media.live.ring.sender import LensSender, send_in_time
from heatlens.media.live.ring.sources import MAX_SOURCES, SILENT_AFTER_S, LensSample, RingSources

A, B = source_id("A"), source_id("B")

LOOPBACK = RingAddress(Protocol.OPENTRACKIO, "127.0.0.1", 0)
PATIENCE_S = 30.0


@pytest.fixture
def receiver():
    with LensReceiver(LOOPBACK) as made:
        yield made


def until(is_so) -> None:
    end = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < end
        time.sleep(0.002)


@pytest.mark.parametrize("encoding", Encoding)
def test_a_ring_that_is_turned_is_heard(receiver, encoding):
    news = Event()
    receiver.on_news = news.set
    with LensSender(receiver.address, encoding) as sender:
        sender.send(LensSample(A, focus_distance_m=2.0, f_stop=2.8))
        sender.send(LensSample(A, focus_distance_m=1.5))
    assert news.wait(PATIENCE_S)
    until(lambda: receiver.heard().version == 2)
    assert receiver.heard().sample == LensSample(A, focus_distance_m=1.5, f_stop=2.8)


def test_each_source_is_heard_by_its_name(receiver):
    with LensSender(receiver.address) as sender:
        for name, distance_m in ((A, 1.0), (B, 2.0)):
            sender.send(LensSample(name, focus_distance_m=distance_m))
        until(lambda: len(receiver.heard().sources) == 2)
    assert receiver.heard().sample.focus_distance_m == 1.0  # the first that was heard
    assert receiver.heard(B).sample.focus_distance_m == 2.0
    assert receiver.heard("C").sample is None


def test_strangers_change_nothing_and_are_counted(receiver):
    with LensSender(receiver.address) as sender:
        sender.send(LensSample(A, focus_distance_m=2.0))
        until(lambda: receiver.heard().version == 1)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            for noise in (b"", b"OTrk", b"GET / HTTP/1.1", bytes(60_000)):
                stranger.sendto(noise, (receiver.address.host, receiver.address.port))
        until(lambda: receiver.refused == 4)
        assert receiver.heard().sample == LensSample(A, focus_distance_m=2.0)
        sender.send(LensSample(A, focus_distance_m=3.0))
        until(lambda: receiver.heard().sample.focus_distance_m == 3.0)


def test_many_sources_are_bounded(receiver):
    with LensSender(receiver.address) as sender:
        for number in range(2 * MAX_SOURCES):
            sender.send(LensSample(str(number), f_stop=2.0))
            until(lambda told=number + 1: receiver.heard().version == told)
    assert len(receiver.heard().sources) == MAX_SOURCES


def test_rate_age_and_silence_follow_the_clock():
    now = [100.0]
    with LensReceiver(LOOPBACK, clock=lambda: now[0]) as receiver:
        with LensSender(receiver.address) as sender:
            for number in range(11):
                now[0] = 100.0 + number / 50
                sender.send(LensSample(A, f_stop=2.0))
                until(lambda told=number + 1: receiver.heard().version == told)
        assert receiver.heard().rate_hz == pytest.approx(50.0)
        assert not receiver.heard().is_silent
        now[0] += SILENT_AFTER_S + 0.1
        assert receiver.heard().is_silent


def test_samples_are_sent_in_time_and_a_late_one_delays_no_other():
    now, sent_at = [0.0], []

    class Slow:
        def send(self, sample) -> None:
            sent_at.append(now[0])
            now[0] += 0.3 if len(sent_at) == 2 else 0.0

    def sleep(seconds: float) -> None:
        now[0] += seconds

    send_in_time(Slow(), [LensSample()] * 6, 10.0, lambda: now[0], sleep)
    assert sent_at == pytest.approx([0.0, 0.1, 0.4, 0.4, 0.4, 0.5])


def test_the_port_is_free_again_after_closing():
    receiver = LensReceiver(LOOPBACK)
    with pytest.raises(InputError, match="another program may listen"):
        LensReceiver(receiver.address)
    receiver.close()
    receiver.close()
    LensReceiver(receiver.address).close()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("opentrackio", "opentrackio://127.0.0.1:55555"),
        ("opentrackio://", "opentrackio://127.0.0.1:55555"),
        ("OpenTrackIO://:6000", "opentrackio://127.0.0.1:6000"),
        ("opentrackio://239.135.1.1", "opentrackio://239.135.1.1:55555"),
        ("opentrackio://localhost:0", "opentrackio://127.0.0.1:0"),
    ],
)
def test_addresses_are_read(text, told):
    assert str(parse_ring_address(text)) == told
    assert parse_ring_address(text).is_multicast == ("239" in text)


@pytest.mark.parametrize("place", ["a b", "1.2.3.4:x", "1.2.3.4:70000", "1.2.3.4:-1", "1.2.3:5"])
def test_a_place_that_is_none_is_explained(place):
    with pytest.raises(InputError, match=r"opentrackio://HOST:PORT"):
        parse_ring_address(f"opentrackio://{place}")


@pytest.mark.parametrize("text", ["", "tev", "midi", "opentrackio:55555", "://127.0.0.1"])
def test_what_is_no_address_is_explained(text):
    with pytest.raises(InputError, match=r"opentrackio://HOST:PORT"):
        parse_ring_address(text)


def test_a_source_with_a_number_of_thousands_of_digits_does_not_end_the_listening(receiver):
    huge = b"\xa1\x68sourceId\xc2\x59\x0f\xa0" + b"\xff" * 4000  # more digits than Python writes
    with (
        LensSender(receiver.address) as sender,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        for datagram in datagrams_of(huge, Encoding.CBOR, 1):
            stranger.sendto(datagram, (receiver.address.host, receiver.address.port))
        sender.send(LensSample(A, focus_distance_m=3.0))
        until(lambda: receiver.heard(A).sample is not None)
    assert receiver.heard(A).sample.focus_distance_m == 3.0


class Broken:
    """A decoder with a fault that nobody has thought of."""

    lost = 0

    def samples(self, datagram, sender):
        if datagram == b"good":
            return (LensSample("A", f_stop=2.0),)
        raise KeyError(datagram)


def test_whatever_fails_is_counted_as_refused():
    hearing = Hearing(Broken())
    for datagram in (b"bad", b"good", b"bad"):
        hearing.take(datagram, ("stranger", 1))
    assert (hearing.taken, hearing.refused) == (1, 2)
    assert hearing.fault == "a datagram cannot be read"


def test_a_tracker_that_is_started_again_is_followed_when_the_old_one_is_silent():
    now = [100.0]
    sources = RingSources(lambda: now[0])

    def heard(*names: str) -> str:
        for name in names:
            now[0] += 0.1
            sources.keep(LensSample(name, f_stop=2.0))
        return sources.heard().sample.source

    assert heard("A", "B", "A") == "A"
    assert heard("new", "B") == "A"  # which is not silent yet
    now[0] += SILENT_AFTER_S
    assert heard("B") == "A"  # B is another camera, which was there before
    assert heard("B", "new") == "new"
    assert [sample.source for _, sample in sources.since(0)] == ["new", "new"]
    assert heard("A", "B") == "new"  # which speaks
    assert sources.heard("A").sample.source == "A"  # who asks for A gets A


def test_a_controller_that_rests_is_followed_on():
    now = [0.0]
    sources = RingSources(lambda: now[0], math.inf)
    for name in "AB":
        sources.keep(LensSample(name, channels={"/focus": 0.5}))
        now[0] += 1e6
    assert sources.heard().sample.source == "A"
