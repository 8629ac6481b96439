"""Datagrams of OpenTrackIO against the layout of the standard, bit by bit."""

import random
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.ring.assembly import MAX_SENDERS, Assembly
from heatlens.ring.otrk_packet import (
    MAX_SAMPLE_BYTES,
    MAX_SEGMENT_BYTES,
    Encoding,
    RingPacketError,
    datagrams_of,
    fletcher16,
    segment_of,
)


def fletcher_by_hand(data: bytes) -> int:
    first = second = 0
    for byte in data:
        first = (first + byte) % 256
        second = (second + first) % 256
    return second << 8 | first


@given(st.binary(max_size=3000))
def test_the_checksum_is_fletchers(data):
    assert fletcher16(data) == fletcher_by_hand(data)


def test_the_header_lies_as_the_standard_says():
    (datagram,) = datagrams_of(b"{}", Encoding.JSON, 7)
    checksum = fletcher_by_hand(datagram[:14] + b"{}")
    assert datagram == struct.pack("!4sBBHIHH", b"OTrk", 0, 1, 7, 0, 0x8002, checksum) + b"{}"


@given(st.binary(max_size=5 * MAX_SEGMENT_BYTES), st.sampled_from(Encoding), st.randoms())
def test_a_sample_arrives_whole_whatever_the_order_of_its_datagrams(text, encoding, order):
    datagrams = list(datagrams_of(text, encoding, 70_000))
    order.shuffle(datagrams)
    assembly = Assembly()
    texts = [assembly.add(("a", 1), segment_of(it)) for it in datagrams]
    assert texts[:-1] == [None] * (len(texts) - 1)
    assert texts[-1] == text


@given(st.binary(min_size=1, max_size=200), st.data())
def test_a_changed_bit_is_never_taken(text, data):
    (datagram,) = datagrams_of(text, Encoding.CBOR, 1)
    bit = data.draw(st.integers(0, 8 * len(datagram) - 1))
    changed = bytearray(datagram)
    changed[bit // 8] ^= 1 << bit % 8
    with pytest.raises(RingPacketError):
        segment_of(bytes(changed))


@given(st.binary(max_size=100))
def test_noise_is_refused(noise):
    with pytest.raises(RingPacketError):
        segment_of(b"OTrk" + noise)


def test_a_sample_that_would_be_huge_is_refused():
    header = struct.pack("!4sBBHIH", b"OTrk", 0, 1, 0, MAX_SAMPLE_BYTES, 1)
    datagram = header + struct.pack("!H", fletcher_by_hand(header + b"x")) + b"x"
    with pytest.raises(RingPacketError, match="longer than"):
        segment_of(datagram)


def test_what_is_never_finished_is_counted_and_bounded():
    first, _ = datagrams_of(bytes(2000), Encoding.JSON, 0)
    assembly = Assembly()
    for sender in range(3 * MAX_SENDERS):
        assert assembly.add(("a", sender), segment_of(first)) is None
    assert assembly.lost == 2 * MAX_SENDERS
    assert len(assembly._unfinished) == MAX_SENDERS


def test_a_new_sample_replaces_the_unfinished_one():
    first, _ = (segment_of(it) for it in datagrams_of(bytes(2000), Encoding.JSON, 0))
    (whole,) = (segment_of(it) for it in datagrams_of(b"new", Encoding.JSON, 1))
    assembly = Assembly()
    assert assembly.add(("a",), first) is None
    assert assembly.add(("a",), whole) == b"new"
    assert assembly.lost == 1


def test_segments_of_two_senders_are_kept_apart():
    texts = {name: random.Random(name).randbytes(4000) for name in "ab"}
    pairs = zip(*(datagrams_of(text, Encoding.CBOR, 5) for text in texts.values()), strict=True)
    assembly, got = Assembly(), {}
    for pair in pairs:
        for name, datagram in zip(texts, pair, strict=True):
            got[name] = assembly.add((name,), segment_of(datagram))
    assert got == texts
