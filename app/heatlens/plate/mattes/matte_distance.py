"""Measure the distance of an object by its matte and the depth of the plate."""

import numpy as np

from heatlens.model.marks.marks import MattePart
from heatlens.plate.coc_line import no_distances
from heatlens.plate.mattes.mattes import matte_of
from heatlens.plate.plate import FloatImage, Plate

_LEAST_PX = 4.0  # coverage below which an object counts as hidden
SURE = 0.5  # coverage from which the depth of a pixel is the object's
_NEAREST = 0.98  # share of the coverage behind the nearest part: ignores stray pixels


def thing_m(plate: Plate, text: str, part: MattePart) -> float | None:
    """Return the distance of an object in metres; None where it is hidden or out of the frame.

    Its middle is the median of what is seen of it, in dioptres, and its nearest part is that
    behind which 98 % of it lies; both are weighted by coverage. Raises InputError for a plate
    without distances, and as `matte_of` does.
    """
    if not plate.has_distances:
        raise no_distances(plate)
    depth_m = plate.depth_m
    assert depth_m is not None
    return distance_m(matte_of(plate, text), depth_m, part)


def distance_m(matte: FloatImage, depth_m: FloatImage, part: MattePart) -> float | None:
    """Return what `thing_m` does, from a matte and depths in metres, both (H, W)."""
    is_there = matte > 0
    if float(matte.sum()) < _LEAST_PX:
        return None
    # Pixels at an edge may have the depth of something else.
    if (matte >= SURE).sum() >= _LEAST_PX:
        is_there = matte >= SURE
    dioptres, weights = 1.0 / depth_m[is_there].astype(np.float64), matte[is_there]
    order = np.argsort(dioptres)
    passed = np.cumsum(weights[order], dtype=np.float64)
    share = _NEAREST if part is MattePart.NEAREST else 0.5
    found = float(dioptres[order[np.searchsorted(passed, share * passed[-1])]])
    return 1.0 / found if found > 0 else float("inf")
