"""What a sample tells of the lens: written and read again, partial, hostile."""

import json
import re
from dataclasses import replace

import cbor2
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.timecode import Timecode
from heatlens.media.live.ring.opentrackio import (
    Encoding,
    RingPacketError,
    sample_of,
    source_id,
    text_of,
)
from heatlens.media.live.ring.sources import LensSample
from support.opentrackio_samples import PUBLISHED, READ_AS, written

POSITIVE = st.none() | st.floats(1e-3, 1e6)
TURNS = st.none() | st.floats(0.0, 1.0)
SAMPLES = st.builds(
    LensSample,
    source=st.text("urn:-abc 123", max_size=40).map(source_id),
    **dict.fromkeys(("focus_distance_m", "f_stop", "t_stop", "focal_length_mm"), POSITIVE),
    **dict.fromkeys(("focus_turn", "iris_turn", "zoom_turn"), TURNS),
    timecode=st.none()
    | st.builds(Timecode, st.integers(0, 23), *[st.integers(0, 59)] * 3, st.booleans()),
    frames_per_second=st.sampled_from((24000 / 1001, 24.0, 25.0, 30000 / 1001, 60.0)),
)
UUID = re.compile(r"urn:uuid:[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")  # as the standard has it


@pytest.mark.parametrize("encoding", Encoding)
@given(sample=SAMPLES)
def test_what_is_written_is_read(encoding, sample):
    assert sample_of(text_of(sample, encoding), encoding) == sample


@given(sample=SAMPLES, name=st.text(st.characters(codec="utf-8"), max_size=20))
def test_what_is_written_is_named_as_the_standard_asks(sample, name):
    named = replace(sample, source=name)
    first, second = (json.loads(text_of(named, Encoding.JSON)) for _ in range(2))
    assert UUID.fullmatch(first["sourceId"]) and UUID.fullmatch(first["sampleId"])
    assert first["sourceId"] == second["sourceId"]  # the same sender
    assert first["sampleId"] != second["sampleId"]  # another sample
    assert first["sourceNumber"] == 1
    assert source_id(name) != source_id(name + "x")


@pytest.mark.parametrize(
    ("rate", "exact"), [(24.0, (24, 1)), (23.976, (24000, 1001)), (59.94, (60000, 1001))]
)
def test_the_rate_is_exact(rate, exact):
    sample = LensSample("A", timecode=Timecode(10, 0, 0, 0), frames_per_second=rate)
    timing = json.loads(text_of(sample, Encoding.JSON))["timing"]
    written_as = dict(zip(("num", "denom"), exact, strict=True))
    assert timing["sampleRate"] == timing["timecode"]["frameRate"] == written_as


@pytest.mark.parametrize("name", ["sourceId", "sourceNumber"])
@pytest.mark.parametrize("number", [10**18, 2**63, -(2**63), 1 << 32_000], ids=int.bit_length)
def test_a_source_is_numbered_within_bounds(name, number):
    text = cbor2.dumps({name: number, "lens": {"fStop": 2.0}})
    found = sample_of(text, Encoding.CBOR)
    assert found == LensSample(str(number) if number == 10**18 else "", f_stop=2.0)


@pytest.mark.parametrize("encoding", Encoding)
@pytest.mark.parametrize("name", PUBLISHED)
def test_the_examples_of_the_standard_are_read(name, encoding):
    assert sample_of(written(PUBLISHED[name], encoding), encoding) == READ_AS[name]


@given(before=SAMPLES, after=SAMPLES)
def test_what_is_absent_keeps_its_last_value(before, after):
    kept = after.after(before)
    for name in ("focus_distance_m", "f_stop", "zoom_turn", "timecode"):
        now = getattr(after, name)
        assert getattr(kept, name) == (getattr(before, name) if now is None else now)


@pytest.mark.parametrize(
    "bad", [0, -1, "2", None, True, [], {}, float("nan"), float("inf"), 10**400]
)
@pytest.mark.parametrize("name", ["focusDistance", "fStop", "tStop", "pinholeFocalLength"])
def test_a_value_that_cannot_be_is_left_out(name, bad):
    text = json.dumps({"lens": {name: bad, "encoders": {"focus": 0.5}}}).encode()
    assert sample_of(text, Encoding.JSON) == LensSample(focus_turn=0.5)


@pytest.mark.parametrize(("told", "taken"), [(0, 0.0), (1, 1.0), (-1e-30, None), (1.01, None)])
def test_a_ring_stands_between_its_ends(told, taken):
    text = json.dumps({"lens": {"encoders": {"zoom": told}}}).encode()
    assert sample_of(text, Encoding.JSON).zoom_turn == taken


@pytest.mark.parametrize("text", [b"", b"[]", b"1", b"{", b"\xff", b"[" * 60_000, b'"lens"'])
@pytest.mark.parametrize("encoding", Encoding)
def test_what_is_no_sample_is_refused(text, encoding):
    with pytest.raises(RingPacketError):
        sample_of(text, encoding)


@given(st.binary(max_size=200))
def test_noise_is_a_sample_or_refused(noise):
    for encoding in Encoding:
        try:
            assert isinstance(sample_of(noise, encoding), LensSample)
        except RingPacketError:
            continue
