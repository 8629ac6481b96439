"""The keywords of the functions with their types, so that editors and type checkers know them.

A test compares them with the fields of `OpeningFields`, `DefocusSettings` and `PlateOptions`.
"""

import os
from typing import Literal, TypedDict

from heatlens.core.model.depth_words import (
    DepthConvention,
    DepthKind,
    DepthModelOutput,
    DepthSide,
    KnownDistance,
)
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.plate_options import PictureCurve
from heatlens.core.model.shot.settings import Bokeh, Method, Quality

Path = str | os.PathLike[str]
Convention = (
    DepthConvention
    | Literal[
        "auto",
        "distance",
        "inverse",
        "normalized",
        "normalized-inverted",
        "disparity",
        "disparity-inverted",
        "coc",
    ]
)


Curve = (
    PictureCurve
    | Literal[
        "auto",
        "srgb",
        "linear",
        "logc3",
        "logc4",
        "slog3",
        "slog3-sgamut3",
        "apple-log",
        "vlog",
        "canon-log3",
        "log3g10",
    ]
)


class RenderOptions(TypedDict, total=False):
    """The opening of the lens, and the blur."""

    squeeze: float
    blades: int
    blade_rotation_deg: float
    blade_curvature: float
    cat_eye: float
    rim: float
    axial_colour_mm: float
    aperture_image: Path | OpeningImage | None
    tilt_deg: float
    tilt_direction_deg: float
    split_dioptres: float
    split_position: float
    split_direction_deg: float
    split_softness: float
    bokeh: Bokeh | Literal["heat", "gaussian", "disc"]
    quality: Quality | Literal["draft", "preview", "film", "final"]
    layers: int | None
    proxy: float
    method: (
        Method
        | Literal["diffusion", "heat", "gather", "scatter", "pyramid", "accumulation", "raytraced"]
    )
    views: int
    parts: int


class FrameOptions(RenderOptions, total=False):
    """`RenderOptions`, and all values of the lens."""

    focal_length_mm: float | None
    sensor_width_mm: float | None
    f_stop: float | None
    focus_distance_m: float | None
    focus_at: tuple[int, int] | None
    lens_model: str | None


class ExportKeywords(FrameOptions, total=False):
    """`FrameOptions`, and the options of the files."""

    frames: str
    missing: Literal["hold", "black", "stop"]
    force: bool
    overwrite: bool
    fps: float | None
    start_timecode: str | None
    is_float: bool
    compression: Literal["none", "rle", "zips", "zip", "piz", "dwaa", "dwab"]
    with_depth: bool
    with_coc: bool
    keep_channels: str
    burn_in: bool
    burn_in_text: str
    shot_name: str
    unit: Literal["m", "ft"]


class ReadingOptions(TypedDict, total=False):
    """The options for reading a plate."""

    depth_channel: str | None
    color_layer: str | None
    depth_convention: Convention
    depth_kind: DepthKind | Literal["auto", "planar", "radial"]
    scene_unit_m: float
    near_m: float | None
    far_m: float | None
    focal_length_mm: float | None
    sensor_width_mm: float | None
    depth_source: Path | None
    behind: Path | list[Path] | tuple[Path, ...]
    behind_conventions: Convention | list[Convention] | tuple[Convention, ...]
    picture_curve: Curve
    eye: str | None
    despike: bool
    lift_highlights_stops: float
    strict: bool
    neighbours: int | None
    depth_model: str | None
    depth_model_output: DepthModelOutput | Literal["auto", "disparity", "metres", "inverse"]
    depth_known: KnownDistance | str | None
    depth_side: DepthSide | Literal["none", "right", "left", "bottom", "top"]
    one_distance_m: float | None
    flat_depth: str | None
    never_blur: str | None
    only_blur: str | None
