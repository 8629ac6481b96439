"""A grade by the ASC CDL: slope, offset and power of each channel, then saturation.

out = (in * slope + offset) ** power; the saturation is about the luma of Rec. 709.
"""

import math
from dataclasses import dataclass

from heatlens.core.base.errors import InputError

Channels = tuple[float, float, float]  # red, green, blue
_FORM = "SLOPE OFFSET POWER SATURATION, such as '1.1,1,0.9 0,0,0.01 1,1,1 0.8'"
_MOST = 1e6  # largest absolute value of a number


@dataclass(frozen=True, slots=True)
class Grade:
    """A grade. Raises InputError for numbers that the ASC CDL excludes."""

    slope: Channels = (1.0, 1.0, 1.0)
    offset: Channels = (0.0, 0.0, 0.0)
    power: Channels = (1.0, 1.0, 1.0)
    saturation: float = 1.0

    def __post_init__(self) -> None:
        numbers = (*self.slope, *self.offset, *self.power, self.saturation)
        if not all(math.isfinite(number) and abs(number) <= _MOST for number in numbers):
            raise InputError(
                "The numbers of a grade (ASC CDL) must be finite and at most "
                f"{_MOST:g}, not {self}."
            )
        if min(*self.slope, self.saturation) < 0 or min(self.power) <= 0:
            raise InputError(
                "The slope and the saturation of a grade (ASC CDL) must not be below 0, and its "
                f"power must be above 0, got {self}."
            )

    def __str__(self) -> str:
        """Return the numbers as `parse_grade` reads them."""
        channels = (
            ",".join(f"{number:.10g}" for number in channel_values)
            for channel_values in (self.slope, self.offset, self.power)
        )
        return f"{' '.join(channels)} {self.saturation:.10g}"


def parse_grade(text: str) -> Grade:
    """Return the grade of a text of its numbers. Raises InputError for another text."""
    try:
        *channels, saturation = (tuple(map(float, part.split(","))) for part in text.split())
        (slope, offset, power), (sat,) = channels, saturation
        if {len(slope), len(offset), len(power)} != {3}:
            raise ValueError
    except ValueError:
        raise InputError(f"A grade (ASC CDL) is {_FORM}; got {text!r}.") from None
    return Grade(_to_channels(slope), _to_channels(offset), _to_channels(power), sat)


def _to_channels(values: tuple[float, ...]) -> Channels:
    red, green, blue = values
    return red, green, blue
