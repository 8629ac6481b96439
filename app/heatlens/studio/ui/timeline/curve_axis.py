"""Define the vertical axis of the curve editor for each parameter: scale, limits and labels.

Higher values are at the top: farther, a higher f-number, a longer lens. Equal heights are equal
turns of the lens ring: dioptres for focus, stops for aperture, doublings for focal length. A
position on the axis is called a level; levels grow downwards.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise

from heatlens.core.base.errors import LensError
from heatlens.core.model.curves.curve import Curve
from heatlens.core.model.curves.interpolation import Scale
from heatlens.core.model.keys.key_choice import KeySelection, check_shot, frames_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot

_MIN_LABELS = 3
_MIN_DIOPTRES = 1e-6  # dioptres; stands for infinity, which has no place on a scale of meters


# The axis of the focus fits the keys; F over the curve includes the marks, and the timeline grows
# while a curve is shown. With an axis that includes every mark, a pull from 2.96 to 4.07 m was only
# seven pixels high on a strip of 105.
@dataclass(frozen=True)
class CurveAxis:
    """The vertical axis of a parameter; the smallest level is at the top.

    parameter     the parameter
    scale         the scale on which equal heights are equal steps
    factor        levels per step of the scale
    top_level     the topmost level
    min_span      the smallest visible range of levels
    labels        lists of values to label, from few to many; the longest that fits is used
    format_value  formats a value, given the unit of distances
    fine          values to label instead where fewer than _MIN_LABELS are visible
    """

    parameter: LensParameter
    scale: Scale
    factor: float
    top_level: float
    min_span: float
    labels: tuple[tuple[float, ...], ...]
    format_value: Callable[[float, str], str]
    fine: tuple[float, ...] = ()

    def level_of(self, value: float) -> float:
        """Return the level of a value of the parameter on the axis."""
        return self.factor * self.scale.position_of(value)

    def value_at(self, level: float) -> float:
        """Return the value at a level, the inverse of `level_of`; infinity above the top."""
        return self.scale.value_at(level / self.factor)

    def from_scale(self, level: float, scale: Scale) -> float:
        """Convert a value on a curve's own scale, which may be meters, to a level."""
        if scale is self.scale:
            return self.factor * level
        return self.level_of(max(scale.value_at(level), _MIN_DIOPTRES))

    def to_scale(self, level: float, scale: Scale) -> float:
        """Convert a level to a value on a curve's own scale, the inverse of `from_scale`."""
        if scale is self.scale:
            return level / self.factor
        return scale.position_of(self.value_at(max(level, _MIN_DIOPTRES)))

    def labels_for(self, levels_apart: float) -> tuple[float, ...]:
        """Return the longest list of labels that are at least this many levels apart.

        Return the shortest list if the labels of none are.
        """
        fitting = [values for values in self.labels if self._least_gap(values) >= levels_apart]
        return fitting[-1] if fitting else self.labels[0]

    def visible_labels(self, low: float, high: float, levels_apart: float) -> list[float]:
        """Return the values to label between two levels, `low` and `high`.

        If fewer than _MIN_LABELS of the usual labels are visible, the fine ones are used instead.
        """
        values: list[float] = []
        for candidates in (self.labels_for(levels_apart), self.fine):
            values = [
                value for value in candidates if low <= self.level_of(value) <= high
            ] or values
            if len(values) >= _MIN_LABELS:
                break
        return values

    def _least_gap(self, values: tuple[float, ...]) -> float:
        """Return the smallest distance between two of the values, in levels."""
        levels = sorted(self.level_of(value) for value in values)
        return min(b - a for a, b in pairwise(levels))


def _axis_of(parameter: LensParameter) -> CurveAxis:
    """Return the axis of a parameter, as its facts describe it."""
    facts = parameter.facts
    scale = facts.scales[0]
    top_level = 0.0 if scale is Scale.RECIPROCAL else -math.inf
    limits = scale, facts.factor, top_level, facts.span_least
    return CurveAxis(parameter, *limits, facts.labels, parameter.format_value, facts.fine)


AXES = {parameter: _axis_of(parameter) for parameter in LensParameter}


def raise_keys(shot: Shot, selection: KeySelection, axis: CurveAxis, levels: float) -> Shot:
    """Move the selected keys of a parameter up by a number of levels; focus stops at infinity.

    Raise LensError if no lens can have such values.
    """
    curve = shot.curves.of(axis.parameter)
    for frame in frames_of(selection, axis.parameter) if levels else []:
        key = curve.key_at(frame)
        if key is not None:
            value = axis.value_at(axis.level_of(key.value) - levels)
            curve = curve.with_key(replace(key, value=value))
    return check_shot(shot.with_curve(axis.parameter, curve))


class CurveLine:
    """The points of a curve over the visible frames, computed again when either changes."""

    def __init__(self) -> None:
        self._points_key: object = None
        self._points: list[tuple[float, float]] = []

    def points(
        self, shot: Shot, axis: CurveAxis, first: float, last: float, count: int
    ) -> list[tuple[float, float]]:
        """Return (frame, level) at `count` even times from first to last, and at every key."""
        curve, name = shot.curves.of(axis.parameter), str(axis.parameter)
        points_key = (axis.parameter, shot.lens, shot.curves, first, last, count)
        if points_key != self._points_key:
            times = {first + (last - first) * index / (count - 1) for index in range(count)}
            times |= {key.frame for key in curve.keys if first <= key.frame <= last}
            values = ((time, _value_at(shot, curve, name, time)) for time in sorted(times))
            self._points = [(time, axis.level_of(value)) for time, value in values]
            self._points_key = points_key
        return self._points


def _value_at(shot: Shot, curve: Curve, name: str, time: float) -> float:
    """Return a value of the lens, also where the keys of other values give no possible lens."""
    if curve.keys:
        return curve.value_at(time)
    with suppress(LensError):
        return (
            float(getattr(shot.lens_at(time), name))
            if shot.curves.live
            else _unkeyed_value(shot, name)
        )
    return _unkeyed_value(shot, name)


def _unkeyed_value(shot: Shot, name: str) -> float:
    return float(getattr(shot.lens, name))
