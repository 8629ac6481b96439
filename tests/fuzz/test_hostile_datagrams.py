"""Test that hostile datagrams sent to a real port change nothing and are all counted."""

import socket
import time

from ring_packets import hostile_datagrams

from heatlens.media.live.ring.address import Protocol, RingAddress
from heatlens.media.live.ring.opentrackio import source_id
from heatlens.media.live.ring.receiver import LensReceiver
from heatlens.media.live.ring.sender import LensSender
from heatlens.media.live.ring.sources import LensSample

SOURCE = source_id("A")

SEED = 20060106
FEW = 400
BATCH = 40  # so that a full buffer of the system drops none
PATIENCE_S = 60.0


def wait_until(is_so) -> None:
    end = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < end
        time.sleep(0.001)


def test_lens_receiver_counts_and_ignores_hostile_datagrams(request):
    minutes = request.config.getoption("--fuzz-minutes")
    count = round(100_000 * minutes) if minutes else FEW
    with (
        LensReceiver(RingAddress(Protocol.OPENTRACKIO, "127.0.0.1", 0)) as receiver,
        LensSender(receiver.address) as camera,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        camera.send(LensSample(SOURCE, focus_distance_m=2.0, f_stop=2.8))
        wait_until(lambda: receiver.source_state().version == 1)
        sample_before = receiver.source_state().sample
        for number, datagram in enumerate(hostile_datagrams(count, SEED), 1):
            stranger.sendto(datagram, (receiver.address.host, receiver.address.port))
            if number % BATCH == 0 or number == count:
                wait_until(lambda sent=number: receiver.refused == sent)
        assert receiver.source_state().sample == sample_before
        assert (receiver.source_state().version, receiver.accepted, receiver.refused) == (
            1,
            1,
            count,
        )
        camera.send(LensSample(SOURCE, focus_distance_m=3.0))
        wait_until(lambda: receiver.source_state().sample.focus_distance_m == 3.0)
