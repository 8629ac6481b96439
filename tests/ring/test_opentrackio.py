"""What a sample tells of the lens: written and read again, partial, hostile."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.ring.lens_sample import LensSample
from heatlens.ring.opentrackio import sample_of, text_of
from heatlens.ring.otrk_packet import Encoding, RingPacketError
from support.opentrackio_samples import PUBLISHED, READ_AS, written

POSITIVE = st.none() | st.floats(1e-3, 1e6)
TURNS = st.none() | st.floats(0.0, 1.0)
SAMPLES = st.builds(
    LensSample,
    source=st.text("urn:-abc 123", max_size=40),
    **dict.fromkeys(("focus_distance_m", "f_stop", "t_stop", "focal_length_mm"), POSITIVE),
    **dict.fromkeys(("focus_turn", "iris_turn", "zoom_turn"), TURNS),
    timecode=st.none() | st.tuples(st.integers(0, 23), *[st.integers(0, 59)] * 3),
)


@pytest.mark.parametrize("encoding", Encoding)
@given(sample=SAMPLES)
def test_what_is_written_is_read(encoding, sample):
    assert sample_of(text_of(sample, encoding, 24.0), encoding) == sample


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
