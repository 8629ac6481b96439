"""Interpolation between keys: the scale on which a value moves, and its path.

A path is drawn over frames on the scale of its parameter, where equal steps look equal:
  reciprocal   1/value: focus in dioptres (1/m), in which the blur and a focus ring are straight
               lines and infinity is 0
  logarithmic  log2(value): f-stops, whose ring counts stops, each half a doubling; focal lengths,
               whose ring magnifies by equal ratios
  linear       the value itself: a squeeze, or focus in meters for those who want it so
"""

import math
from dataclasses import dataclass
from enum import StrEnum

from heatlens.core.base.errors import InputError

# Values beyond these are in the wrong unit; within them, nothing here overflows.
_LEAST, _MOST = 1e-9, 1e12
_DOUBLINGS_MOST = math.log2(_MOST)
_SPEED_MOST = 1e9  # units of the scale per frame
_REACH_LEAST = 1e-6  # share of a segment; a shorter handle has no direction
_HALVINGS = 60  # halvings of an interval of length 1, down to the rounding of its ends
_CLOSE = 1e-15  # error of a time at which the search for it ends


class Interpolation(StrEnum):
    """The path from a key to the next one."""

    HOLD = "hold"  # stays, then jumps
    LINEAR = "linear"
    SMOOTH = "smooth"  # through the keys without a corner, never beyond them
    BEZIER = "bezier"  # shaped by the handles of the two keys


class Scale(StrEnum):
    """The scale on which a value changes evenly from one key to the next."""

    LINEAR = "linear"
    RECIPROCAL = "reciprocal"
    LOGARITHMIC = "logarithmic"

    # Blur is linear in dioptres, and so is the turn of a focus ring. A pull that is even in meters
    # would rush through everything near, and could not end at infinity.
    def position_of(self, value: float) -> float:
        """Return the position of `value` on this scale. Raises InputError if it has none."""
        self._check_value(value)
        if self is Scale.RECIPROCAL:
            return 1.0 / value
        return math.log2(value) if self is Scale.LOGARITHMIC else value

    def value_at(self, position: float) -> float:
        """Return the value at a position on this scale; below 0 dioptres, it is infinity."""
        if self is Scale.RECIPROCAL:
            return 1.0 / position if position > 1.0 / _MOST else math.inf
        # A handle can reach any height, and 2**1024 raises OverflowError.
        return 2.0 ** min(position, _DOUBLINGS_MOST) if self is Scale.LOGARITHMIC else position

    def slope_at(self, value: float) -> float:
        """Return the derivative of the position on this scale by the value; 0 at infinity."""
        if self is Scale.RECIPROCAL:
            return -1.0 / (value * value)
        return 1.0 / (value * math.log(2)) if self is Scale.LOGARITHMIC else 1.0

    def _check_value(self, value: float) -> None:
        """Raise InputError for a value that is not on this scale, or in a wrong unit."""
        if self is Scale.RECIPROCAL and value == math.inf:
            return
        least = -_MOST if self is Scale.LINEAR else _LEAST
        if not least <= value <= _MOST:
            raise InputError(
                f"A key cannot have the value {value:g} on a {self} scale: "
                + (
                    "use the scale of dioptres for infinity."
                    if value == math.inf
                    else f"it takes {least:g} to {_MOST:g}."
                )
            )


@dataclass(frozen=True, slots=True)
class Ease:
    """One handle of a key, in the terms of After Effects.

    influence_percent  its reach into the segment, 0 to 100 % of the segment's frames, so that a
                       curve never runs back in time, wherever its keys are moved
    speed_per_frame    slope of the curve at the key, in units of its scale; 0 eases to a rest
    """

    influence_percent: float = 100 / 3  # with a speed of 0 this is 3 u^2 - 2 u^3, a smooth pull
    speed_per_frame: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.influence_percent <= 100:
            raise InputError(f"An influence is 0 to 100 %, got {self.influence_percent:g}.")
        if not abs(self.speed_per_frame) <= _SPEED_MOST:
            raise InputError(
                f"The speed of a key is a number up to {_SPEED_MOST:g} per frame, got "
                f"{self.speed_per_frame:g}."
            )

    def handle(self, segment_frames: float) -> tuple[float, float]:
        """Return (frames, rise on the scale) from the key to the handle's tip, forward in time."""
        reach_frames = self.influence_percent / 100 * segment_frames
        return reach_frames, self.speed_per_frame * reach_frames

    @staticmethod
    def of_handle(frames: float, rise: float, segment_frames: float) -> "Ease":
        """Return the ease for a tip dragged to this point, kept inside the segment.

        A tip nearer to the key than `_REACH_LEAST` of the segment, or behind it, has no influence
        and no speed: its direction would be arbitrary.
        """
        if frames < _REACH_LEAST * segment_frames:
            return Ease(0.0)
        speed = max(-_SPEED_MOST, min(rise / frames, _SPEED_MOST))
        return Ease(min(100.0, 100 * frames / segment_frames), speed)


def monotone_slope(before: tuple[float, float], after: tuple[float, float]) -> float:
    """Return the slope at a key between two segments, each given as (frames, slope of its chord).

    F. N. Fritsch and R. E. Carlson, "Monotone Piecewise Cubic Interpolation", 1980, show which
    slopes keep a cubic between its keys; the weighted harmonic mean of F. N. Fritsch and J.
    Butland, "A Method for Constructing Local Monotone Piecewise Cubic Interpolants", 1984, is one
    that a key decides with its two neighbors alone, so that an edit stays local.
    """
    (frames_0, chord_0), (frames_1, chord_1) = before, after
    if chord_0 * chord_1 <= 0:
        return 0.0
    weight_0, weight_1 = 2 * frames_1 + frames_0, frames_1 + 2 * frames_0
    return (weight_0 + weight_1) / (weight_0 / chord_0 + weight_1 / chord_1)


def hermite(u: float, ends: tuple[float, float], rises: tuple[float, float]) -> float:
    """Return the value at u of the cubic over 0 <= u <= 1 with these values at its `ends`.

    `rises` are its slopes there, for each unit of u.
    """
    (start, end), (rise_0, rise_1) = ends, rises
    v = 1.0 - u
    eased = u * u * (3.0 - 2.0 * u)
    return start + (end - start) * eased + u * v * (v * rise_0 - u * rise_1)


def bezier(
    u: float, ends: tuple[float, float], out: tuple[float, float], into: tuple[float, float]
) -> float:
    """Return the cubic Bezier between these values where its time is u, 0 <= u <= 1.

    `out` and `into` are handles as (part of the segment's time, 0 to 1; rise): the one from the
    start to its tip, and the one from its tip to the end.
    """
    t = _parameter_at(u, out[0], 1.0 - into[0])
    return _bernstein(t, (ends[0], ends[0] + out[1], ends[1] - into[1], ends[1]))


# Newton alone leaves the interval where the handles make time almost stand still; bisection alone
# takes 50 steps where Newton takes a few.
def _parameter_at(u: float, time_1: float, time_2: float) -> float:
    """Return the parameter at which a Bezier's time is u, by Newton's method or else bisection.

    With both inner times between 0 and 1, time only grows, so that the parameter is unique.
    """
    low, high, t = 0.0, 1.0, u
    for _ in range(_HALVINGS):
        time_error = _bernstein(t, (0.0, time_1, time_2, 1.0)) - u
        if abs(time_error) <= _CLOSE:
            break
        low, high = (low, t) if time_error > 0 else (t, high)
        slope = _time_slope(t, time_1, time_2)
        step = t - time_error / slope if slope > 0 else low
        t = step if low < step < high else (low + high) / 2
    return t


def _bernstein(t: float, points: tuple[float, float, float, float]) -> float:
    """Return the value of the cubic Bezier with these control points at the parameter t."""
    s = 1.0 - t
    p0, p1, p2, p3 = points
    return s * s * s * p0 + 3 * s * t * (s * p1 + t * p2) + t * t * t * p3


def _time_slope(t: float, time_1: float, time_2: float) -> float:
    """Return the derivative by t of the time of a Bezier with these inner control times."""
    s = 1.0 - t
    return 3 * (s * s * time_1 + 2 * s * t * (time_2 - time_1) + t * t * (1.0 - time_2))
