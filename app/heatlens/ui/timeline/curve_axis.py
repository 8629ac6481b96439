"""What the height of a curve means: for each parameter its scale, its ends and its labels.

Up is more: farther, a higher f-number, a longer lens. Equal heights are equal steps of the hand:
of a focus ring in dioptres, of an aperture ring in stops, of a zoom in doublings.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

from heatlens.model.f_stops import THIRD_STOPS
from heatlens.model.interpolation import Scale
from heatlens.model.shot import LensParameter, Shot
from heatlens.model.units import format_distance
from heatlens.session.key_choice import Chosen, checked, frames_of

_INFINITY = float("inf")
_DISTANCES_M = (
    *(0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 7, 10, 20, 50),
    _INFINITY,
)
_FOCAL_LENGTHS_MM = (
    *(4, 6, 8, 10, 12, 14, 16, 18, 21, 24, 28, 32, 35, 40, 50, 65, 75, 85, 100, 135, 150, 180),
    *(200, 250, 300, 400, 500, 600, 800, 1200),
)
_SQUEEZES = (1, 1.1, 1.2, 1.25, 1.3, 1.33, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2)
_NEAREST = 1e-6  # dioptres: on a scale of metres infinity has no place


@dataclass(frozen=True)
class CurveAxis:
    """Places grow downwards: the least one lies at the top.

    parameter   what it is of
    scale       on which equal heights are equal steps
    factor      places for a step of the scale
    least       the place that nothing lies above
    span_least  places that are seen at least
    labels      values, from rare to many: as many are written as have room
    words       a value as it is written, with the unit of distances
    """

    parameter: LensParameter
    scale: Scale
    factor: float
    least: float
    span_least: float
    labels: tuple[tuple[float, ...], ...]
    words: Callable[[float, str], str]

    def place_of(self, value: float) -> float:
        """Return where a value lies."""
        return self.factor * self.scale.place_of(value)

    def value_at(self, place: float) -> float:
        """Return the value at a place, the reverse of `place_of`; above infinity is infinity."""
        return self.scale.value_at(place / self.factor)

    def from_scale(self, place: float, scale: Scale) -> float:
        """Return where a place on a curve's scale lies: focus may go from key to key in metres."""
        if scale is self.scale:
            return self.factor * place
        return self.place_of(max(scale.value_at(place), _NEAREST))

    def to_scale(self, place: float, scale: Scale) -> float:
        """Return the value on the scale of a curve, the reverse of `from_scale`."""
        if scale is self.scale:
            return place / self.factor
        return scale.place_of(self.value_at(max(place, _NEAREST)))

    def labels_for(self, places_apart: float) -> tuple[float, ...]:
        """Return the most labels that lie so far apart, or the rarest."""
        fitting = [values for values in self.labels if self._least_gap(values) >= places_apart]
        return fitting[-1] if fitting else self.labels[0]

    def _least_gap(self, values: tuple[float, ...]) -> float:
        places = sorted(self.place_of(value) for value in values)
        return min(b - a for a, b in pairwise(places))


AXES = {
    axis.parameter: axis
    for axis in (
        CurveAxis(
            LensParameter.FOCUS_DISTANCE, Scale.RECIPROCAL, 1.0, 0.0, 0.04, (_DISTANCES_M,),
            format_distance,
        ),
        CurveAxis(  # a stop doubles the light, and so the square of the f-number
            LensParameter.F_STOP, Scale.LOGARITHMIC, -2.0, -math.inf, 2.0,
            (THIRD_STOPS[::3], THIRD_STOPS), lambda value, _: f"f/{value:g}",
        ),
        CurveAxis(
            LensParameter.FOCAL_LENGTH, Scale.LOGARITHMIC, -1.0, -math.inf, 1.0,
            (_FOCAL_LENGTHS_MM,), lambda value, _: f"{value:g} mm",
        ),
        CurveAxis(
            LensParameter.SQUEEZE, Scale.LINEAR, -1.0, -math.inf, 0.2, (_SQUEEZES,),
            lambda value, _: f"{value:g} x",
        ),
    )
}  # fmt: skip


def raised(shot: Shot, chosen: Chosen, axis: CurveAxis, places: float) -> Shot:
    """Move the chosen keys of a parameter by so many places up, focus to infinity at most.

    Raises LensError where no lens can be so.
    """
    curve = shot.curves.of(axis.parameter)
    for frame in frames_of(chosen, axis.parameter) if places else []:
        key = curve.key_at(frame)
        if key is not None:
            value = axis.value_at(axis.place_of(key.value) - places)
            curve = curve.with_key(replace(key, value=value))
    return checked(shot.with_curve(axis.parameter, curve))


class CurveLine:
    """Where a curve runs over the frames that are seen, made again when it or these change."""

    def __init__(self) -> None:
        self._made_of: object = None
        self._points: list[tuple[float, float]] = []

    def points(
        self, shot: Shot, axis: CurveAxis, first: float, last: float, count: int
    ) -> list[tuple[float, float]]:
        """Return (frame, place) at `count` times evenly from first to last, and at every key."""
        curve, still = shot.curves.of(axis.parameter), getattr(shot.lens, axis.parameter)
        made_of = (axis.parameter, curve, still, first, last, count)
        if made_of != self._made_of:
            times = {first + (last - first) * i / (count - 1) for i in range(count)}
            times |= {key.frame for key in curve.keys if first <= key.frame <= last}
            values = ((t, curve.value_at(t) if curve.keys else still) for t in sorted(times))
            self._points = [(time, axis.place_of(value)) for time, value in values]
            self._made_of = made_of
        return self._points
