"""Count and write timecode as in SMPTE ST 12-1."""

import re
from dataclasses import dataclass, replace

from heatlens.core.base.errors import InputError

_TEXT = re.compile(r"(\d{1,2}):(\d{2}):(\d{2})([:;.])(\d{2})")
_DROPPING = 30, 60  # frames per second, rounded, whose timecode can drop frame numbers
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
        """Return True if a clock can show it."""
        sixties = (self.minutes, self.seconds)
        is_time = 0 <= self.hours < 24 and all(0 <= value < 60 for value in sixties)
        return is_time and 0 <= self.frames < 100

    def fits(self, frames_per_second: float) -> bool:
        """Return whether this timecode exists at this rate, with or without dropped numbers."""
        return not self.why_not(frames_per_second)

    def why_not(self, frames_per_second: float) -> str:
        """Return a sentence that says why no frame of this rate has this timecode; "" if one has.

        Source: SMPTE ST 12-1, which drops numbers at 30 and 60 frames a second over 1.001 alone.
        """
        rate, whole = f"{frames_per_second:.5g} frames a second", round(frames_per_second)
        if self.frames >= whole:
            return f"{self} is not a timecode at {rate}: frames go from 00 to {whole - 1:02}."
        if self.drop and whole not in _DROPPING:
            return (
                f"{self} is drop-frame, which exists only at 29.97 and 59.94 frames a second, not "
                f"at {rate}: write {replace(self, drop=False)}."
            )
        return ""

    def later(self, frames: int, frames_per_second: float) -> "Timecode":
        """Return the timecode so many frames later, or earlier.

        After midnight it starts at zero.
        """
        count = self.count(frames_per_second) + frames
        return _at(count, round(frames_per_second), self.drop)

    def count(self, frames_per_second: float) -> int:
        """Return the number of frames since midnight."""
        whole = round(frames_per_second)
        minutes = 60 * self.hours + self.minutes
        count = (60 * minutes + self.seconds) * whole + self.frames
        if self.drop:
            count -= _dropped_a_minute(whole) * (minutes - minutes // _DROP_MINUTES)
        return count


def timecode_in(text: str) -> Timecode | None:
    """Return the timecode in a text; None if it is not a valid one."""
    match = _TEXT.fullmatch(text.strip())
    if match is None:
        return None
    hours, minutes, seconds, sign, frames = match.groups()
    timecode = Timecode(int(hours), int(minutes), int(seconds), int(frames), sign != ":")
    return timecode if timecode.is_possible else None


def parse_timecode(text: str) -> Timecode:
    """Return the timecode of a text. Raises InputError if it is none."""
    timecode = timecode_in(text)
    if timecode is None:
        raise InputError(
            f"{text!r} is not a timecode. Example: 10:00:00:00, or 10:00:00;00 for drop frames."
        )
    return timecode


def timecode_at(count: float, frames_per_second: float) -> Timecode:
    """Return the timecode, without dropped numbers, of a count of frames since midnight."""
    return _at(round(count), round(frames_per_second), drop=False)


def _dropped_a_minute(whole: int) -> int:
    """Return the frame numbers dropped in every minute but each tenth: two of 30, four of 60."""
    return whole // 15


def _at(count: int, whole: int, drop: bool) -> Timecode:
    """Return the timecode of a frame counted from midnight."""
    if drop:
        lost = _dropped_a_minute(whole)
        minute = 60 * whole - lost
        ten = _DROP_MINUTES * minute + lost
        count %= 144 * ten
        tens, rest = divmod(count, ten)
        count += tens * (_DROP_MINUTES - 1) * lost
        if rest >= 60 * whole:
            count += lost * (1 + (rest - 60 * whole) // minute)
    seconds, frames = divmod(count, whole)
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    return Timecode(hours % 24, minutes, seconds, frames, drop)
