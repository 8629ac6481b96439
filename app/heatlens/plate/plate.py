"""What the rest of the program knows of an input picture, whatever the file looked like."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from heatlens.model.boxes import Box
from heatlens.model.lens_model import LensModel
from heatlens.model.plate_options import DepthConvention, DepthKind
from heatlens.model.plausibility import DepthSpan
from heatlens.plate.fragments import FragmentLists

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
    model: LensModel | None = None  # None: no CG renderer is named
    sources: Mapping[str, str] = field(default_factory=dict)  # field name -> what tells it


@dataclass(frozen=True)
class DepthReport:
    """How the depth channel was read, for the person who has to trust it."""

    channel: str
    convention: DepthConvention  # never AUTO: what was used
    kind: DepthKind
    why: str  # one sentence: why this convention
    near_m: float  # nearest finite depth; infinite where nothing was hit at all, NaN for CoC
    far_m: float  # farthest finite depth; likewise
    infinite_count: int  # pixels where nothing was hit
    repaired_count: int  # pixels that held no depth and took a neighbour's
    question: str = ""  # what only a person can answer where another convention fits as well


@dataclass(frozen=True)
class BehindReport:
    """What one picture adds to a plate, for the person who chose it.

    name         the file or pattern as it was given, or the part or layer of the plate's own file
    hidden_part  where it lies behind what is seen, 0..1 of the plate's pixels
    seen_part    where it is seen itself, in front of the plate or where that is empty, likewise
    convention   what the values of its depth were taken for
    """

    name: str
    hidden_part: float
    seen_part: float
    convention: DepthConvention = DepthConvention.DISTANCE

    @property
    def sentence(self) -> str:
        """What it adds, with its name."""
        return f"{self.name} {self.words}."

    @property
    def words(self) -> str:
        """What it adds, as the end of a sentence."""
        hidden, seen = (f"{100 * part:.3g} %" for part in (self.hidden_part, self.seen_part))
        if not (self.hidden_part or self.seen_part):
            return (
                "adds nothing: it is nowhere behind what the picture shows, nor in front of it. "
                "Its depth may be in another unit, or it is the same picture"
            )
        if not self.seen_part:
            return f"lies behind {hidden} of the picture"
        if not self.hidden_part:
            return f"is seen in {seen} of the picture"
        return f"lies behind {hidden} of the picture and is seen in {seen}"


class Pixels(Protocol):
    """A plate's pixels, over its data window: in memory, or fetched when they are asked for.

    `color` is (H, W, 4) float32, scene-linear, premultiplied, C-contiguous; alpha is 1 where the
    file has none. Exactly one of `depth_m` and `coc_px`, both (H, W) float32, is there: planar
    metres with +inf where nothing was hit, or signed diameters of the circle of confusion in
    pixels, negative in front of the focus.
    """

    @property
    def color(self) -> FloatImage: ...
    @property
    def depth_m(self) -> FloatImage | None: ...
    @property
    def coc_px(self) -> FloatImage | None: ...

    def color_in(self, area: Box) -> FloatImage:
        """Return the colours of an area that lies inside, counted from the first pixel."""

    def depth_in(self, area: Box) -> FloatImage:
        """Return the metres of an area that lies inside; the plate must have distances."""


@dataclass(frozen=True, eq=False)
class ReadPixels:
    """Pixels in memory."""

    color: FloatImage
    depth_m: FloatImage | None = None
    coc_px: FloatImage | None = None

    def color_in(self, area: Box) -> FloatImage:
        """See `Pixels`."""
        return self.color[area.y0 : area.y1, area.x0 : area.x1]

    def depth_in(self, area: Box) -> FloatImage:
        """See `Pixels`."""
        assert self.depth_m is not None
        return self.depth_m[area.y0 : area.y1, area.x0 : area.x1]


def read_pixels(color: FloatImage, depth: FloatImage, is_coc: bool) -> ReadPixels:
    """Return the pixels of a file, whose depth is a circle of confusion or metres."""
    return ReadPixels(color, coc_px=depth) if is_coc else ReadPixels(color, depth)


@dataclass(frozen=True, eq=False)
class Plate:
    """One pinhole picture with its depth, over the data window.

    Whoever needs few pixels, often, takes them from `pixels`: those of a scene lie on the GPU, and
    `color` and `depth_m` bring all of them.
    """

    path: Path
    pixels: Pixels
    has_alpha: bool
    data_window: Box
    display_window: Box
    pixel_aspect_ratio: float  # width of a pixel over its height
    camera: CameraHeader
    depth: DepthReport
    aovs: tuple[str, ...]  # every channel of the file, by its full name
    attributes: dict[str, Any]  # header entries to carry to the output
    notes: tuple[str, ...]  # sentences to say aloud: repairs, guesses, warnings
    compression: str = ""  # of the file, as the writer names it; "" where it has none of these
    views: tuple[str, ...] = ()  # of a stereo file, the first one first
    fragments: FragmentLists | None = None  # what is known behind the picture; None: nothing
    behind: tuple[BehindReport, ...] = ()  # the pictures that this is known from, in any order

    @property
    def color(self) -> FloatImage:
        """All of `Pixels.color`."""
        return self.pixels.color

    @property
    def depth_m(self) -> FloatImage | None:
        """All of `Pixels.depth_m`."""
        return self.pixels.depth_m

    @property
    def coc_px(self) -> FloatImage | None:
        """All of `Pixels.coc_px`."""
        return self.pixels.coc_px

    def in_memory(self) -> "Plate":
        """Return the plate with all of its pixels fetched, for other threads."""
        return replace(self, pixels=ReadPixels(self.color, self.depth_m, self.coc_px))

    @property
    def has_distances(self) -> bool:
        """True for a plate with metres rather than a circle of confusion.

        Asking fetches nothing.
        """
        return self.pixels.coc_px is None


def depth_span(plate: Plate, scene_unit_m: float) -> DepthSpan:
    """Return the depths of a plate that was read with this unit, to check a lens against."""
    report = plate.depth
    return DepthSpan(report.near_m, report.far_m, report.infinite_count > 0, scene_unit_m)
