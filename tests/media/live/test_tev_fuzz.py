"""Test that the tev server survives any bytes, within its limits, and stays useful."""

import random
import struct
import tracemalloc

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tevclient import packet as client_packet

from heatlens.media.live.stream.images import TevImages
from heatlens.media.live.stream.protocol import (
    CreateImage,
    PacketStream,
    TevPacketError,
    TevStreamError,
    UpdateImage,
    parse_message,
)
from support.tev_packets import GOOD
from support.tev_peers import (
    CHANNELS,
    assert_shows,
    packet,
    picture,
    send,
    send_image,
    serving,
    settle,
)

MAX_VALUES = 4096


@st.composite
def damaged_packets(draw):
    """Return a packet with changed bytes and another end; its stated length is correct."""
    body = bytearray(draw(st.sampled_from(GOOD))[4:])
    for _ in range(draw(st.integers(0, 6))):
        body[draw(st.integers(0, min(len(body) - 1, 90)))] = draw(st.integers(0, 255))
    body = body[: draw(st.integers(0, len(body)))] + draw(st.binary(max_size=9))
    return struct.pack("<I", 4 + len(body)) + bytes(body)


@given(damaged_packets())
@settings(max_examples=400, deadline=None)
def test_message_of_any_packet_gives_message_or_error(data):
    images = TevImages(max_values=MAX_VALUES)
    images.apply(CreateImage(name="a", width=9, height=6, channels=tuple(CHANNELS)))
    try:
        message = parse_message(data[4:])
        if isinstance(message, UpdateImage):
            sizes = {tile.shape for tile in message.tiles.values()}
            assert len(sizes) == 1
            assert all(tile.size * 4 <= len(data) for tile in message.tiles.values())
        images.apply(message)
    except TevPacketError as error:
        assert str(error)
    assert images.value_count <= MAX_VALUES


@given(st.lists(st.sampled_from(GOOD), max_size=5), st.data())
@settings(max_examples=100, deadline=None)
def test_packet_stream_splits_stream_cut_anywhere(packets, data):
    """However the bytes are cut, the stream returns the packets that were joined."""
    remaining, stream, packets_read = b"".join(packets), PacketStream(), []
    while remaining:
        count = data.draw(st.integers(1, min(stream.expected_bytes, len(remaining))))
        packet = stream.feed(remaining[:count])
        remaining = remaining[count:]
        if packet is not None:
            packets_read.append(bytes(packet))
    assert packets_read == [one[4:] for one in packets] and stream.buffered_bytes == 0


@pytest.mark.parametrize("length", [0, 3, (1 << 28) + 1, 2**32 - 1])
def test_packet_stream_rejects_impossible_length(length):
    with pytest.raises(TevStreamError):
        PacketStream().feed(struct.pack("<I", length))


@pytest.fixture(scope="module")
def server():
    """Return one receiver for all examples; no example may harm the next."""
    with serving(images=TevImages(max_values=MAX_VALUES)) as server:
        yield server


def assert_still_useful(server):
    send_image(server, "good", picture())
    assert_shows(server.snapshot("good"), picture())
    assert server._images.value_count <= MAX_VALUES
    assert not server._clients


@given(st.lists(damaged_packets(), max_size=6), st.data())
@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
def test_tev_server_survives_damaged_packets(server, packets, data):
    stream = b"".join(packets)
    send(server, stream[: data.draw(st.integers(0, len(stream)))])
    assert_still_useful(server)


@given(st.binary(max_size=300))
@settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
def test_tev_server_survives_noise(server, data):
    send(server, data)
    assert_still_useful(server)


def test_tev_snapshot_of_damaged_image_is_plate_or_message(server):
    """The channels may hold any bits."""
    rng = random.Random(4)
    for _ in range(40):
        values = np.frombuffer(rng.randbytes(9 * 6 * 4 * 4), "<f4").reshape(6, 9, 4)
        values = np.where(rng.random() < 0.5, values, np.float32(rng.choice([0, np.nan])))
        send(server, bytes(client_packet.create_image("bits", 9, 6, CHANNELS)))
        send(server, bytes(client_packet.update_image("bits", values, CHANNELS)))
        settle(server)
        plate = server.snapshot("bits")
        if plate is None:
            assert "bits" in server.problem
        else:
            assert np.isfinite(plate.color).all() and (plate.depth_m > 0).all()


def test_tev_server_allocates_memory_for_received_bytes_only(server):
    huge_length = struct.pack("<I", 1 << 28)
    huge = packet(4, True, "huge", 16384, 16384, 64, *map(str, range(64)))
    tracemalloc.start()
    try:
        for start in (
            huge_length + bytes(100),
            huge,
            packet(3, True, "a", "R", 0, 0, 16384, 16384),
        ):
            send(server, start)
        assert_still_useful(server)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 8 << 20
