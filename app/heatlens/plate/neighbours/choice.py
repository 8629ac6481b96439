"""Which neighbouring frames are worth reading."""

from collections.abc import Collection

import numpy as np

from heatlens.plate.plate import Plate

_STILL = 0.002  # of the depth or the light: less is the same


def chosen_frames(
    frame: int, available: Collection[int], count: int, step: int = 1
) -> tuple[int, ...]:
    """Return up to `count` frames on either side of `frame`, 2 `count` in all at the ends.

    They are multiples of `step`, so that all frames of a shot share them.
    """
    useful = sorted(other for other in available if other != frame and other % step == 0)
    nearest = sorted(useful, key=lambda other: (abs(other - frame), other))
    return tuple(sorted(nearest[: 2 * count]))


def standing(a: Plate, b: Plate) -> bool:
    """Return True if the camera stood still: most of what is far has not moved."""
    if a.depth_m is None or b.depth_m is None or a.depth_m.shape != b.depth_m.shape:
        return False
    is_same = np.isclose(a.depth_m, b.depth_m, rtol=_STILL, atol=0)
    return bool(is_same.mean() > 0.6)
