"""Test OpenTrackIO samples of a lens: written and read back, partial, and hostile."""

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
    format_sample,
    parse_sample,
    source_id,
)
from heatlens.media.live.ring.sources import LensSample
from support.opentrackio_samples import PUBLISHED, READ_AS, encoded_sample

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
def test_sample_of_reads_back_text_of_any_sample(encoding, sample):
    assert parse_sample(format_sample(sample, encoding), encoding) == sample


@given(sample=SAMPLES, name=st.text(st.characters(codec="utf-8"), max_size=20))
def test_sample_text_has_ids_as_the_standard_requires(sample, name):
    named = replace(sample, source=name)
    first, second = (json.loads(format_sample(named, Encoding.JSON)) for _ in range(2))
    assert UUID.fullmatch(first["sourceId"]) and UUID.fullmatch(first["sampleId"])
    assert first["sourceId"] == second["sourceId"]  # the same sender
    assert first["sampleId"] != second["sampleId"]  # another sample
    assert first["sourceNumber"] == 1
    assert source_id(name) != source_id(name + "x")


@pytest.mark.parametrize(
    ("rate", "exact"), [(24.0, (24, 1)), (23.976, (24000, 1001)), (59.94, (60000, 1001))]
)
def test_sample_text_has_exact_rate_as_fraction(rate, exact):
    sample = LensSample("A", timecode=Timecode(10, 0, 0, 0), frames_per_second=rate)
    timing = json.loads(format_sample(sample, Encoding.JSON))["timing"]
    written_as = dict(zip(("num", "denom"), exact, strict=True))
    assert timing["sampleRate"] == timing["timecode"]["frameRate"] == written_as


@pytest.mark.parametrize("name", ["sourceId", "sourceNumber"])
@pytest.mark.parametrize("number", [10**18, 2**63, -(2**63), 1 << 32_000], ids=int.bit_length)
def test_sample_of_limits_number_of_source(name, number):
    text = cbor2.dumps({name: number, "lens": {"fStop": 2.0}})
    sample = parse_sample(text, Encoding.CBOR)
    assert sample == LensSample(str(number) if number == 10**18 else "", f_stop=2.0)


@pytest.mark.parametrize("encoding", Encoding)
@pytest.mark.parametrize("name", PUBLISHED)
def test_sample_of_reads_examples_of_the_standard(name, encoding):
    assert parse_sample(encoded_sample(PUBLISHED[name], encoding), encoding) == READ_AS[name]


@given(before=SAMPLES, after=SAMPLES)
def test_sample_after_keeps_last_value_of_missing_fields(before, after):
    merged = after.filled_from(before)
    for name in ("focus_distance_m", "f_stop", "zoom_turn", "timecode"):
        new_value = getattr(after, name)
        assert getattr(merged, name) == (getattr(before, name) if new_value is None else new_value)


@pytest.mark.parametrize(
    "bad", [0, -1, "2", None, True, [], {}, float("nan"), float("inf"), 10**400]
)
@pytest.mark.parametrize("name", ["focusDistance", "fStop", "tStop", "pinholeFocalLength"])
def test_sample_of_omits_impossible_values(name, bad):
    text = json.dumps({"lens": {name: bad, "encoders": {"focus": 0.5}}}).encode()
    assert parse_sample(text, Encoding.JSON) == LensSample(focus_turn=0.5)


@pytest.mark.parametrize(
    ("encoder_value", "taken"), [(0, 0.0), (1, 1.0), (-1e-30, None), (1.01, None)]
)
def test_sample_of_accepts_encoder_values_from_0_to_1(encoder_value, taken):
    text = json.dumps({"lens": {"encoders": {"zoom": encoder_value}}}).encode()
    assert parse_sample(text, Encoding.JSON).zoom_turn == taken


@pytest.mark.parametrize("text", [b"", b"[]", b"1", b"{", b"\xff", b"[" * 60_000, b'"lens"'])
@pytest.mark.parametrize("encoding", Encoding)
def test_sample_of_rejects_text_that_is_no_sample(text, encoding):
    with pytest.raises(RingPacketError):
        parse_sample(text, encoding)


@given(st.binary(max_size=200))
def test_sample_of_any_bytes_gives_sample_or_packet_error(noise):
    for encoding in Encoding:
        try:
            assert isinstance(parse_sample(noise, encoding), LensSample)
        except RingPacketError:
            continue
