"""Datagrams of OpenTrackIO against the layout of the standard, bit by bit."""

import random
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.live.ring.hearing import MAX_SEGMENTS, MAX_SENDERS, Assembly
from heatlens.media.live.ring.opentrackio import (
    MAX_SAMPLE_BYTES,
    MAX_SEGMENT_BYTES,
    SEQUENCES,
    Encoding,
    RingPacketError,
    Segment,
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


def segments_of(text: bytes, sequence: int, count: int = 0, step: int = 1) -> list[Segment]:
    """Return a text in `count` segments, or as many as it needs.

    Each has a number `step` above that of the one before: 1, or 0 where samples are numbered.
    """
    size = -(-len(text) // count) if count else MAX_SEGMENT_BYTES
    offsets = range(0, max(len(text), 1), size)
    return [
        Segment(
            *(Encoding.JSON, (sequence + step * at) % SEQUENCES, offset),
            *(offset + size >= len(text), text[offset : offset + size]),
        )
        for at, offset in enumerate(offsets)
    ]


@given(st.binary(max_size=5 * MAX_SEGMENT_BYTES), st.integers(0, 2 * SEQUENCES))
def test_datagrams_have_a_number_each(text, sequence):
    found = [segment_of(it) for it in datagrams_of(text, Encoding.JSON, sequence)]
    assert found == segments_of(text, sequence)


@pytest.mark.parametrize("step", [0, 1], ids=["numbered samples", "numbered datagrams"])
@given(text=st.binary(max_size=5 * MAX_SEGMENT_BYTES), order=st.randoms())
def test_a_sample_arrives_whole_whatever_the_order_of_its_datagrams(step, text, order):
    segments = segments_of(text, SEQUENCES - 2, step=step)
    order.shuffle(segments)
    assembly = Assembly()
    texts = [assembly.add(("a", 1), it) for it in segments]
    assert texts[:-1] == [None] * (len(texts) - 1)
    assert texts[-1] == text


@pytest.mark.parametrize("step", [0, 1], ids=["numbered samples", "numbered datagrams"])
@given(
    texts=st.lists(st.binary(min_size=8, max_size=99), min_size=1, max_size=5),
    count=st.integers(1, 4),
    first=st.integers(0, SEQUENCES - 1),
)
def test_every_sample_of_a_sender_arrives(step, texts, count, first):
    assembly, got, number = Assembly(), [], first
    for text in texts:
        segments = segments_of(text, number, count, step)
        number += len(segments) if step else 1
        got += [assembly.add(("a", 1), it) for it in segments]
    assert ([it for it in got if it is not None], assembly.lost) == (texts, 0)


@given(
    texts=st.lists(st.binary(min_size=16, max_size=99), min_size=2, max_size=4, unique=True),
    lost=st.integers(0),
    twice=st.integers(0),
)
def test_a_lost_datagram_costs_its_sample_alone_and_one_sent_twice_none(texts, lost, twice):
    sent = [it for at, text in enumerate(texts) for it in segments_of(text, 1000 + 2 * at, 2)]
    gone, again = lost % len(sent), sent[twice % len(sent)]
    arriving = [it for at, it in enumerate(sent) if at != gone for _ in range(1 + (it is again))]
    assembly = Assembly()
    got = [assembly.add(("a", 1), it) for it in arriving]
    whole = [text for at, text in enumerate(texts) if at != gone // 2]
    assert [it for it in got if it is not None] == whole


def test_segments_of_two_samples_are_not_joined():
    first, second = segments_of(b"ab" * 40, 10, 2), segments_of(b"cd" * 40, 20, 2)
    assembly = Assembly()
    assert [assembly.add(("a",), it) for it in (first[0], second[1])] == [None, None]
    assert assembly.lost == 1
    assert [assembly.add(("a",), it) for it in segments_of(b"ef" * 40, 22, 2)][1] == b"ef" * 40


def held_bytes(assembly: Assembly) -> int:
    return sum(len(it.payload) for one in assembly._unfinished.values() for it in one.segments)


@given(
    st.lists(
        st.builds(
            Segment,
            st.sampled_from(Encoding),
            st.integers(0, 6) | st.integers(0, SEQUENCES - 1),
            st.integers(0, 4) | st.integers(0, MAX_SAMPLE_BYTES // 2),
            st.booleans(),
            st.binary(max_size=3) | st.integers(0, MAX_SAMPLE_BYTES // 2).map(bytes),
        ),
        max_size=40,
    )
)
def test_whatever_a_sender_sends_at_most_one_sample_is_held(segments):
    assembly = Assembly()
    for segment in segments:
        text = assembly.add(("a", 1), segment)
        assert text is None or len(text) <= MAX_SAMPLE_BYTES
        assert held_bytes(assembly) <= MAX_SAMPLE_BYTES


def test_segments_that_overlap_are_not_kept():
    assembly = Assembly()
    for offset in range(200):
        assembly.add(("a", 1), Segment(Encoding.JSON, 7, offset, False, bytes(32_000)))
    assert held_bytes(assembly) == 32_000
    assert assembly.lost == 199


def test_a_sample_in_thousands_of_segments_is_not_kept():
    assembly = Assembly()
    for offset in range(60_000, 55_000, -1):
        segment = Segment(Encoding.JSON, 7, offset, offset == 60_000, b"x")
        assert assembly.add(("a", 1), segment) is None
    (held,) = assembly._unfinished.values()
    assert len(held.segments) <= MAX_SEGMENTS


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
