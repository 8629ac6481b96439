"""Count and write timecode as in SMPTE ST 12-1."""

import re
from dataclasses import dataclass, replace

from heatlens.core.base.errors import InputError

_TEXT = re.compile(r"(\d{1,2}):(\d{2}):(\d{2})([:;.])(\d{2})")
_DROP_RATES = 30, 60  # frames per second, rounded, whose timecode can drop frame numbers
_DROP_MINUTES = 10  # the first of every ten minutes drops no numbers


@dataclass(frozen=True)
class Timecode:
    """Hours, minutes, seconds and frames; `drop` is drop-frame counting at 29.97 and 59.94 fps."""

    hours: int
    minutes: int
    seconds: int
    frames: int
    drop: bool = False

    def __str__(self) -> str:
        sign = ";" if self.drop else ":"
        return f"{self.hours:02}:{self.minutes:02}:{self.seconds:02}{sign}{self.frames:02}"

    @property
    def is_possible(self) -> bool:
        """True if a clock can show it."""
        sixties = (self.minutes, self.seconds)
        is_time = 0 <= self.hours < 24 and all(0 <= value < 60 for value in sixties)
        return is_time and 0 <= self.frames < 100

    def fits(self, frames_per_second: float) -> bool:
        """Return whether this timecode exists at this rate, with or without dropped numbers."""
        return not self.mismatch_message(frames_per_second)

    def mismatch_message(self, frames_per_second: float) -> str:
        """Return a sentence on why no frame of this rate has this timecode; "" if one has it.

        Source: SMPTE ST 12-1, which drops numbers at 30 and 60 frames a second over 1.001 alone.
        """
        rate_text = f"{frames_per_second:.5g} frames a second"
        rounded_rate = round(frames_per_second)
        if self.frames >= rounded_rate:
            return (
                f"{self} is not a timecode at {rate_text}: frames go from 00 to "
                f"{rounded_rate - 1:02}."
            )
        if self.drop and rounded_rate not in _DROP_RATES:
            return (
                f"{self} is drop-frame, which exists only at 29.97 and 59.94 frames a second, not "
                f"at {rate_text}: write {replace(self, drop=False)}."
            )
        return ""

    def add_frames(self, frames: int, frames_per_second: float) -> "Timecode":
        """Return the timecode `frames` frames later, or earlier if negative.

        After midnight it starts at zero.
        """
        frame_count = self.count(frames_per_second) + frames
        return _timecode_of_count(frame_count, round(frames_per_second), self.drop)

    def count(self, frames_per_second: float) -> int:
        """Return the number of frames since midnight."""
        rounded_rate = round(frames_per_second)
        minutes = 60 * self.hours + self.minutes
        count = (60 * minutes + self.seconds) * rounded_rate + self.frames
        if self.drop:
            count -= _dropped_a_minute(rounded_rate) * (minutes - minutes // _DROP_MINUTES)
        return count


def try_parse_timecode(text: str) -> Timecode | None:
    """Return the timecode in a text; None if it is not a valid one."""
    match = _TEXT.fullmatch(text.strip())
    if match is None:
        return None
    hours, minutes, seconds, sign, frames = match.groups()
    timecode = Timecode(int(hours), int(minutes), int(seconds), int(frames), sign != ":")
    return timecode if timecode.is_possible else None


def parse_timecode(text: str) -> Timecode:
    """Return the timecode of a text. Raises InputError if it is none."""
    timecode = try_parse_timecode(text)
    if timecode is None:
        raise InputError(
            f"{text!r} is not a timecode. Example: 10:00:00:00, or 10:00:00;00 for drop frames."
        )
    return timecode


def timecode_at(count: float, frames_per_second: float) -> Timecode:
    """Return the timecode, without dropped numbers, of a count of frames since midnight."""
    return _timecode_of_count(round(count), round(frames_per_second), drop=False)


def _dropped_a_minute(rounded_rate: int) -> int:
    """Return the frame numbers dropped in every minute but each tenth: two of 30, four of 60."""
    return rounded_rate // 15


def _timecode_of_count(count: int, rounded_rate: int, drop: bool) -> Timecode:
    """Return the timecode of the frame with number `count`, counted from 0 at midnight.

    With `drop`, the numbers that drop-frame counting skips are added to `count` first.
    """
    if drop:
        dropped = _dropped_a_minute(rounded_rate)
        minute_frames = 60 * rounded_rate - dropped
        ten_minute_frames = _DROP_MINUTES * minute_frames + dropped
        count %= 144 * ten_minute_frames  # a day
        ten_minutes, remaining_frames = divmod(count, ten_minute_frames)
        count += ten_minutes * (_DROP_MINUTES - 1) * dropped
        if remaining_frames >= 60 * rounded_rate:
            count += dropped * (1 + (remaining_frames - 60 * rounded_rate) // minute_frames)
    seconds, frames = divmod(count, rounded_rate)
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    return Timecode(hours % 24, minutes, seconds, frames, drop)
