"""The lens: the values on its barrel, its focus distance and the width of the sensor.

A shot keeps every distance from the entrance pupil. Every distance that is shown or typed for a
lens is converted here, so that a focus, its limits and a mark on the same thing agree.

The size of a lens's discs is that of a real lens, or that of a CG renderer (`LensModel`). A real
lens that focuses nearer moves away from the sensor, to the image distance v with 1/v = 1/f - 1/S.
Renderers leave the image at the focal length, so that the field of view does not breathe, and open
a disc of radius f/2N in front of that pinhole (Cook, Porter and Carpenter 1984; Cycles, Mitsuba's
`thinlens`, pbrt's `PerspectiveCamera`, Arnold and others). Their discs are smaller by
f/v = 1 - f/S: 5 % for 50 mm at 1 m, 14 % for 85 mm at 0.6 m.
"""

import math
from bisect import bisect_left, bisect_right
from dataclasses import KW_ONLY, dataclass, field, replace
from enum import StrEnum
from typing import Any, assert_never

from heatlens.core.base.errors import LensError
from heatlens.core.model.lens.aperture import APERTURE_FIELDS, Aperture
from heatlens.core.model.lens.opening_fields import OpeningFields
from heatlens.core.model.option import Option, option, option_field, options_of
from heatlens.core.model.units import format_distance, parse_distance_m


@dataclass(frozen=True)
class LensModelFacts:
    """The facts of a lens model, from which all other code derives.

    words        its name for people
    meaning      its explanation, for a tooltip or for help
    image_moves  the sensor lies at the image distance, which grows as the focus comes nearer; else
                 it always lies at the focal length
    """

    words: str
    meaning: str
    image_moves: bool


class LensModel(StrEnum):
    """Whether discs are those of a real lens or of a CG renderer, which differ in size."""

    PHOTOGRAPHIC = "photographic"
    RENDERER = "renderer"

    @property
    def facts(self) -> LensModelFacts:
        """The label and meaning of the model, and whether the sensor moves for focusing."""
        match self:
            case LensModel.PHOTOGRAPHIC:
                meaning = "discs of a real lens of this f-stop on the film back"
                return LensModelFacts("real lens", meaning, image_moves=True)
            case LensModel.RENDERER:
                meaning = "discs of CG renderers, smaller by (focus - focal length)/focus"
                return LensModelFacts("CG renderer", meaning, image_moves=False)
            case _:
                assert_never(self)

    def focal_over_image_distance(self, focal_length_mm: float, focus_distance_m: float) -> float:
        """Return f/v, 0 to 1: the size of a renderer's discs relative to this model's.

        1 - f/S for a real lens, from the equation of the thin lens, also with focus at infinity; 1
        where the image lies at the focal length.
        """
        if self.facts.image_moves:
            return 1.0 - focal_length_mm / (focus_distance_m * 1e3)
        return 1.0


# Share of the sensor's width that still looks sharp; a common rule for pictures seen whole.
_SHARP_SHARE = 1 / 1500
# No lens or sensor lies outside these ranges in mm or f-numbers; a value beyond is in the wrong
# unit. Within them every diameter of blur stays finite in float32.
_HARDWARE: dict[str, Any] = {"least": 1e-3, "most": 1e6}
# Powers of 2^(1/6), rounded as makers engrave them (ISO 517 for the whole stops).
THIRD_STOPS = (
    *(0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.5, 2.8, 3.2, 3.5, 4.0, 4.5, 5.0),
    *(5.6, 6.3, 7.1, 8.0, 9.0, 10.0, 11.0, 13.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 29.0, 32.0),
)
_SAME = 1e-4  # relative, so that 2.8 stays 2.8 after rounding to float32


class MeasuredFrom(StrEnum):
    """The origin of the distances that people read and type.

    A tape and the scale on a lens begin at the film plane; the depth of a plate begins at the point
    that the camera looks from, which is the entrance pupil. A shot keeps distances from the pupil.
    """

    PUPIL = "entrance-pupil"
    FILM = "film-plane"

    @property
    def words(self) -> str:
        """Its name in a sentence."""
        return str(self).replace("-", " ")

    def offset_m(self, pupil_offset_mm: float) -> float:
        """Return the amount by which a distance from here exceeds one from the pupil."""
        return 1e-3 * pupil_offset_mm if self is MeasuredFrom.FILM else 0.0


@dataclass(frozen=True, slots=True)
class Lens(OpeningFields):
    """A thin lens in front of a flat sensor: hardware in millimeters, distances in meters.

    The shape of its opening is in the fields of `OpeningFields`.

    focal_length_mm    focal length
    f_stop             N of f/N: with the focal length it fixes the aperture, and so the blur
    focus_distance_m   from the entrance pupil to the plane in focus; infinite is allowed
    sensor_width_mm    width of the part of the sensor that the picture shows
    t_stop             exposure only, None where unknown; it never enters the blur
    acceptable_coc_mm  diameter that still counts as sharp, None for 1/1500 of the sensor's width
    close_focus_m      nearest focus that the ring of the real lens allows, None where unknown; a
                       nearer one is rendered all the same, and `pull.frames_too_close` finds it
    model              whether its discs are those of a real lens or of a CG renderer
    breathing          width of the view at close focus over that at infinity; see `breathing`
    widest_f_stop      with the ring fully open; None if unknown: the barrel then cuts equally at
                       every stop
    measured_from      origin of displayed distances; those in this class are from the pupil
    pupil_offset_mm    from the film plane to the entrance pupil, below 0 where that is behind it

    Raises LensError naming the value and what it may be.
    """

    focal_length_mm: float = field(
        metadata=option("focal length", "focal length in mm", metavar="MM", unit="mm", **_HARDWARE)
    )
    f_stop: float = field(
        metadata=option(
            "f-stop", "2 or f/2; smaller blurs more", metavar="N", unit="f-stop", **_HARDWARE
        )
    )
    focus_distance_m: float = field(
        metadata=option(
            "focus distance",
            "metres, or with a unit: 190cm, feet as 6ft3in, inf",
            metavar="DISTANCE",
            unit="m",
            parse=parse_distance_m,
        )
    )
    sensor_width_mm: float = field(
        metadata=option(
            "sensor width", "width of the film back in mm", metavar="MM", unit="mm", **_HARDWARE
        )
    )
    _: KW_ONLY
    t_stop: float | None = option_field(None, "T-stop", **_HARDWARE)
    acceptable_coc_mm: float | None = option_field(
        None, "acceptable circle of confusion", unit="mm", **_HARDWARE
    )
    close_focus_m: float | None = option_field(None, "close focus", unit="m", **_HARDWARE)
    model: LensModel = option_field(
        LensModel.PHOTOGRAPHIC,
        "lens model",
        "the discs of a photographic lens, or of the CG renderer that makes the final "
        "picture, smaller by (focus - focal length)/focus (default: renderer for a scene and "
        "for a plate whose header names a CG renderer, else photographic)",
    )
    breathing: float = option_field(
        1.0,
        "breathing",
        "width of the view at close focus over that at infinity, such as 0.95 (default 1: no "
        "breathing)",
        metavar="RATIO",
        least=0.5,
        most=1.5,
    )
    widest_f_stop: float | None = option_field(
        None,
        "widest f-stop",
        "f-stop at which --cat-eye applies in full (default: every f-stop)",
        metavar="N",
        unit="f-stop",
        **_HARDWARE,
    )

    measured_from: MeasuredFrom = option_field(
        MeasuredFrom.PUPIL,
        "distances from",
        "where given distances begin: at the entrance pupil, like the depth of a plate "
        "(default), or at the film plane, like a tape measure and a lens scale",
    )
    pupil_offset_mm: float = option_field(
        0.0,
        "pupil offset",
        "millimetres from film plane to entrance pupil, for --distances-from film-plane",
        metavar="MM",
        least=-2000.0,
        most=2000.0,
    )

    def __post_init__(self) -> None:
        for name, facts in options_of(Lens).items():
            value = getattr(self, name)
            if name in APERTURE_FIELDS or value is None or facts.least is None:
                continue
            if not facts.allows(value):
                raise LensError(_range_message(facts, value))
        _ = self.aperture  # raises LensError for an impossible opening
        _check_focus(self.focus_distance_m, self.focal_length_mm)

    @property
    def aperture(self) -> Aperture:
        """Shape of the opening."""
        widest_f_stop = self.f_stop if self.widest_f_stop is None else self.widest_f_stop
        return Aperture(**self.opening, stopped_down=max(1.0, self.f_stop / widest_f_stop))

    @property
    def aperture_diameter_mm(self) -> float:
        """Diameter of the entrance pupil."""
        return self.focal_length_mm / self.f_stop

    @property
    def measuring_offset_m(self) -> float:
        """The amount by which displayed distances exceed those from the pupil."""
        return self.measured_from.offset_m(self.pupil_offset_mm)

    @property
    def transmission_stops(self) -> float:
        """Exposure change due to the T-stop, in stops; normally negative, 0 without a T-stop."""
        return 0.0 if self.t_stop is None else 2.0 * math.log2(self.f_stop / self.t_stop)

    @property
    def coc_limit_mm(self) -> float:
        """Diameter on the sensor up to which a point counts as sharp: given, or by the rule."""
        if self.acceptable_coc_mm is not None:
            return self.acceptable_coc_mm
        return self.sensor_width_mm * _SHARP_SHARE

    def without_advice(self) -> "Lens":
        """Return the lens without the values that only warn or measure and change no pixel.

        An aperture image is identified by the digest of its light, not by the path of its file.
        """
        image = self.aperture_image
        named_image = None if image is None else replace(image, path=image.digest)
        return replace(self, acceptable_coc_mm=None, close_focus_m=None, aperture_image=named_image)


def _range_message(option: Option, value: float) -> str:
    """Return the sentence for a value outside the range of its option."""
    unit = f" {option.unit}" if option.unit in ("mm", "m") else ""
    return (
        f"The {option.words} must be between {option.least:g}{unit} and {option.most:,.0f}{unit}, "
        f"got {value:g}{unit}."
    )


def _check_focus(focus_distance_m: float, focal_length_mm: float) -> None:
    """Raise LensError for a focus at or within the focal length, whose image lies at infinity."""
    if math.isnan(focus_distance_m) or focus_distance_m * 1e3 <= focal_length_mm:
        raise LensError(
            f"The focus distance must be beyond the focal length of {focal_length_mm:g} mm, "
            f"got {focus_distance_m:g} m."
        )


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


def step_f_stop(f_stop: float, steps: int) -> float:
    """Return the f-stop `steps` third stops up the ring, or down if negative.

    A value between two stops of the ring counts as one step. The result stays on the ring; 0 steps
    leave the value alone.
    """
    if steps > 0:
        index = bisect_right(THIRD_STOPS, f_stop * (1 + _SAME)) + steps - 1
    elif steps < 0:
        index = bisect_left(THIRD_STOPS, f_stop * (1 - _SAME)) + steps
    else:
        return f_stop
    return THIRD_STOPS[min(max(index, 0), len(THIRD_STOPS) - 1)]


def nearest_index(f_stop: float) -> int:
    """Return the index in THIRD_STOPS of the stop nearest to an f-stop, measured in stops."""
    return min(range(len(THIRD_STOPS)), key=lambda i: abs(math.log2(THIRD_STOPS[i] / f_stop)))
