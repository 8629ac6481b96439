"""Doubt that a lens and the depths of a picture belong together, and name a likely wrong unit.

A unit that is wrong by a factor of 25 to 1000 blurs the whole picture, or nothing at all, without
any other sign. These are doubts, not errors: such a picture may be intended.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.units import FOOT_M, INCH_M, format_distance

# Units in which programs measure scenes, the likeliest first, as --scene-unit takes them.
_SCENE_UNITS = {"cm": 1e-2, "mm": 1e-3, "m": 1.0, "in": INCH_M, "ft": FOOT_M, "km": 1e3}
# Units that may have been meant by a focus without a unit.
_FOCUS_UNITS = {"mm": 1e-3, "cm": 1e-2, "in": INCH_M, "ft": FOOT_M}
_UNIT_NAMES = {
    "mm": "millimetres",
    "cm": "centimetres",
    "m": "metres",
    "km": "kilometres",
    "in": "inches",
    "ft": "feet",
}

# A focus slightly outside the depths may be intended; a wrong unit makes a larger difference.
_FAR_OFF = 1.5
_OTHER_UNIT = 10.0  # no one focuses this many times farther than everything but with another unit
# Interiors, streets and tables have surfaces nearer than this; landscapes may have none.
_NEAREST_USUAL_M = 30.0
# Even endoscopes and phones are larger; a smaller value was meant in meters or inches.
_LEAST_HARDWARE_MM = 1.0
# From the sensor of a small phone to the widest plate of a view camera, 20 x 24 inches.
_SENSOR_LEAST_MM, _SENSOR_MOST_MM = 2.0, 620.0
_FOCAL_MOST_MM = 6000.0
_VIEW_LEAST_DEGREES, _VIEW_MOST_DEGREES = 0.3, 160.0
_INCH_MM = 25.4
_F_STOP_LEAST = 0.5  # the limit for a lens in air without spherical aberration and coma (Abbe)

About = Literal["focus", "aperture", "lens", "depth"]


@dataclass(frozen=True, slots=True)
class Doubt:
    """Something implausible, in a sentence with its likely cause and the option that would mend it.

    about   the control it belongs to: the focus, the f-stop, the hardware of the lens, or the
            depth's unit
    """

    about: About
    sentence: str


@dataclass(frozen=True, slots=True)
class DepthSpan:
    """The depths of a picture as they were read.

    near_m, far_m   the nearest and the farthest surface
    has_sky         something is infinitely far as well
    unit_m          meters assumed for one unit of the depth
    """

    near_m: float
    far_m: float
    has_sky: bool = False
    unit_m: float = 1.0

    @property
    def has_surfaces(self) -> bool:
        """False if nothing was hit, or if the plate holds circles of confusion."""
        return 0 < self.near_m <= self.far_m < math.inf

    def in_unit(self, unit_m: float) -> "DepthSpan":
        """Return the same depths as if they were in another unit."""
        factor = unit_m / self.unit_m
        near_m, far_m = self.near_m * factor, self.far_m * factor
        return replace(self, near_m=near_m, far_m=far_m, unit_m=unit_m)

    def contains(self, distance_m: float) -> bool:
        """Return True for a distance between the nearest and the farthest surface."""
        return self.near_m <= distance_m <= self.far_m

    @property
    def words(self) -> str:
        """The two ends, for a sentence."""
        return f"{format_distance(self.near_m)} to {format_distance(self.far_m)}"


# One cause at a time: a focal length in meters makes focus and sharpness doubtful as well, and
# three sentences about one mistake hide it.
def find_doubts(lens: Lens, span: DepthSpan) -> tuple[Doubt, ...]:
    """Return doubts about a lens in front of these depths, if any."""
    hardware = tuple(_hardware_doubts(lens))
    if hardware or not span.has_surfaces:  # with impossible hardware every other number is wrong
        return hardware
    return tuple(_focus_doubts(lens, span)) or tuple(_sharpness_doubts(lens, span))


def focus_unit_doubts(focus_m: Sequence[float], span: DepthSpan) -> tuple[Doubt, ...]:
    """Return doubts if distances without a unit are probably not meters."""
    finite_m = sorted(value for value in focus_m if value < math.inf)
    if not finite_m or not span.has_surfaces:
        return ()
    median_m = finite_m[len(finite_m) // 2]
    likely_units = [
        unit for unit, unit_m in _FOCUS_UNITS.items() if span.contains(median_m * unit_m)
    ]
    is_near_depths = span.near_m <= median_m * _FAR_OFF and median_m <= span.far_m * _FAR_OFF
    if is_near_depths or not likely_units:
        return ()
    range_text = " to ".join(
        dict.fromkeys(format_distance(value) for value in (finite_m[0], finite_m[-1]))
    )
    sentence = (
        f"The table's focus, taken as metres, is {range_text}, and the picture has surfaces from "
        f"{span.words}. If {_UNIT_NAMES[likely_units[0]]} are meant, say --table-unit "
        f"focus={likely_units[0]}."
    )
    return (Doubt("focus", sentence),)


def span_doubts(span: DepthSpan) -> tuple[Doubt, ...]:
    """Return doubts about the depths alone: nothing is near, and another unit would explain it."""
    if not span.has_surfaces or span.near_m < _NEAREST_USUAL_M:
        return ()
    units = [unit for unit in ("cm", "mm") if _is_room_sized(span.in_unit(_SCENE_UNITS[unit]))]
    if not units:
        return ()
    sentence = (
        f"The nearest surface is read as {format_distance(span.near_m)} away, and nothing is "
        f"nearer. {_unit_question(span, units)}"
    )
    return (Doubt("depth", sentence),)


def _is_room_sized(span: DepthSpan) -> bool:
    """Return True for the depths of a table, a room or a street."""
    return 0.1 <= span.near_m <= 20.0


def _hardware_doubts(lens: Lens) -> Iterator[Doubt]:
    """Find a focal length and a sensor width that no camera has, alone or together."""
    focal_mm, sensor_mm = lens.focal_length_mm, lens.sensor_width_mm
    view_degrees = math.degrees(2 * math.atan(sensor_mm / (2 * focal_mm)))
    if focal_mm < _LEAST_HARDWARE_MM:
        yield Doubt("lens", _too_small("focal length", "--focal-length", focal_mm))
    if sensor_mm < _SENSOR_LEAST_MM:
        yield Doubt("lens", _too_small("sensor width", "--sensor-width", sensor_mm))
    elif sensor_mm > _SENSOR_MOST_MM:
        yield Doubt("lens", f"No sensor is {sensor_mm:g} mm wide. --sensor-width is in mm.")
    if focal_mm > _FOCAL_MOST_MM:
        yield Doubt("lens", f"No lens has a focal length of {focal_mm:g} mm. It is given in mm.")
    if lens.f_stop < _F_STOP_LEAST:
        yield Doubt(
            "aperture",
            f"No lens is faster than f/{_F_STOP_LEAST:g}, but this is f/{lens.f_stop:g}: its discs "
            "are larger than any camera's.",
        )
    is_reported = (
        focal_mm < _LEAST_HARDWARE_MM or not _SENSOR_LEAST_MM <= sensor_mm <= _SENSOR_MOST_MM
    )
    if not is_reported and not _VIEW_LEAST_DEGREES <= view_degrees <= _VIEW_MOST_DEGREES:
        yield Doubt(
            "lens",
            f"A focal length of {focal_mm:g} mm on a sensor {sensor_mm:g} mm wide sees "
            f"{view_degrees:.3g} degrees, too wide for a rectilinear lens. --focal-length and "
            "--sensor-width are both in mm.",
        )


def _too_small(quantity: str, option: str, value_mm: float) -> str:
    """Return a sentence on a length under a millimeter or two, with the unit it may be in."""
    metres, inches = value_mm * 1e3, value_mm * _INCH_MM
    if value_mm >= 0.3:  # Maya's film aperture, in inches: 1.417 is 36 mm
        return (
            f"A {quantity} of {value_mm:g} mm is smaller than any camera's: if it is in inches, "
            "like "
            f"Maya's film aperture, give {option} {inches:.4g}."
        )
    return (
        f"A {quantity} of {value_mm:g} mm is smaller than any camera's: if it is in metres, say "
        f"{option} {metres:.4g}; if in inches, {option} {inches:.4g}."
    )


def _focus_doubts(lens: Lens, span: DepthSpan) -> Iterator[Doubt]:
    """Find a focus that leaves nothing sharp because it lies far outside all depths."""
    focus_m = lens.focus_distance_m
    hint = _focus_hint(focus_m, span)
    is_small_unit = any(unit in hint for unit in ("millim", "centim"))
    is_before = far_limit_m(lens) < span.near_m and focus_m * _FAR_OFF < span.near_m
    # A small opening may still show everything sharp, but its focus is as wrong.
    is_beyond = near_limit_m(lens) > span.far_m or (
        is_small_unit and focus_m > span.far_m * _OTHER_UNIT
    )
    is_behind = is_beyond and span.far_m * _FAR_OFF < focus_m < math.inf
    if not (is_before or is_behind):
        return
    if is_behind and span.has_sky and not is_small_unit:
        return  # the sky is in focus or nearly so, as intended
    position = "nearer than everything" if is_before else "farther than every surface"
    yield Doubt(
        "focus",
        f"The focus at {format_distance(focus_m)} lies {position} in the picture ({span.words}). "
        + (hint or "Focus on what is seen at a pixel with --focus-at, or see --scene-unit."),
    )


def _focus_hint(focus_m: float, span: DepthSpan) -> str:
    """Return the units that would bring focus and depths together, as a question; "" for none."""
    likely_scene_units = [
        unit
        for unit, unit_m in _SCENE_UNITS.items()
        if unit_m != span.unit_m and span.in_unit(unit_m).contains(focus_m)
    ]
    likely_focus_units = [
        unit for unit, unit_m in _FOCUS_UNITS.items() if span.contains(focus_m * unit_m)
    ]
    if (
        focus_m > span.far_m
        and likely_focus_units
        and not (likely_scene_units and span.unit_m != 1.0)
    ):
        unit = likely_focus_units[0]
        return f"If {_UNIT_NAMES[unit]} are meant, say --focus-distance {focus_m:.4g}{unit}."
    return _unit_question(span, likely_scene_units[:2]) if likely_scene_units else ""


def _unit_question(span: DepthSpan, units: list[str]) -> str:
    """Return the depths in other likely units, and the option that sets each."""
    readings = "; ".join(
        f"in {_UNIT_NAMES[unit]} ({span.in_unit(_SCENE_UNITS[unit]).words}) say --scene-unit {unit}"
        for unit in units
    )
    return f"If the depths are {readings}."


def _sharpness_doubts(lens: Lens, span: DepthSpan) -> Iterator[Doubt]:
    """Find a lens that blurs nothing because everything is farther away than rooms and streets."""
    is_all_sharp = near_limit_m(lens) <= span.near_m and far_limit_m(lens) >= span.far_m
    if not is_all_sharp or span.near_m == span.far_m:
        return
    if span_doubts(span):
        units = [unit for unit in ("cm", "mm") if _is_room_sized(span.in_unit(_SCENE_UNITS[unit]))]
        yield Doubt(
            "depth",
            f"Nothing will be blurred: with this lens the whole picture ({span.words}) looks "
            f"sharp. {_unit_question(span, units)}",
        )
