"""What the rest of the program knows of an input picture, whatever the file looked like."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.model.boxes import Box
from heatlens.model.plate_options import DepthConvention, DepthKind

FloatImage = NDArray[np.float32]


@dataclass(frozen=True)
class CameraHeader:
    """The lens as the header tells it; None where it does not."""

    focus_distance_m: float | None = None  # may be infinite
    f_stop: float | None = None
    focal_length_mm: float | None = None
    sensor_width_mm: float | None = None
    sensor_height_mm: float | None = None
    t_stop: float | None = None
    sources: Mapping[str, str] = field(default_factory=dict)  # field name -> attribute name


@dataclass(frozen=True)
class DepthReport:
    """How the depth channel was read, for the person who has to trust it."""

    channel: str
    convention: DepthConvention  # never "auto": what was used
    kind: DepthKind
    why: str  # one sentence: why this convention
    near_m: float  # nearest finite depth; infinite where nothing was hit at all, NaN for CoC
    far_m: float  # farthest finite depth; likewise
    infinite_count: int  # pixels where nothing was hit
    repaired_count: int  # pixels that held no depth and took a neighbour's


@dataclass(frozen=True, eq=False)
class Plate:
    """One pinhole picture with its depth, over the data window.

    `color` is (H, W, 4) float32, scene-linear, premultiplied, C-contiguous; alpha is 1 where the
    file has none. Exactly one of `depth_m` and `coc_px`, both (H, W) float32, is there: planar
    metres with +inf where nothing was hit, or signed diameters of the circle of confusion in
    pixels, negative in front of the focus.
    """

    path: Path
    color: FloatImage
    has_alpha: bool
    depth_m: FloatImage | None
    coc_px: FloatImage | None
    data_window: Box
    display_window: Box
    pixel_aspect_ratio: float  # width of a pixel over its height
    camera: CameraHeader
    depth: DepthReport
    aovs: tuple[str, ...]  # every channel of the file, by its full name
    attributes: dict[str, Any]  # header entries to carry to the output
    notes: tuple[str, ...]  # sentences to say aloud: repairs, guesses, warnings
