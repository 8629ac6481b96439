"""The plate: an input picture with its depth, independent of the format of its file."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.focus.plausibility import DepthSpan
from heatlens.core.model.lens.lens import LensModel
from heatlens.core.model.value_bins import ValueBins, bin_values
from heatlens.media.plate.fragments import FragmentLists

FloatImage = NDArray[np.float32]


@dataclass(frozen=True)
class CameraHeader:
    """The lens values in a header; None for those that it does not have."""

    focus_distance_m: float | None = None  # may be infinite
    f_stop: float | None = None
    focal_length_mm: float | None = None
    sensor_width_mm: float | None = None
    sensor_height_mm: float | None = None
    t_stop: float | None = None
    model: LensModel | None = None  # None: the header names no CG renderer
    sources: Mapping[str, str] = field(default_factory=dict)  # field name -> its header entry
    # field name -> the entry with an impossible value, for which the field is None
    refused: Mapping[str, str] = field(default_factory=dict, compare=False)


@dataclass(frozen=True)
class DepthReport:
    """How the depth channel was read, for the user who has to rely on it."""

    channel: str
    convention: DepthConvention  # never AUTO: what was used
    kind: DepthKind
    why: str  # one sentence: why this convention
    near_m: float  # nearest finite depth; infinity if nothing was hit at all, NaN for CoC
    far_m: float  # farthest finite depth; infinity and NaN as for near_m
    infinite_count: int  # pixels where nothing was hit
    repaired_count: int  # pixels without a valid depth, which took that of a neighbor
    question: str = ""  # asks the user to choose if another convention fits nearly as well


@dataclass(frozen=True)
class BehindReport:
    """A report on one picture behind a plate.

    name         the file or pattern as it was given, or a layer of the plate's own file
    hidden_part  share of the plate's pixels in which it lies behind the visible surface, 0..1
    seen_part    share in which it is visible, in front of the plate or where that is empty, 0..1
    convention   how the values of its depth were interpreted
    """

    name: str
    hidden_part: float
    seen_part: float
    convention: DepthConvention = DepthConvention.DISTANCE

    @property
    def sentence(self) -> str:
        """A full sentence on where the picture lies, beginning with its name."""
        return f"{self.name} {self.words}."

    @property
    def words(self) -> str:
        """Where the picture lies, as the predicate of a sentence."""
        hidden, seen = (f"{100 * part:.3g} %" for part in (self.hidden_part, self.seen_part))
        if not (self.hidden_part or self.seen_part):
            return (
                "adds nothing: it lies neither behind nor in front of what the picture shows. "
                "Its depth may be in another unit, or it is the same picture"
            )
        if not self.seen_part:
            return f"lies behind {hidden} of the picture"
        if not self.hidden_part:
            return f"is seen in {seen} of the picture"
        return f"lies behind {hidden} of the picture and is seen in {seen}"


class Pixels(Protocol):
    """The pixels of a plate over its data window, in memory or fetched from the GPU on access.

    `color` is (H, W, 4) float32, scene-linear, premultiplied, C-contiguous; alpha is 1 if the file
    has none. Exactly one of `depth_m` and `coc_px`, both (H, W) float32, is not None: planar meters
    with +inf where nothing was hit, or signed diameters of the circle of confusion in pixels,
    negative in front of the focus.
    """

    @property
    def color(self) -> FloatImage: ...
    @property
    def depth_m(self) -> FloatImage | None: ...
    @property
    def coc_px(self) -> FloatImage | None: ...

    def color_in(self, area: Box) -> FloatImage:
        """Return the colors of an area inside the picture; (0, 0) is the first pixel."""

    def depth_in(self, area: Box) -> FloatImage:
        """Return the depths in meters of an area inside; the plate must have distances."""


@dataclass(frozen=True, eq=False)
class ReadPixels:
    """Pixels in memory."""

    color: FloatImage
    depth_m: FloatImage | None = None
    coc_px: FloatImage | None = None

    def color_in(self, area: Box) -> FloatImage:
        return self.color[area.y0 : area.y1, area.x0 : area.x1]

    def depth_in(self, area: Box) -> FloatImage:
        """Return the depth of an area; the plate must have one."""
        assert self.depth_m is not None
        return self.depth_m[area.y0 : area.y1, area.x0 : area.x1]


def read_pixels(color: FloatImage, depth: FloatImage, is_coc: bool) -> ReadPixels:
    """Return pixels in memory; `depth` (H, W) is a circle of confusion if `is_coc`, else meters."""
    return ReadPixels(color, coc_px=depth) if is_coc else ReadPixels(color, depth)


@dataclass(frozen=True, eq=False)
class Cutout:
    """A thing that a matte keeps from the blur, with the rest of the picture, which is blurred.

    light         (H, W, 4) light of the thing times its share, also where it continues behind a
                  nearer surface
    share         (H, W) part of each pixel that the thing covers, 0..1
    depth         (H, W) depth of the thing, as the plate holds it
    surroundings  the picture without the thing; what the thing hides is guessed
    backdrop      (H, W, 4) sharp colors over which the surroundings are blurred, which then have
                  alpha; None if they cover all pixels
    """

    light: FloatImage
    share: FloatImage
    depth: FloatImage
    surroundings: ReadPixels
    backdrop: FloatImage | None = None


@dataclass(frozen=True, eq=False)
class Plate:
    """One pinhole picture with its depth, over the data window.

    Code that often needs a few pixels should use `pixels`: those of a scene are on the GPU, and
    `color` and `depth_m` download all of them.
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
    attributes: dict[str, object]  # header entries to copy to the output
    notes: tuple[str, ...]  # sentences to show to the user: repairs, guesses, warnings
    compression: str = ""  # compression of the file, as `--compression` names it; "" for others
    views: tuple[str, ...] = ()  # views of a stereo file, the default view first
    fragments: FragmentLists | None = None  # the surfaces behind the picture, if known
    behind: tuple[BehindReport, ...] = ()  # the sources of `fragments`, in any order
    surfaces_lost: str = ""  # a sentence, where surfaces behind were merged or left out
    missing_count: int = 0  # pixels whose depth a renderer has not sent yet
    # The same plate with a border of pixels from other frames, which blur into the frame.
    with_border: "Plate | None" = None
    world_to_camera: NDArray[np.float64] | None = None  # 4x4 in meters, if the header has it
    cutout: Cutout | None = None  # the thing that a matte keeps from the blur

    @property
    def color(self) -> FloatImage:
        """The colors of all pixels, see `Pixels.color`."""
        return self.pixels.color

    @property
    def depth_m(self) -> FloatImage | None:
        """The depths of all pixels, see `Pixels.depth_m`."""
        return self.pixels.depth_m

    @property
    def coc_px(self) -> FloatImage | None:
        """The circles of confusion of all pixels, see `Pixels.coc_px`."""
        return self.pixels.coc_px

    def in_memory(self) -> "Plate":
        """Return the plate with its pixels in memory, which other threads may read."""
        return replace(self, pixels=ReadPixels(self.color, self.depth_m, self.coc_px))

    @cached_property
    def bins(self) -> ValueBins:
        """The distribution of the surfaces, including those behind the picture.

        In dioptres, or in pixels if the plate holds circles of confusion.
        """
        if self.coc_px is not None:
            return bin_values(self.coc_px)
        assert self.depth_m is not None
        dioptres = np.float32(1.0) / self.depth_m
        if self.fragments is not None:
            dioptres = np.concatenate([dioptres.ravel(), self.fragments.dioptres])
        return bin_values(dioptres)

    @cached_property
    def visible_bins(self) -> ValueBins:
        """The distribution of the visible surfaces inside the frame.

        For a plate without fragments it is that of `bins`.
        """
        if self.fragments is None or self.depth_m is None:
            return self.bins
        display, x, y = self.display_window, self.data_window.x0, self.data_window.y0
        frame_area = np.s_[
            max(display.y0 - y, 0) : display.y1 - y, max(display.x0 - x, 0) : display.x1 - x
        ]
        frame_depth_m = self.depth_m[frame_area]
        return bin_values(np.float32(1.0) / (frame_depth_m if frame_depth_m.size else self.depth_m))

    def with_reason(self, guess: DepthReport | None) -> "Plate":
        """Return the plate with the reason of a guess for how its depth is read; None for its own.

        Frames after the first are read as it was, and would give that as their reason.
        """
        if guess is None:
            return self
        return replace(self, depth=replace(self.depth, why=guess.why, question=guess.question))

    def count_bins(self) -> "Plate":
        """Count the bins now, for threads that read them later, and return the plate."""
        assert self.bins is not None and self.visible_bins is not None
        if self.with_border is not None:
            self.with_border.count_bins()
        return self

    def contains_pixel(self, x: int, y: int) -> bool:
        """Return True if the data window contains pixel (x, y) of the display window."""
        return self.data_window.contains(x + self.display_window.x0, y + self.display_window.y0)

    @property
    def has_distances(self) -> bool:
        """True for a plate with distances, False for one with circles of confusion.

        Reading this property fetches no pixels.
        """
        return self.pixels.coc_px is None


def depth_span(plate: Plate, scene_unit_m: float) -> DepthSpan:
    """Return the range of depths of a plate that was read with this scene unit."""
    report = plate.depth
    return DepthSpan(report.near_m, report.far_m, report.infinite_count > 0, scene_unit_m)
