"""What the user says about a plate that its file does not say itself."""

from dataclasses import dataclass
from enum import StrEnum
from typing import assert_never

from heatlens.errors import InputError


@dataclass(frozen=True)
class DepthFacts:
    """The facts of a depth convention, from which reader, command line and panels derive.

    label       words for a menu
    meaning     words that explain the values, for help and tooltips
    takes_ends  distances of a near and a far end count
    needs_ends  without both ends there is no distance, not even an assumed one
    has_unit    the values are in the unit of the scene, or in one over it
    is_coc      the values are diameters of the circle of confusion instead of depths
    """

    label: str
    meaning: str
    takes_ends: bool = False
    needs_ends: bool = False
    has_unit: bool = False
    is_coc: bool = False


class DepthConvention(StrEnum):
    """What the values of a depth channel are."""

    AUTO = "auto"
    DISTANCE = "distance"
    INVERSE = "inverse"
    NORMALIZED = "normalized"
    NORMALIZED_INVERTED = "normalized-inverted"
    DISPARITY = "disparity"
    COC = "coc"

    @property
    def facts(self) -> DepthFacts:
        """Return what is known of the convention."""
        match self:
            case DepthConvention.AUTO:
                words = "a guess that says why"
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
                words = "evenly over 1/distance, 1 or white near, as phones and depth networks do"
                return DepthFacts("disparity, 1 near", words, takes_ends=True)
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
        """Return words for a menu."""
        match self:
            case DepthKind.AUTO:
                return "guessed"
            case DepthKind.PLANAR:
                return "along the axis"
            case DepthKind.RADIAL:
                return "along the ray"
            case _:
                assert_never(self)


class PictureCurve(StrEnum):
    """How the values of a PNG, JPEG or TIFF become light."""

    AUTO = "auto"  # whole numbers are sRGB, floating point is linear light
    SRGB = "srgb"
    LINEAR = "linear"


@dataclass(frozen=True)
class PlateOptions:
    """How to read a file; the defaults find out what they can.

    Raises InputError for a convention, kind or curve that is none.
    """

    depth_channel: str | None = None  # None: found by its name
    color_layer: str | None = None  # None: found by its name; "" is the layer without a name
    depth_convention: DepthConvention = DepthConvention.AUTO
    depth_kind: DepthKind = DepthKind.AUTO
    scene_unit_m: float = 1.0  # metres in one unit of the depth channel
    near_m: float | None = None  # metres at the near end of a normalised depth or a disparity
    far_m: float | None = None  # metres at its far end
    focal_length_mm: float | None = None  # only radial depth needs it; None: from the header
    sensor_width_mm: float | None = None  # likewise
    depth_source: str | None = None  # file or pattern that holds the depth; None: the picture does
    behind: tuple[str, ...] = ()  # files or patterns of what lies behind the picture, in any order
    picture_curve: PictureCurve = PictureCurve.AUTO
    eye: str | None = None  # view of a stereo file; None: the first, or that of `color_layer`
    strict: bool = False  # refuse what could be read in two ways, instead of taking the likelier

    @property
    def files_beside(self) -> tuple[str, ...]:
        """The files or patterns that belong to the picture: its depth, and what lies behind it."""
        depth = () if self.depth_source is None else (self.depth_source,)
        return (*depth, *self.behind)

    def __post_init__(self) -> None:
        # Programs that use this package as a library write these as plain words.
        kinds: dict[str, type[StrEnum]] = {
            "depth_convention": DepthConvention,
            "depth_kind": DepthKind,
            "picture_curve": PictureCurve,
        }
        for name, kind in kinds.items():
            object.__setattr__(self, name, _member(kind, name, getattr(self, name)))


def _member(kind: type[StrEnum], name: str, word: str) -> StrEnum:
    """Return the member that `word` names. Raises InputError with those there are."""
    try:
        return kind(word)
    except ValueError:
        known = ", ".join(kind)
        raise InputError(
            f"{word!r} is not a {name.replace('_', ' ')}; known are {known}."
        ) from None
