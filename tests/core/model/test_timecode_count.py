"""Timecode against counting all the frames of a day one by one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode, parse_timecode, timecode_in

DAY_S = 24 * 60 * 60
DROP = {29.97: (30, 2), 30000 / 1001: (30, 2), 59.94: (60, 4)}
SHOT = Shot(Lens(50.0, 2.0, 2.0, 36.0))


def day(whole: int, dropped: int) -> list[Timecode]:
    """Return what a clock shows on each frame of two hours, leaving out the dropped numbers."""
    return [
        Timecode(minute // 60, minute % 60, second, frame, dropped > 0)
        for minute in range(120)
        for second in range(60)
        for frame in range(whole)
        if not (frame < dropped and second == 0 and minute % 10)
    ]


@pytest.mark.parametrize("rate", DROP)
def test_drop_frame_counts_as_a_clock_that_leaves_numbers_out(rate):
    shown = day(*DROP[rate])
    zero = Timecode(0, 0, 0, 0, drop=True)
    for number in [*range(0, len(shown), 997), *range(1790, 1810), *range(17970, 18010)]:
        assert shown[number].count(rate) == number
        assert zero.later(number, rate) == shown[number]
        assert shown[number].later(-number, rate) == zero
    assert parse_timecode("01:00:00;00").count(rate) == len(shown) // 2


@given(st.sampled_from([24.0, 23.976, 25.0, 30.0, 29.97, 50.0, 59.94]), st.data())
def test_later_and_earlier_are_the_way_there_and_back(rate, data):
    drop = rate in DROP and data.draw(st.booleans())
    frames = st.integers(-3 * DAY_S * 24, 3 * DAY_S * 24)
    start = Timecode(data.draw(st.integers(0, 23)), 10, 7, 3, drop)
    there = start.later(later := data.draw(frames), rate)
    assert there.is_possible and there.fits(rate) and there.later(-later, rate) == start
    if 0 <= start.count(rate) + later < start.later(-1, rate).count(rate):
        assert there.count(rate) == start.count(rate) + later


def test_after_midnight_it_starts_at_zero():
    assert str(Timecode(23, 59, 59, 23).later(1, 24.0)) == "00:00:00:00"
    assert str(Timecode(0, 0, 0, 0).later(-1, 25.0)) == "23:59:59:24"
    assert str(Timecode(23, 59, 59, 29, drop=True).later(1, 29.97)) == "00:00:00;00"
    assert str(Timecode(0, 0, 0, 0, drop=True).later(-1, 29.97)) == "23:59:59;29"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("10:20:30:12", Timecode(10, 20, 30, 12)),
        (" 1:02:03:04 ", Timecode(1, 2, 3, 4)),
        ("10:20:30;12", Timecode(10, 20, 30, 12, drop=True)),
        ("10:20:30.12", Timecode(10, 20, 30, 12, drop=True)),
        ("23:59:59:99", Timecode(23, 59, 59, 99)),
        ("24:00:00:00", None),
        ("00:60:00:00", None),
        ("00:00:60:00", None),
        ("00:00:00", None),
        ("", None),
    ],
)
def test_a_text_is_a_timecode_that_a_clock_can_show(text, found):
    assert timecode_in(text) == found
    if found is None:
        with pytest.raises(InputError, match=r"10:00:00:00"):
            parse_timecode(text)
    else:
        assert parse_timecode(text) == found == parse_timecode(str(found))


@pytest.mark.parametrize(
    "wrong",
    [(-1, 0, 0, 0), (24, 0, 0, 0), (0, -1, 0, 0), (0, 60, 0, 0), (0, 0, 60, 0), (0, 0, 0, 100)],
)
def test_impossible_times(wrong):
    assert not Timecode(*wrong).is_possible and not Timecode(0, 0, 0, -1).is_possible
    assert Timecode(0, 0, 0, 0).is_possible and Timecode(23, 59, 59, 99).is_possible


def test_a_rate_has_the_frames_below_it_and_only_29_97_and_59_94_drop():
    assert Timecode(0, 0, 0, 23).fits(23.976) and not Timecode(0, 0, 0, 24).fits(23.976)
    assert "00 to 23" in Timecode(0, 0, 0, 24).why_not(24.0)
    dropping = Timecode(1, 0, 0, 0, drop=True)
    assert [rate for rate in (24, 25, 29.97, 30, 48, 50, 59.94) if dropping.fits(rate)] == [
        *(29.97, 30, 59.94)
    ]
    assert "write 01:00:00:00" in dropping.why_not(25.0)


def test_a_shot_counts_from_its_first_frame():
    shot = Shot(SHOT.lens, frames=FrameRange(101, 120)).started_at("01:00:00:00")
    assert str(shot.timecode_at(101)) == "01:00:00:00"
    assert str(shot.timecode_at(126)) == "01:00:01:01"
    assert str(shot.timecode_at(100, first=7)) == "00:59:59:23"
    still = SHOT.started_at("01:00:00:00")
    assert str(still.timecode_at(9)) == "01:00:00:00"
    assert str(still.timecode_at(9, first=7)) == "01:00:00:02"


def test_a_shot_without_a_start_shows_what_the_plate_says_where_it_fits():
    assert SHOT.timecode_at(9) is None
    assert SHOT.timecode_at(9, Timecode(1, 2, 3, 4)) == Timecode(1, 2, 3, 4)
    assert SHOT.timecode_at(9, Timecode(1, 2, 3, 24)) is None


@pytest.mark.parametrize("text", ["01:00:00:24", "01:00:00;00", "soon"])
def test_a_start_that_no_frame_of_the_rate_has_is_refused(text):
    with pytest.raises(InputError):
        SHOT.started_at(text)
