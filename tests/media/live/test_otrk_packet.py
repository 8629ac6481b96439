"""Test datagrams of OpenTrackIO against the layout of the standard, bit by bit."""

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
    fletcher16,
    parse_segment,
    split_into_datagrams,
)

# Numbers of the header, as the standard gives them.
RESERVED, JSON_CODE, LAST_DATAGRAM = 0, 1, 0x8000
HEADER_BYTES_SUMMED = 14  # the header before its checksum


def expected_fletcher16(data: bytes) -> int:
    first = second = 0
    for byte in data:
        first = (first + byte) % 256
        second = (second + first) % 256
    return second << 8 | first


@given(st.binary(max_size=3000))
def test_fletcher16_matches_reference_checksum(data):
    assert fletcher16(data) == expected_fletcher16(data)


def test_datagram_header_has_layout_of_the_standard():
    sequence_number, offset, payload = 7, 0, b"{}"
    (datagram,) = split_into_datagrams(payload, Encoding.JSON, sequence_number)
    checksum = expected_fletcher16(datagram[:HEADER_BYTES_SUMMED] + payload)
    numbers = RESERVED, JSON_CODE, sequence_number, offset, LAST_DATAGRAM | len(payload), checksum
    assert datagram == struct.pack("!4sBBHIHH", b"OTrk", *numbers) + payload


def segments_of(text: bytes, sequence: int, count: int = 0, step: int = 1) -> list[Segment]:
    """Return a text in `count` segments, or in as many as it needs if `count` is 0. `step` is the
    difference of their sequence numbers: 1, or 0 where samples are numbered.
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
def test_datagrams_are_numbered_one_by_one(text, sequence):
    segments = [parse_segment(it) for it in split_into_datagrams(text, Encoding.JSON, sequence)]
    assert segments == segments_of(text, sequence)


@pytest.mark.parametrize("step", [0, 1], ids=["numbered samples", "numbered datagrams"])
@given(text=st.binary(max_size=5 * MAX_SEGMENT_BYTES), order=st.randoms())
def test_assembly_joins_segments_in_any_order(step, text, order):
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
    first_number=st.integers(0, SEQUENCES - 1),
)
def test_assembly_returns_every_sample_of_a_sender(step, texts, count, first_number):
    assembly, received, number = Assembly(), [], first_number
    for text in texts:
        segments = segments_of(text, number, count, step)
        number += len(segments) if step else 1
        received += [assembly.add(("a", 1), it) for it in segments]
    assert ([it for it in received if it is not None], assembly.lost) == (texts, 0)


@given(
    texts=st.lists(st.binary(min_size=16, max_size=99), min_size=2, max_size=4, unique=True),
    lost=st.integers(0),
    twice=st.integers(0),
)
def test_assembly_loses_only_sample_of_lost_datagram_and_ignores_repeats(texts, lost, twice):
    sent = [it for at, text in enumerate(texts) for it in segments_of(text, 1000 + 2 * at, 2)]
    gone, again = lost % len(sent), sent[twice % len(sent)]
    arriving = [it for at, it in enumerate(sent) if at != gone for _ in range(1 + (it is again))]
    assembly = Assembly()
    got = [assembly.add(("a", 1), it) for it in arriving]
    whole = [text for at, text in enumerate(texts) if at != gone // 2]
    assert [it for it in got if it is not None] == whole


def test_assembly_does_not_join_segments_of_two_samples():
    first = segments_of(b"ab" * 40, sequence=10, count=2)
    second = segments_of(b"cd" * 40, sequence=20, count=2)
    assembly = Assembly()
    assert [assembly.add(("a",), it) for it in (first[0], second[1])] == [None, None]
    assert assembly.lost == 1
    third = segments_of(b"ef" * 40, sequence=22, count=2)
    assert [assembly.add(("a",), it) for it in third] == [None, b"ef" * 40]


def stored_bytes(assembly: Assembly) -> int:
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
def test_assembly_stores_at_most_one_sample_per_sender(segments):
    assembly = Assembly()
    for segment in segments:
        text = assembly.add(("a", 1), segment)
        assert text is None or len(text) <= MAX_SAMPLE_BYTES
        assert stored_bytes(assembly) <= MAX_SAMPLE_BYTES


def test_assembly_drops_overlapping_segments():
    assembly = Assembly()
    for offset in range(200):
        assembly.add(
            ("a", 1), Segment(Encoding.JSON, 7, offset, is_last=False, payload=bytes(32_000))
        )
    assert stored_bytes(assembly) == 32_000
    assert assembly.lost == 199


def test_assembly_drops_sample_of_thousands_of_segments():
    assembly = Assembly()
    for offset in range(60_000, 55_000, -1):
        segment = Segment(Encoding.JSON, 7, offset, offset == 60_000, b"x")
        assert assembly.add(("a", 1), segment) is None
    (unfinished,) = assembly._unfinished.values()
    assert len(unfinished.segments) <= MAX_SEGMENTS


@given(st.binary(min_size=1, max_size=200), st.data())
def test_parse_segment_rejects_datagram_with_a_changed_bit(text, data):
    (datagram,) = split_into_datagrams(text, Encoding.CBOR, 1)
    bit = data.draw(st.integers(0, 8 * len(datagram) - 1))
    changed = bytearray(datagram)
    changed[bit // 8] ^= 1 << bit % 8
    with pytest.raises(RingPacketError):
        parse_segment(bytes(changed))


@given(st.binary(max_size=100))
def test_parse_segment_rejects_noise(noise):
    with pytest.raises(RingPacketError):
        parse_segment(b"OTrk" + noise)


def test_parse_segment_rejects_huge_sample():
    sequence_number, offset, length = 0, MAX_SAMPLE_BYTES, 1
    numbers = RESERVED, JSON_CODE, sequence_number, offset, length
    header = struct.pack("!4sBBHIH", b"OTrk", *numbers)
    datagram = header + struct.pack("!H", expected_fletcher16(header + b"x")) + b"x"
    with pytest.raises(RingPacketError, match="longer than"):
        parse_segment(datagram)


def test_assembly_counts_and_limits_unfinished_samples():
    first, _ = split_into_datagrams(bytes(2000), Encoding.JSON, 0)
    assembly = Assembly()
    for sender in range(3 * MAX_SENDERS):
        assert assembly.add(("a", sender), parse_segment(first)) is None
    assert assembly.lost == 2 * MAX_SENDERS
    assert len(assembly._unfinished) == MAX_SENDERS


def test_assembly_replaces_unfinished_sample_by_newer_one():
    first, _ = (parse_segment(it) for it in split_into_datagrams(bytes(2000), Encoding.JSON, 0))
    (whole,) = (parse_segment(it) for it in split_into_datagrams(b"new", Encoding.JSON, 1))
    assembly = Assembly()
    assert assembly.add(("a",), first) is None
    assert assembly.add(("a",), whole) == b"new"
    assert assembly.lost == 1


def test_assembly_keeps_segments_of_two_senders_apart():
    texts = {name: random.Random(name).randbytes(4000) for name in "ab"}
    pairs = zip(
        *(split_into_datagrams(text, Encoding.CBOR, 5) for text in texts.values()), strict=True
    )
    assembly, received = Assembly(), {}
    for pair in pairs:
        for name, datagram in zip(texts, pair, strict=True):
            received[name] = assembly.add((name,), parse_segment(datagram))
    assert received == texts
