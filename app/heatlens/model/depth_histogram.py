"""How much of a picture lies at which distance, over dioptres as a focus ring is marked."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BINS = 160
_SAMPLES = 1 << 18  # pixels looked at: enough for its shape, and a sequence can be played
_NEAR_ROOM = 1.12  # dioptres beyond the nearest surface, so that focus can be set in front of it


@dataclass(frozen=True, eq=False)
class DepthHistogram:
    """`heights` (BINS,) in 0..1 over dioptres 0 (infinity) to `most_dioptres`."""

    heights: NDArray[np.float64]
    most_dioptres: float

    def part_at(self, distance_m: float) -> float:
        """Where a distance lies on the scale: 0 at infinity, 1 at its near end and before."""
        return min(1.0 / max(distance_m, 1e-9) / self.most_dioptres, 1.0)


def depth_histogram(depth_m: NDArray[np.float32]) -> DepthHistogram:
    """Of metres, +inf where nothing was hit; heights by square root, that few pixels are seen."""
    most = float(np.float32(1.0) / depth_m.min()) * _NEAR_ROOM
    step = math.ceil(math.sqrt(depth_m.size / _SAMPLES))
    sampled = depth_m[::step, ::step] if depth_m.ndim == 2 else depth_m
    dioptres = np.float32(1.0) / sampled.ravel()
    if not 0.0 < most < math.inf:
        most = 1.0  # nothing was hit: any scale serves
    counts, _ = np.histogram(dioptres, BINS, (0.0, most))
    heights = np.sqrt(counts / max(int(counts.max()), 1))
    return DepthHistogram(heights, most)
