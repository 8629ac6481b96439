"""Define the vertical axis of the curve editor for each parameter: scale, limits and labels.

Higher values are at the top: farther, a higher f-number, a longer lens. Equal heights are equal
turns of the lens ring: dioptres for focus, stops for aperture, doublings for focal length. A
position on the axis is called a place; places grow downwards.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise

from heatlens.core.base.errors import LensError
from heatlens.core.model.curves.curve import Curve
from heatlens.core.model.curves.interpolation import Scale
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.keys.key_choice import Chosen, checked, frames_of

_LABELS_LEAST = 3
_NEAREST = 1e-6  # dioptres; stands for infinity, which has no place on a scale of metres


# The axis of the focus once ran to every mark: a pull from 2.96 to 4.07 m was seven pixels high on
# a strip of 105. It fits the keys now, F over the curve brings the marks in, and the timeline grows
# while a curve is shown.
@dataclass(frozen=True)
class CurveAxis:
    """The vertical axis of a parameter; the smallest place is at the top.

    parameter   the parameter
    scale       the scale on which equal heights are equal steps
    factor      places per step of the scale
    least       the topmost place
    span_least  the smallest visible range of places
    labels      lists of values to label, from few to many; the longest that fits is used
    words       formats a value, given the unit of distances
    fine        values to label instead where fewer than _LABELS_LEAST are visible
    """

    parameter: LensParameter
    scale: Scale
    factor: float
    least: float
    span_least: float
    labels: tuple[tuple[float, ...], ...]
    words: Callable[[float, str], str]
    fine: tuple[float, ...] = ()

    def place_of(self, value: float) -> float:
        """Return the place of a value."""
        return self.factor * self.scale.place_of(value)

    def value_at(self, place: float) -> float:
        """Return the value at a place, the inverse of `place_of`; infinity above the top."""
        return self.scale.value_at(place / self.factor)

    def from_scale(self, place: float, scale: Scale) -> float:
        """Convert a value on a curve's own scale, which may be metres, to a place."""
        if scale is self.scale:
            return self.factor * place
        return self.place_of(max(scale.value_at(place), _NEAREST))

    def to_scale(self, place: float, scale: Scale) -> float:
        """Convert a place to a value on a curve's own scale, the inverse of `from_scale`."""
        if scale is self.scale:
            return place / self.factor
        return scale.place_of(self.value_at(max(place, _NEAREST)))

    def labels_for(self, places_apart: float) -> tuple[float, ...]:
        """Return the longest list of labels that are this far apart, or the shortest list."""
        fitting = [values for values in self.labels if self._least_gap(values) >= places_apart]
        return fitting[-1] if fitting else self.labels[0]

    def visible_labels(self, low: float, high: float, places_apart: float) -> list[float]:
        """Return the values to label from one place to another."""
        values: list[float] = []
        for choice in (self.labels_for(places_apart), self.fine):
            values = [v for v in choice if low <= self.place_of(v) <= high] or values
            if len(values) >= _LABELS_LEAST:
                break
        return values

    def _least_gap(self, values: tuple[float, ...]) -> float:
        places = sorted(self.place_of(value) for value in values)
        return min(b - a for a, b in pairwise(places))


def _axis_of(parameter: LensParameter) -> CurveAxis:
    facts = parameter.facts
    scale = facts.scales[0]
    least = 0.0 if scale is Scale.RECIPROCAL else -math.inf
    ends = scale, facts.factor, least, facts.span_least
    return CurveAxis(parameter, *ends, facts.labels, parameter.shown, facts.fine)


AXES = {parameter: _axis_of(parameter) for parameter in LensParameter}


def raised(shot: Shot, chosen: Chosen, axis: CurveAxis, places: float) -> Shot:
    """Move the chosen keys of a parameter up by so many places; focus stops at infinity.

    Raise LensError if no lens can have such values.
    """
    curve = shot.curves.of(axis.parameter)
    for frame in frames_of(chosen, axis.parameter) if places else []:
        key = curve.key_at(frame)
        if key is not None:
            value = axis.value_at(axis.place_of(key.value) - places)
            curve = curve.with_key(replace(key, value=value))
    return checked(shot.with_curve(axis.parameter, curve))


class CurveLine:
    """The points of a curve over the visible frames, computed again when either changes."""

    def __init__(self) -> None:
        self._made_of: object = None
        self._points: list[tuple[float, float]] = []

    def points(
        self, shot: Shot, axis: CurveAxis, first: float, last: float, count: int
    ) -> list[tuple[float, float]]:
        """Return (frame, place) at `count` times evenly from first to last, and at every key."""
        curve, name = shot.curves.of(axis.parameter), str(axis.parameter)
        made_of = (axis.parameter, shot.lens, shot.curves, first, last, count)
        if made_of != self._made_of:
            times = {first + (last - first) * i / (count - 1) for i in range(count)}
            times |= {key.frame for key in curve.keys if first <= key.frame <= last}
            values = ((t, _value_at(shot, curve, name, t)) for t in sorted(times))
            self._points = [(time, axis.place_of(value)) for time, value in values]
            self._made_of = made_of
        return self._points


def _value_at(shot: Shot, curve: Curve, name: str, time: float) -> float:
    """Return a value of the lens, also where the keys of others make no possible lens."""
    if curve.keys:
        return curve.value_at(time)
    with suppress(LensError):
        return float(getattr(shot.lens_at(time), name)) if shot.curves.live else _still(shot, name)
    return _still(shot, name)


def _still(shot: Shot, name: str) -> float:
    return float(getattr(shot.lens, name))
