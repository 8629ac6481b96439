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
    dioptres_shown,
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

    def ask(self, frame: int) -> None:
        """Begin to show `frame`."""
        self.problem, self.is_black, self.frame = "", False, frame

    def begin_axis(self) -> None:
        """Reset the range of the distance axis, because another source follows."""
        self._most_dioptres = 0.0

    def reach(self, nearest_m: float) -> None:
        """Extend the distance axis to `nearest_m`, the nearest distance of frames not shown yet."""
        most = dioptres_shown(1.0 / nearest_m)
        if math.isfinite(most) and most > self._most_dioptres:
            self._most_dioptres = most
            self._count_depths()

    def load(self, plate: Plate) -> None:
        """Upload a plate to the GPU in place of the previous one.

        Raise HeatlensError if GPU memory is full; then there is no picture.
        """
        start = time.perf_counter()
        self.plate = None
        self.renderer.load(plate)
        self.renderer.ctx.finish()
        self.upload_s = time.perf_counter() - start
        self._take_loaded()

    def count_again(self) -> None:
        """Compute everything derived from the picture again, as after `load`."""
        if self.plate is not None:
            self.version += 1

    @contextmanager
    def drawing(self) -> Iterator[None]:
        """Show what the renderer draws in the block; an error of the block becomes `problem`."""
        try:
            yield
        except HeatlensError as error:
            self.problem = str(error)
            if isinstance(error, GpuError):
                self.plate = None  # it was overwritten
            return
        if self.renderer.loaded.plate is not self.plate:
            self._take_loaded()

    def _take_loaded(self) -> None:
        loaded = self.renderer.loaded
        self.plate = loaded.plate
        self._bins = loaded.bins if loaded.plate.has_distances else None
        self._count_depths()
        self.version += 1
        self.is_finer = False

    def _count_depths(self) -> None:
        """Make the histogram of the plate, over an axis that never becomes shorter."""
        self.histogram = None
        if self._bins is not None:
            self.histogram = depth_histogram(self._bins, self._most_dioptres)
            self._most_dioptres = self.histogram.most_dioptres
