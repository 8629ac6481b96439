"""Timecode: read from the header of a plate, counted on, and written as SMPTE ST 12-1 shows it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import OpenEXR

# The standard entry of EXR first, then those in which programs pass on what a clip had.
_ENTRIES = (
    "timeCode",
    "nuke/input/timecode",
    "timecode",
    "smpte:TimeCode",
    "interim.clip.timecode",
)
_TEXT = re.compile(r"(\d{1,2}):(\d{2}):(\d{2})([:;.])(\d{2})")
_EXR_FRAMES_MOST = 29
_DROP_MINUTES = 10  # of which the first drops no numbers


@dataclass(frozen=True)
class Timecode:
    """Hours, minutes, seconds and frames; `drop` for the count of 29.97 and 59.94 a second."""

    hours: int
    minutes: int
    seconds: int
    frames: int
    drop: bool = False

    def __str__(self) -> str:
        sign = ";" if self.drop else ":"
        return f"{self.hours:02}:{self.minutes:02}:{self.seconds:02}{sign}{self.frames:02}"

    def fits(self, frames_per_second: float) -> bool:
        """Return whether a second of this rate has such a frame, and drops numbers likewise."""
        whole = round(frames_per_second)
        return self.frames < whole and (not self.drop or whole in (30, 60))

    def later(self, frames: int, frames_per_second: float) -> "Timecode":
        """Return the timecode so many frames later, or earlier.

        After midnight it starts at zero.
        """
        whole = round(frames_per_second)
        count = self._count(whole) + frames
        return _at(count, whole, self.drop)

    def _count(self, whole: int) -> int:
        """Count the frames since midnight."""
        minutes = 60 * self.hours + self.minutes
        count = (60 * minutes + self.seconds) * whole + self.frames
        if self.drop:
            count -= _dropped_a_minute(whole) * (minutes - minutes // _DROP_MINUTES)
        return count


def timecode_of(attributes: Mapping[str, Any]) -> Timecode | None:
    """Return the timecode of a plate's header; None where there is none that is possible."""
    for entry in _ENTRIES:
        value = attributes.get(entry)
        found = _of_text(value) if isinstance(value, str) else _of_exr(value)
        if found is not None:
            return found
    return None


def exr_timecode(timecode: Timecode) -> Any | None:
    """Return the value of EXR's entry `timeCode`; None for frames beyond 29, which do not fit."""
    if timecode.frames > _EXR_FRAMES_MOST:
        return None
    value = OpenEXR.TimeCode()
    value.hours, value.minutes = timecode.hours, timecode.minutes
    value.seconds, value.frame = timecode.seconds, timecode.frames
    value.dropFrame = timecode.drop
    return value


def _of_text(text: str) -> Timecode | None:
    match = _TEXT.fullmatch(text.strip())
    if match is None:
        return None
    hours, minutes, seconds, sign, frames = match.groups()
    numbers = int(hours), int(minutes), int(seconds), int(frames)
    return _checked(*numbers, drop=sign != ":")


def _of_exr(value: Any) -> Timecode | None:
    if not isinstance(value, OpenEXR.TimeCode):
        return None
    numbers = value.hours, value.minutes, value.seconds, value.frame
    return _checked(*numbers, drop=bool(value.dropFrame))


def _checked(hours: int, minutes: int, seconds: int, frames: int, drop: bool) -> Timecode | None:
    """Return the timecode, or None for one that no clock shows."""
    if not (0 <= hours < 24 and 0 <= minutes < 60 and 0 <= seconds < 60 and 0 <= frames < 100):
        return None
    return Timecode(hours, minutes, seconds, frames, drop)


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
