"""What the user says about a plate that its file does not say itself."""

from dataclasses import dataclass
from typing import Literal

DepthConvention = Literal[
    "auto", "distance", "inverse", "normalized", "normalized-inverted", "disparity", "coc"
]
PictureCurve = Literal["auto", "srgb", "linear"]
DepthKind = Literal["planar", "radial"]
WishedKind = Literal["auto", DepthKind]


@dataclass(frozen=True)
class PlateOptions:
    """How to read a file; the defaults find out what they can."""

    depth_channel: str | None = None  # None: found by its name
    color_layer: str | None = None  # None: found by its name; "" is the layer without a name
    depth_convention: DepthConvention = "auto"
    depth_kind: WishedKind = "auto"  # radial: along the ray; auto: where the name says so
    scene_unit_m: float = 1.0  # metres in one unit of the depth channel
    near_m: float | None = None  # metres at the near end of a normalised depth or a disparity
    far_m: float | None = None  # metres at its far end
    focal_length_mm: float | None = None  # only radial depth needs it; None: from the header
    sensor_width_mm: float | None = None  # likewise
    depth_source: str | None = None  # file or pattern that holds the depth; None: the picture does
    picture_curve: PictureCurve = "auto"  # of PNG, JPEG, TIFF: how their values become light
    eye: str | None = None  # view of a stereo file; None: the first, or that of `color_layer`
    strict: bool = False  # refuse what could be read in two ways, instead of taking the likelier
