"""The user's options for reading a plate, for facts missing from its file."""

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import (
    DepthConvention,
    DepthKind,
    DepthModelOutput,
    DepthSide,
    KnownDistance,
    parse_known_distance,
)
from heatlens.core.model.option import check_range, option_field, options_of
from heatlens.core.model.units import parse_scene_unit_m

SPIKE_FROM = 2.0  # ratio to the brightest neighbor from which a pixel is a spike
SPIKE_WHOLE = 4.0  # ratio from which it is removed entirely
LIFT_STOPS_MOST = 10.0


class PictureCurve(StrEnum):
    """How the values of a PNG, JPEG or TIFF become light."""

    color_space: str | None  # the name that OpenColorIO gives to the log of a camera

    def __new__(cls, word: str, color_space: str | None) -> Self:
        member = str.__new__(cls, word)
        member._value_ = word
        member.color_space = color_space
        return member

    AUTO = "auto", None  # whole numbers are sRGB, floating point is linear light
    SRGB = "srgb", None
    LINEAR = "linear", None
    LOGC3 = "logc3", "ARRI LogC3 (EI800)"
    LOGC4 = "logc4", "ARRI LogC4"
    SLOG3 = "slog3", "S-Log3 S-Gamut3.Cine"
    SLOG3_SGAMUT3 = "slog3-sgamut3", "S-Log3 S-Gamut3"
    APPLE_LOG = "apple-log", "Apple Log"
    VLOG = "vlog", "V-Log V-Gamut"
    CANON_LOG3 = "canon-log3", "CanonLog3 CinemaGamut D55"
    LOG3G10 = "log3g10", "Log3G10 REDWideGamutRGB"


@dataclass(frozen=True)
class PlateOptions:
    """How to read a file; by default, everything possible is found out.

    depth_channel    None: found by its name
    color_layer      None: found by its name; "" is the layer without a name
    scene_unit_m     meters in one unit of the depth channel
    near_m           meters at the near end of a normalized depth or a disparity
    far_m            meters at its far end
    focal_length_mm  only radial depth needs it; None: from the header
    sensor_width_mm  likewise
    depth_source     file or pattern that holds the depth; None: the picture does
    behind           files or patterns of the surfaces behind the picture, in any order
    behind_conventions  of the depths of `behind`, one each; (): as for a separate depth
                     file of the plate, else guessed
    picture_curve    of PNG, JPEG and TIFF
    eye              view of a stereo file; None: the first, or that of `color_layer`
    despike          replace lone pixels that are far too bright, see `plate.grain.despike`
    lift_highlights_stops  how much brighter than white clipped light was, see
                     `plate.picture.highlights`; 0: as it is
    strict           refuse ambiguous input, instead of choosing the likelier reading
    neighbours       frames on either side whose surfaces are used; None: 2 if the camera is known
    depth_model      a network that estimates the depth, in place of a depth that is stored
    depth_model_output  what its values are
    depth_known      scales its values
    one_distance_m   the distance of everything, in place of a depth
    flat_depth       a thing whose depth is replaced by its median, a plane or its nearest
    never_blur       a thing that stays as it is in the picture
    only_blur        the only thing that is blurred

    Raises InputError for an unknown convention, kind or curve, and for an impossible unit.
    """

    depth_channel: str | None = option_field(
        None,
        "depth channel",
        "channel that holds the depth, as `heatlens info` lists it (default: found by name)",
        metavar="NAME",
    )
    color_layer: str | None = option_field(
        None,
        "color layer",
        "layer that holds R, G, B; '' is the unnamed one (default: found by name)",
        metavar="NAME",
    )
    depth_convention: DepthConvention = option_field(
        DepthConvention.AUTO,
        "depth convention",
        "what the depth values are: distance, inverse (1/distance), normalized (0 near, 1 far), "
        "disparity (1 or white near), coc (blur in pixels); -inverted: the other end is near "
        "(default: a guess, with its reason)",
    )
    depth_kind: DepthKind = option_field(
        DepthKind.AUTO,
        "depth kind",
        "planar: measured along the optical axis, so that a wall seen head-on has one depth "
        "(default, except for Mitsuba's ray-distance channels); radial: along each ray, "
        "which needs focal length and sensor width",
    )
    scene_unit_m: float = option_field(
        1.0,
        "scene unit",
        "unit of the depth values: m, cm, mm, ft, in, or a number of metres (default: m)",
        metavar="UNIT",
        unit="m",
        parse=parse_scene_unit_m,
    )
    near_m: float | None = option_field(
        None, "near", "near end of a normalized depth or disparity", metavar="METRES", unit="m"
    )
    far_m: float | None = option_field(
        None, "far", "far end of a normalized depth or disparity", metavar="METRES", unit="m"
    )
    focal_length_mm: float | None = None
    sensor_width_mm: float | None = None
    depth_source: str | None = option_field(
        None,
        "depth",
        "depth file, if separate from the colour: EXR, PNG, TIFF, PFM, NPY; for a sequence its "
        "pattern, depth.####.exr",
        metavar="FILE",
        parse=os.path.expanduser,
    )
    behind: tuple[str, ...] = option_field(
        (),
        "behind",
        "a picture with depth of hidden surfaces, rendered by the same camera: a clean plate, "
        "a background; for a sequence its pattern. May be given several times, in any order",
        metavar="FILE",
        parse=os.path.expanduser,
    )
    behind_conventions: tuple[DepthConvention, ...] = ()
    picture_curve: PictureCurve = option_field(
        PictureCurve.AUTO,
        "picture curve",
        "curve of the colours of pictures and movies: srgb, linear, or the log of a camera, whose "
        "gamut is converted to Rec.709 (default: what a movie is tagged as, else sRGB for "
        "integers, linear light for floating point)",
    )
    eye: str | None = option_field(
        None,
        "eye",
        "view of a stereo file: left, right, or as `heatlens info` lists it (default: the first)",
        metavar="NAME",
    )
    despike: bool = option_field(
        False,
        "despike",
        f"replace single pixels over {SPIKE_FROM:g} times as bright as their neighbours by the "
        "median of these: fireflies of a path tracer. Lamps of one pixel without a depth of "
        "their own are lost too; denoising is better",
    )
    lift_highlights_stops: float = option_field(
        0.0,
        "lift highlights",
        "make light that a picture of whole numbers clips at white so many stops brighter, so that "
        "its lamps glow out of focus; light up to 0.9 of white stays (try 3)",
        metavar="STOPS",
        least=0,
        most=LIFT_STOPS_MOST,
    )
    strict: bool = option_field(
        False,
        "strict",
        "stop, instead of warning, if the depth is ambiguous or focus, lens and depth are "
        "implausible together, or if machines of a farm have different drivers",
    )
    neighbours: int | None = option_field(
        None,
        "neighbours",
        "number of frames on either side from which hidden surfaces are taken, 0 for none "
        "(default: 2 if the headers have the camera, worldToCamera; none for a single file)",
        metavar="N",
        least=0,
        most=64,
    )
    depth_model: str | None = option_field(
        None,
        "depth model",
        "estimate the depth with your own network, an ONNX file: Depth Anything, MiDaS, Depth "
        "Pro, Metric3D and others, recognised by the name of the file; where distances are "
        "missing, give --near and --far, or --depth-known",
        metavar="FILE.onnx",
        parse=os.path.expanduser,
    )
    depth_model_output: DepthModelOutput = option_field(
        DepthModelOutput.AUTO,
        "depth model output",
        "what the network gives: disparity, even over 1/distance; metres; inverse, 1/metres "
        "(default: by its name, else disparity)",
    )
    depth_known: KnownDistance | None = option_field(
        None,
        "depth known",
        "the distance of a pixel of the first frame, such as 960,540=2.4m, which scales the "
        "estimate of a network",
        metavar="X,Y=DISTANCE",
        parse=parse_known_distance,
    )
    depth_side: DepthSide = option_field(
        DepthSide.NONE,
        "depth side",
        "half of the picture that holds its depth in grey, as in side-by-side footage",
    )
    one_distance_m: float | None = option_field(
        None, "one distance", "distance of all of a picture without depth", metavar="M", unit="m"
    )
    flat_depth: str | None = option_field(
        None,
        "flat depth",
        "mend a wrong depth inside a matte, cryptomatte:THING, CHANNEL:ID or matte:CHANNEL: its "
        "median becomes the depth of all of it, or with plane: or nearest: before it a plane, or "
        "its nearest part",
        metavar="MATTE",
    )
    never_blur: str | None = option_field(
        None,
        "never blur",
        "keep a thing sharp at any focus, such as a title or the insert of a screen, by its "
        "matte: cryptomatte:THING, CHANNEL:ID or matte:CHANNEL",
        metavar="MATTE",
    )
    only_blur: str | None = option_field(
        None, "only blur", "blur nothing but the thing in a matte, named likewise", metavar="MATTE"
    )

    @property
    def files_beside(self) -> tuple[str, ...]:
        """The files that belong to the picture: its depth or a network, and what lies behind it."""
        return (*filter(None, (self.depth_source, self.depth_model)), *self.behind)

    def __post_init__(self) -> None:
        # Programs that use this package as a library write these as plain words.
        kinds: dict[str, type[StrEnum]] = {
            "depth_convention": DepthConvention,
            "depth_kind": DepthKind,
            "picture_curve": PictureCurve,
            "depth_model_output": DepthModelOutput,
            "depth_side": DepthSide,
        }
        for name, kind in kinds.items():
            object.__setattr__(self, name, _enum_member(kind, name, getattr(self, name)))
        check_range("near end of the depth in metres", self.near_m, 0.0, math.inf)
        check_range("far end of the depth in metres", self.far_m, 0.0, math.inf)
        check_range("one distance in metres", self.one_distance_m, 0.0, math.inf)
        check_range("focal length in mm", self.focal_length_mm, 0.0, math.inf)
        check_range("sensor width in mm", self.sensor_width_mm, 0.0, math.inf)
        for name in ("neighbours", "lift_highlights_stops"):
            option, value = options_of(PlateOptions)[name], getattr(self, name)
            if value is not None and not option.allows(value):
                range_text = f"{option.least:g} to {option.most:g}"
                raise InputError(
                    f"{option.words.capitalize()} must be {range_text}, got {value:g}."
                )
        if not 0 < self.scene_unit_m < math.inf:
            raise InputError(
                f"The scene unit must be a number of metres above 0, got {self.scene_unit_m:g}."
            )

    def refuse_estimate_without_network(self) -> None:
        """Raise InputError for an option of an estimated depth where no network is named."""
        has_output = self.depth_model_output is not DepthModelOutput.AUTO
        if self.depth_model is None and (has_output or self.depth_known is not None):
            flag = "--depth-model-output" if has_output else "--depth-known"
            raise InputError(
                f"{flag} is for a depth that a network estimates: name the network with "
                f"--depth-model, or leave {flag} out."
            )

    def with_files_beside(self, convert_path: Callable[[str], str]) -> "PlateOptions":
        """Return the options with `convert_path` applied to the paths in `files_beside`."""
        depth, model = self.depth_source, self.depth_model
        return replace(
            self,
            depth_source=None if depth is None else convert_path(depth),
            depth_model=None if model is None else convert_path(model),
            behind=tuple(convert_path(text) for text in self.behind),
        )


def _enum_member(kind: type[StrEnum], name: str, word: str) -> StrEnum:
    """Return the member that `word` names. Raises InputError that lists the members."""
    try:
        return kind(word)
    except ValueError:
        words = ", ".join(kind)
        raise InputError(
            f"{word!r} is not a {name.replace('_', ' ')}; known are {words}."
        ) from None
