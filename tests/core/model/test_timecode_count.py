"""Compare timecode arithmetic with timecodes that are enumerated frame by frame."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode, parse_timecode, try_parse_timecode

DAY_S = 24 * 60 * 60
DROP = {29.97: (30, 2), 30000 / 1001: (30, 2), 59.94: (60, 4)}
SHOT = Shot(Lens(50.0, 2.0, 2.0, 36.0))


def two_hours_of_timecodes(whole: int, dropped: int) -> list[Timecode]:
    """Return the timecodes of all frames of two hours, without the dropped frame numbers."""
    return [
        Timecode(minute // 60, minute % 60, second, frame, dropped > 0)
        for minute in range(120)
        for second in range(60)
        for frame in range(whole)
        if not (frame < dropped and second == 0 and minute % 10)
    ]


@pytest.mark.parametrize("rate", DROP)
def test_drop_frame_count_agrees_with_enumerated_timecodes(rate):
    clock_timecodes = two_hours_of_timecodes(*DROP[rate])
    zero = Timecode(hours=0, minutes=0, seconds=0, frames=0, drop=True)
    for number in [*range(0, len(clock_timecodes), 997), *range(1790, 1810), *range(17970, 18010)]:
        assert clock_timecodes[number].count(rate) == number
        assert zero.add_frames(number, rate) == clock_timecodes[number]
        assert clock_timecodes[number].add_frames(-number, rate) == zero
    assert parse_timecode("01:00:00;00").count(rate) == len(clock_timecodes) // 2


@given(st.sampled_from([24.0, 23.976, 25.0, 30.0, 29.97, 50.0, 59.94]), st.data())
def test_timecode_later_and_back_returns_to_start(rate, data):
    drop = rate in DROP and data.draw(st.booleans())
    frames = st.integers(-3 * DAY_S * 24, 3 * DAY_S * 24)
    start = Timecode(data.draw(st.integers(0, 23)), 10, 7, 3, drop)
    later_timecode = start.add_frames(later := data.draw(frames), rate)
    assert (
        later_timecode.is_possible
        and later_timecode.fits(rate)
        and later_timecode.add_frames(-later, rate) == start
    )
    if 0 <= start.count(rate) + later < start.add_frames(-1, rate).count(rate):
        assert later_timecode.count(rate) == start.count(rate) + later


def test_timecode_wraps_at_midnight():
    assert str(Timecode(23, 59, 59, 23).add_frames(1, 24.0)) == "00:00:00:00"
    assert str(Timecode(0, 0, 0, 0).add_frames(-1, 25.0)) == "23:59:59:24"
    assert str(Timecode(23, 59, 59, 29, drop=True).add_frames(1, 29.97)) == "00:00:00;00"
    assert str(Timecode(0, 0, 0, 0, drop=True).add_frames(-1, 29.97)) == "23:59:59;29"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10:20:30:12", Timecode(hours=10, minutes=20, seconds=30, frames=12)),
        (" 1:02:03:04 ", Timecode(hours=1, minutes=2, seconds=3, frames=4)),
        ("10:20:30;12", Timecode(hours=10, minutes=20, seconds=30, frames=12, drop=True)),
        ("10:20:30.12", Timecode(hours=10, minutes=20, seconds=30, frames=12, drop=True)),
        ("23:59:59:99", Timecode(hours=23, minutes=59, seconds=59, frames=99)),
        ("24:00:00:00", None),
        ("00:60:00:00", None),
        ("00:00:60:00", None),
        ("00:00:00", None),
        ("", None),
    ],
)
def test_parse_timecode_reads_valid_and_rejects_impossible_text(text, expected):
    assert try_parse_timecode(text) == expected
    if expected is None:
        with pytest.raises(InputError, match=r"10:00:00:00"):
            parse_timecode(text)
    else:
        assert parse_timecode(text) == expected == parse_timecode(str(expected))


@pytest.mark.parametrize(
    "wrong",
    [(-1, 0, 0, 0), (24, 0, 0, 0), (0, -1, 0, 0), (0, 60, 0, 0), (0, 0, 60, 0), (0, 0, 0, 100)],
)
def test_timecode_is_possible_only_within_clock_ranges(wrong):
    assert not Timecode(*wrong).is_possible and not Timecode(0, 0, 0, -1).is_possible
    assert Timecode(0, 0, 0, 0).is_possible and Timecode(23, 59, 59, 99).is_possible


def test_timecode_fits_only_rates_with_its_frame_and_drop_kind():
    assert Timecode(0, 0, 0, 23).fits(23.976) and not Timecode(0, 0, 0, 24).fits(23.976)
    assert "00 to 23" in Timecode(hours=0, minutes=0, seconds=0, frames=24).mismatch_message(24.0)
    dropping = Timecode(hours=1, minutes=0, seconds=0, frames=0, drop=True)
    assert [rate for rate in (24, 25, 29.97, 30, 48, 50, 59.94) if dropping.fits(rate)] == [
        *(29.97, 30, 59.94)
    ]
    assert "write 01:00:00:00" in dropping.mismatch_message(25.0)


def test_timecode_at_counts_from_first_frame_of_shot():
    shot = Shot(SHOT.lens, frames=FrameRange(101, 120)).with_start_timecode("01:00:00:00")
    assert str(shot.timecode_at(101)) == "01:00:00:00"
    assert str(shot.timecode_at(126)) == "01:00:01:01"
    assert str(shot.timecode_at(100, first_frame=7)) == "00:59:59:23"
    shot_without_frames = SHOT.with_start_timecode("01:00:00:00")
    assert str(shot_without_frames.timecode_at(9)) == "01:00:00:00"
    assert str(shot_without_frames.timecode_at(9, first_frame=7)) == "01:00:00:02"


def test_timecode_at_without_start_uses_plate_timecode_if_it_fits():
    assert SHOT.timecode_at(9) is None
    assert SHOT.timecode_at(9, Timecode(1, 2, 3, 4)) == Timecode(1, 2, 3, 4)
    assert SHOT.timecode_at(9, Timecode(hours=1, minutes=2, seconds=3, frames=24)) is None


@pytest.mark.parametrize("text", ["01:00:00:24", "01:00:00;00", "soon"])
def test_with_start_timecode_rejects_timecode_not_of_the_rate(text):
    with pytest.raises(InputError):
        SHOT.with_start_timecode(text)
