"""The values by which a user describes a depth: its convention, its side, a known distance."""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import assert_never

from heatlens.core.base.errors import InputError
from heatlens.core.model.units import parse_distance_m


@dataclass(frozen=True)
class DepthFacts:
    """The facts of a depth convention, from which reader, command line and panels derive.

    label       words for a menu
    meaning     words that explain the values, for help and tooltips
    takes_ends  distances of a near and a far end count
    needs_ends  without both ends there is no distance, not even an assumed one
    has_unit    the values are in the unit of the scene, or in one over it
    is_disparity  the values run evenly over 1/distance, between the ends
    is_coc      the values are diameters of the circle of confusion instead of depths
    """

    label: str
    meaning: str
    takes_ends: bool = False
    needs_ends: bool = False
    has_unit: bool = False
    is_disparity: bool = False
    is_coc: bool = False


class DepthConvention(StrEnum):
    """What the values of a depth channel are."""

    AUTO = "auto"
    DISTANCE = "distance"
    INVERSE = "inverse"
    NORMALIZED = "normalized"
    NORMALIZED_INVERTED = "normalized-inverted"
    DISPARITY = "disparity"
    DISPARITY_INVERTED = "disparity-inverted"
    COC = "coc"

    @property
    def facts(self) -> DepthFacts:
        """What is known of the convention."""
        match self:
            case DepthConvention.AUTO:
                words = "a guess, with its reason"
                return DepthFacts("guessed", words, takes_ends=True, has_unit=True)
            case DepthConvention.DISTANCE:
                return DepthFacts("distance", "in the unit of the scene", has_unit=True)
            case DepthConvention.INVERSE:
                return DepthFacts("1 / distance", "1/distance, 0 at infinity", has_unit=True)
            case DepthConvention.NORMALIZED:
                words = "0 near, 1 far"
                return DepthFacts(words, words, takes_ends=True, needs_ends=True)
            case DepthConvention.NORMALIZED_INVERTED:
                words = "1 near, 0 far"
                return DepthFacts(words, words, takes_ends=True, needs_ends=True)
            case DepthConvention.DISPARITY:
                words = (
                    "linear in 1/distance, 1 or white is near, as from phones and depth networks"
                )
                return DepthFacts("disparity, 1 near", words, takes_ends=True, is_disparity=True)
            case DepthConvention.DISPARITY_INVERTED:
                words = "linear in 1/distance, 0 or black is near"
                return DepthFacts("disparity, 0 near", words, takes_ends=True, is_disparity=True)
            case DepthConvention.COC:
                words = "signed diameter of the circle of confusion in pixels, used as it is"
                return DepthFacts("blur in pixels (coc)", words, is_coc=True)
            case _:
                assert_never(self)


class DepthKind(StrEnum):
    """What a distance is measured along."""

    AUTO = "auto"  # along the ray where the channel's name says so, else along the axis
    PLANAR = "planar"
    RADIAL = "radial"

    @property
    def label(self) -> str:
        """Words for a menu."""
        match self:
            case DepthKind.AUTO:
                return "guessed"
            case DepthKind.PLANAR:
                return "along the axis"
            case DepthKind.RADIAL:
                return "along the ray"
            case _:
                assert_never(self)


class DepthSide(StrEnum):
    """The half of a picture that holds its depth, as in side-by-side footage."""

    NONE = "none"
    RIGHT = "right"
    LEFT = "left"
    BOTTOM = "bottom"
    TOP = "top"


class DepthModelOutput(StrEnum):
    """What the values of a network are."""

    AUTO = "auto"
    DISPARITY = "disparity"  # even over 1/distance, of any scale and shift
    METRES = "metres"
    INVERSE = "inverse"  # 1/distance in meters


@dataclass(frozen=True)
class KnownDistance:
    """The distance of a pixel of the first frame, counted from the corner of the picture."""

    x_px: float
    y_px: float
    distance_m: float

    def __str__(self) -> str:
        return f"{self.x_px:g},{self.y_px:g}={self.distance_m:g}m"


def parse_known_distance(text: str) -> KnownDistance:
    """Parse "960,540=2.4m". Raises InputError for anything else."""
    pixel_text, _, distance_text = text.partition("=")
    try:
        x_px, y_px = (float(coordinate) for coordinate in pixel_text.split(","))
    except ValueError:
        raise InputError(
            f"{text!r} is not a pixel with its distance. Example: 960,540=2.4m."
        ) from None
    distance_m = parse_distance_m(distance_text)
    if not 0 < distance_m < math.inf:
        raise InputError(f"{text!r}: the distance must be above 0 and not infinite.")
    return KnownDistance(x_px, y_px, distance_m)
