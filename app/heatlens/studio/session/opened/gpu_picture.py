"""The picture of the open source on the GPU, and how it relates to the requested frame."""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager

from heatlens.core.base.errors import GpuError, HeatlensError
from heatlens.core.model.value_bins import (
    DepthHistogram,
    ValueBins,
    depth_histogram,
    scale_end_dioptres,
)
from heatlens.media.plate.plate import Plate
from heatlens.render.frame_renderer import FrameRenderer


class GpuPicture:
    """The picture of the open source that is shown now.

    Feeds put pictures here; panels and the scheduler read them.

    plate       the plate; None while there is none
    version     counts the pictures that were uploaded
    is_finer    True if the latest picture is the previous one with less noise
    is_black    True if a missing frame is shown as black
    is_settled  True if the requested frame is shown, or cannot be
    problem     a sentence why the frame cannot be shown, or ""
    """

    def __init__(self, renderer: FrameRenderer) -> None:
        self.renderer = renderer
        self.plate: Plate | None = None
        self.histogram: DepthHistogram | None = None
        self._bins: ValueBins | None = None  # dioptres of the plate; None if it has none
        self._most_dioptres = 0.0  # largest of all frames so far, so that the axis is stable
        self.upload_s = 0.0
        self.version = 0
        self.is_finer = False
        self.is_black = False
        self.is_settled = False
        self.problem = ""
        self.frame = 0  # the requested one

    def request(self, frame: int) -> None:
        """Begin to show `frame`: no problem is known, and it is not black."""
        self.problem, self.is_black, self.frame = "", False, frame

    def reset_axis(self) -> None:
        """Reset the range of the distance axis, because another source follows."""
        self._most_dioptres = 0.0

    def extend_axis(self, nearest_m: float) -> None:
        """Extend the distance axis to `nearest_m`, the nearest distance of frames not shown yet."""
        max_dioptres = scale_end_dioptres(1.0 / nearest_m)
        if math.isfinite(max_dioptres) and max_dioptres > self._most_dioptres:
            self._most_dioptres = max_dioptres
            self._make_histogram()

    def load(self, plate: Plate) -> None:
        """Upload a plate to the GPU in place of the previous one.

        Raise HeatlensError if GPU memory is full; then there is no picture.
        """
        start = time.perf_counter()
        self.plate = None
        self.renderer.load(plate)
        self.renderer.ctx.finish()
        self.upload_s = time.perf_counter() - start
        self._use_loaded_plate()

    def mark_changed(self) -> None:
        """Compute everything derived from the picture again, as after `load`."""
        if self.plate is not None:
            self.version += 1

    @contextmanager
    def draw_safely(self) -> Iterator[None]:
        """Show what the renderer draws in the block; an error of the block becomes `problem`."""
        try:
            yield
        except HeatlensError as error:
            self.problem = str(error)
            if isinstance(error, GpuError):
                self.plate = None  # its texture was overwritten
            return
        if self.renderer.loaded.plate is not self.plate:
            self._use_loaded_plate()

    def _use_loaded_plate(self) -> None:
        """Use the plate that the renderer has loaded, and make its histogram."""
        loaded = self.renderer.loaded
        self.plate = loaded.plate
        self._bins = loaded.bins if loaded.plate.has_distances else None
        self._make_histogram()
        self.version += 1
        self.is_finer = False

    def _make_histogram(self) -> None:
        """Make the histogram of the plate, over an axis that never becomes shorter."""
        self.histogram = None
        if self._bins is not None:
            self.histogram = depth_histogram(self._bins, self._most_dioptres)
            self._most_dioptres = self.histogram.most_dioptres
