"""Histogram of the distances in a picture, over dioptres, as a focus ring is marked."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.model.value_bins import ValueBins

BINS = 160
_NEAR_ROOM = 1.12  # range beyond the nearest dioptres, so that focus can be set in front


@dataclass(frozen=True, eq=False)
class DepthHistogram:
    """`heights` (BINS,) in 0..1 over dioptres 0 (infinity) to `most_dioptres`."""

    heights: NDArray[np.float64]
    most_dioptres: float

    def part_at(self, distance_m: float) -> float:
        """Return the place of a distance on the scale, 0 at infinity to 1 at its near end."""
        return min(1.0 / max(distance_m, 1e-9) / self.most_dioptres, 1.0)


def dioptres_shown(nearest: float) -> float:
    """Return the dioptres at the near end of the scale, for the dioptres of the nearest surface."""
    return nearest * _NEAR_ROOM


def depth_histogram(dioptres: ValueBins, least_most: float = 0.0) -> DepthHistogram:
    """Return the histogram of 1 / metres, in which 0 means that nothing was hit.

    It covers at least `least_most` dioptres, the range of the other frames of a shot, so that the
    scale does not change between frames.

    Heights are square roots, so that small counts are visible. Each fine bin counts in the bin that
    contains its centre.
    """
    most = dioptres_shown(dioptres.high)
    if not 0.0 < most < math.inf:
        most = least_most or 1.0  # any scale will do where nothing was hit
    most = max(most, least_most)
    counts, _ = np.histogram(dioptres.middles, BINS, (0.0, most), weights=dioptres.counts)
    heights = np.sqrt(counts / max(int(counts.max()), 1))
    return DepthHistogram(heights, most)
