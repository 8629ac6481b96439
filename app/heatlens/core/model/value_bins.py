"""Count the values of a picture in even bins, to summarize and to show its depths."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

BINS = 4096  # number of bins in which values are counted
BARS = 160  # number of bars of a histogram
_NEAR_MARGIN = 1.12  # range beyond the nearest dioptres, so that focus can be set in front
_STEP_MIN = 1e-30  # a smaller one has no reciprocal in float32


@dataclass(frozen=True, eq=False)
class ValueBins:
    """How often values occur in even bins.

    low, high  the least and the greatest value; if they are almost equal, all are in the first bin
    counts     (BINS,) number of values in each bin, from low to high
    """

    low: float
    high: float
    counts: NDArray[np.int64]

    @cached_property
    def occupied(self) -> NDArray[np.float64]:
        """The ends of the bins that hold any value, ascending, (2 n,)."""
        step = bin_step(self.low, self.high)
        if not step:
            return np.array([self.low, self.high])
        occupied = np.flatnonzero(self.counts)
        ends = np.stack([self.low + occupied * step, self.low + (occupied + 1) * step], axis=-1)
        return np.asarray(np.clip(ends.ravel(), self.low, self.high), np.float64)

    @property
    def occupied_shares(self) -> NDArray[np.float64]:
        """The share of all values up to each of the `occupied` ends, 0..1, ascending, (2 n,)."""
        if not bin_step(self.low, self.high):
            return np.array([0.0, 1.0])
        counts = self.counts[self.counts > 0]
        until = np.cumsum(counts)
        shares = np.stack([until - counts, until], axis=-1) / until[-1]
        return np.asarray(shares.ravel(), np.float64)

    @property
    def middles(self) -> NDArray[np.float64]:
        """(BINS,) the values in the middle of each bin."""
        step = bin_step(self.low, self.high)
        return np.asarray(self.low + (np.arange(BINS) + 0.5) * step, np.float64)


def bin_step(low: float, high: float) -> float:
    """Return the width of a bin; 0 if the values are almost equal."""
    step = (high - low) / BINS
    return step if step >= _STEP_MIN else 0.0


def bin_values(values: NDArray[np.float32]) -> ValueBins:
    """Return the bins of finite values, at least one, in an array of any shape.

    Bins take a few milliseconds for a whole plate, once, where sorting takes seconds.
    """
    low, high = float(values.min()), float(values.max())
    step = bin_step(low, high)
    if not step:
        return fill_single_bin(low, high, values.size)
    bins = ((values.ravel() - np.float32(low)) * np.float32(1 / step)).astype(np.int32)
    counts = np.bincount(np.clip(bins, 0, BINS - 1), minlength=BINS)
    return ValueBins(low, high, counts)


def fill_single_bin(low: float, high: float, count: int) -> ValueBins:
    """Return the bins of `count` values that are almost equal."""
    counts = np.zeros(BINS, np.int64)
    counts[0] = count
    return ValueBins(low, high, counts)


@dataclass(frozen=True, eq=False)
class DepthHistogram:
    """The bars of a histogram of depths.

    heights        (BARS,), 0 to 1, over dioptres from 0 (infinity) to `most_dioptres`
    most_dioptres  dioptres at the near end of the scale
    """

    heights: NDArray[np.float64]
    most_dioptres: float

    def scale_position(self, distance_m: float) -> float:
        """Return the position of a distance on the scale, 0 at infinity to 1 at its near end."""
        return min(1.0 / max(distance_m, 1e-9) / self.most_dioptres, 1.0)


def scale_end_dioptres(nearest_dioptres: float) -> float:
    """Return the dioptres at the near end of the scale, for the dioptres of the nearest surface."""
    return nearest_dioptres * _NEAR_MARGIN


def depth_histogram(dioptres: ValueBins, scale_least: float = 0.0) -> DepthHistogram:
    """Return the histogram of 1 / meters, in which 0 means that nothing was hit.

    It covers at least `scale_least` dioptres, the range of the other frames of a shot, so that the
    scale does not change between frames.

    Heights are square roots, so that small counts are visible. Each fine bin counts in the bin that
    contains its center.
    """
    scale_end = scale_end_dioptres(dioptres.high)
    if not 0.0 < scale_end < math.inf:
        scale_end = scale_least or 1.0  # any scale will do where nothing was hit
    scale_end = max(scale_end, scale_least)
    counts, _ = np.histogram(dioptres.middles, BARS, (0.0, scale_end), weights=dioptres.counts)
    heights = np.sqrt(counts / max(int(counts.max()), 1))
    return DepthHistogram(heights, scale_end)
