"""Distances as people read and type them beside a lens: from the pupil or the film plane.

A shot keeps every distance from the entrance pupil. Every distance that is shown or typed for a
lens is converted here, so that a focus, its limits and a mark on the same thing agree.
"""

from heatlens.model.lens.lens import Lens
from heatlens.model.units import format_distance, parse_distance_m


def as_measured_m(lens: Lens, distance_m: float) -> float:
    """Convert a distance from the entrance pupil to this lens's origin; infinity stays."""
    return distance_m + lens.measuring_offset_m


def from_pupil_m(lens: Lens, measured_m: float) -> float:
    """Convert a distance from this lens's origin to one from the entrance pupil."""
    return measured_m - lens.measuring_offset_m


def measured_text(lens: Lens, distance_m: float, unit: str = "m") -> str:
    """Return a distance from the entrance pupil as text, from this lens's origin."""
    return format_distance(as_measured_m(lens, distance_m), unit)


def parse_measured_m(lens: Lens, text: str) -> float:
    """Return the distance in a text, from the entrance pupil; raise InputError if it has none."""
    return from_pupil_m(lens, parse_distance_m(text))
