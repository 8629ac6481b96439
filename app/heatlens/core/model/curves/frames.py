"""Which frames a shot has, and how fast they run."""

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from fractions import Fraction

from heatlens.core.base.errors import InputError

# Frame numbers are counted or encode a time of day; both have at most nine digits.
FRAME_MOST = 999_999_999
# Eleven hours at 24 frames per second. A longer range is a typing error, and would fill the memory.
COUNT_MOST = 1_000_000
_RATE_MOST = 10_000.0
_RANGE = re.compile(r"(-?[0-9]{1,9})(?:-(-?[0-9]{1,9}))?")

FRAMES_PER_SECOND = 24.0  # the rate that OpenEXR assumes if a header has none


@dataclass(frozen=True, slots=True)
class FrameRange:
    """Frames first to last, both included.

    Raises InputError if there is no frame, or more than a shot can have.
    """

    first: int
    last: int

    def __post_init__(self) -> None:
        check_frame(self.first)
        check_frame(self.last)
        if self.last < self.first:
            raise InputError(f"Frames {self} run backwards. Give the smaller number first.")
        if self.count > COUNT_MOST:
            raise InputError(
                f"Frames {self} are {self.count:,}; a shot has at most {COUNT_MOST:,}."
            )

    def __str__(self) -> str:
        return f"{self.first}-{self.last}"

    def __iter__(self) -> Iterator[int]:
        return iter(range(self.first, self.last + 1))

    def __contains__(self, frame: float) -> bool:
        return self.first <= frame <= self.last

    @property
    def count(self) -> int:
        """The number of frames."""
        return self.last - self.first + 1

    def intersection(self, other: "FrameRange") -> "FrameRange | None":
        """Return the frames in both; None if they do not meet."""
        first, last = max(self.first, other.first), min(self.last, other.last)
        return FrameRange(first, last) if first <= last else None


def parse_frame_range(text: str) -> FrameRange:
    """Parse "1001-1024", or a single frame as "1001". Raises InputError for anything else."""
    match = _RANGE.fullmatch(text.strip())
    if match is None:
        raise InputError(f"{text!r} is not a frame range. Example: 1001-1024.")
    return FrameRange(int(match[1]), int(match[2] or match[1]))


def check_frame(frame: float) -> None:
    """Raise InputError for a value that cannot be the number of a frame, or a time between two."""
    if not abs(frame) <= FRAME_MOST:
        raise InputError(f"A frame number has at most nine digits, got {Decimal(frame):.10g}.")


def check_frames_per_second(rate: float) -> None:
    """Raise InputError for an impossible frame rate."""
    if not 0 < rate <= _RATE_MOST or math.isnan(rate):
        raise InputError(f"Frames per second must be above 0 and at most 10,000, got {rate:g}.")


def check_within(
    allowed_frames: FrameRange | None, source_name: str, frames: Iterable[int]
) -> None:
    """Raise InputError if any of `frames` is outside `allowed_frames`; None allows all frames.

    `source_name` names the source that has the allowed frames, for the message.
    """
    wrong_frames = [
        frame for frame in frames if allowed_frames is not None and frame not in allowed_frames
    ]
    if wrong_frames and allowed_frames is not None:
        count_note = f" and {len(wrong_frames) - 1} more" if len(wrong_frames) > 1 else ""
        raise InputError(
            f"{source_name} has frames {allowed_frames.first} to {allowed_frames.last}, got "
            f"{wrong_frames[0]}{count_note}."
        )


def exact_rate(frames_per_second: float) -> Fraction:
    """Return 23.976 as 24000/1001, and similar rates likewise.

    Any other rate becomes the nearest fraction with a denominator of up to 1001.
    """
    rounded_rate = round(frames_per_second)
    ntsc_rate = Fraction(rounded_rate * 1000, 1001)
    if abs(frames_per_second - ntsc_rate) < 0.005:
        return ntsc_rate
    return Fraction(frames_per_second).limit_denominator(1001)


class Ending(StrEnum):
    """What happens after the last frame."""

    LOOP = "loop"  # start again at the first
    BOUNCE = "bounce"  # reverse the direction
    ONCE = "once"  # stop
    REEL = "reel"  # go on in the next shot of the reel; without one, start again
