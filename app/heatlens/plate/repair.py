"""Pixels that hold no number: filled from neighbours, so that diffusion never spreads them."""

import numpy as np
from numpy.typing import NDArray

from heatlens.errors import InputError
from heatlens.plate.plate import FloatImage

# More than this and the fill would be invention, not repair.
MAX_BAD_FRACTION = 0.5
# Pixels gathered at once: bounds the memory of a picture with many bad ones to about 50 MB.
_BATCH = 1 << 17

_Mask = NDArray[np.bool_]
_STEPS = ((0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))


def check_mostly_good(bad_count: int, size: int, what: str) -> None:
    """Raise InputError when more than half of the pixels are bad; `what` names file and channel."""
    if bad_count > MAX_BAD_FRACTION * size:
        raise InputError(
            f"{what} has no usable value in {bad_count} of {size} pixels (NaN, infinite, of the "
            "wrong sign or nearer than a micrometre): too many to mend. Render the frame again or "
            "choose another channel."
        )


def repair_color(color: FloatImage, what: str) -> int:
    """Replace, in place, the pixels of `color` (H, W, C) that hold NaN or infinity; their count.

    Each takes the median of its good neighbours, 3x3 then 5x5, so that one lamp beside it does not
    decide; inside a larger hole, of those filled before it. Negative values are light like any
    other and stay. Raises InputError when more than half are bad.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(color.sum()):  # NaN and infinity survive a sum: one pass for good pictures
            return 0
    bad = ~np.isfinite(color).all(axis=2)
    rows, columns = np.nonzero(bad)
    if rows.size == 0:
        return 0
    check_mostly_good(rows.size, bad.size, what)
    padded = np.pad(color, ((2, 2), (2, 2), (0, 0)), constant_values=np.nan)
    padded[2:-2, 2:-2][bad] = np.nan
    count = int(rows.size)
    while rows.size:  # a hole closes from its rim inwards
        batches = [slice(start, start + _BATCH) for start in range(0, rows.size, _BATCH)]
        filled = np.concatenate([_filled(padded, rows[b], columns[b]) for b in batches])
        color[rows, columns] = padded[rows + 2, columns + 2] = filled
        left = np.isnan(filled[:, 0])
        rows, columns = rows[left], columns[left]
    return count


def _filled(padded: FloatImage, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> FloatImage:
    """Return new colours (N, C) for the pixels at `rows`, `columns` of the picture in `padded`.

    A colour is NaN where no neighbour is good yet.
    """
    colors = _neighbour_median(padded, rows, columns, 1)
    lonely = np.isnan(colors[:, 0])
    colors[lonely] = _neighbour_median(padded, rows[lonely], columns[lonely], 2)
    return colors


def _neighbour_median(
    padded: FloatImage, rows: NDArray[np.intp], columns: NDArray[np.intp], radius: int
) -> FloatImage:
    """Lower median (N, C) of the good pixels within `radius`; NaN where there are none."""
    reach = range(2 - radius, 3 + radius)
    stack = np.stack([padded[rows + dy, columns + dx] for dy in reach for dx in reach])
    stack.sort(axis=0)  # NaN sorts last
    good = np.count_nonzero(~np.isnan(stack[:, :, 0]), axis=0)
    middle: FloatImage = stack[np.maximum(good - 1, 0) // 2, np.arange(rows.size)]
    return middle


def repair_depth(depth: FloatImage, bad: _Mask, what: str) -> int:
    """Give, in place, every `bad` pixel of `depth` (H, W) its nearest good neighbour's value.

    A value is copied, never averaged: a depth between two surfaces belongs to neither.
    Returns the count; raises InputError when more than half are bad.
    """
    rows, columns = np.nonzero(bad)
    count = int(rows.size)
    if count == 0:
        return 0
    check_mostly_good(count, bad.size, what)
    good = np.pad(~bad, 1)
    values = np.pad(depth, 1)
    rows, columns = rows + 1, columns + 1
    while rows.size:  # one ring of each hole a round; over half are good, so each round gains
        found = _nearest_step(good, rows, columns)
        has = found >= 0
        steps = np.array(_STEPS)[found[has]]
        here = rows[has], columns[has]
        values[here] = values[here[0] + steps[:, 0], here[1] + steps[:, 1]]
        good[here] = True
        rows, columns = rows[~has], columns[~has]
    depth[:] = values[1:-1, 1:-1]
    return count


def _nearest_step(
    good: _Mask, rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return the index into _STEPS of the first good neighbour of each pixel; -1 for none."""
    found = np.full(rows.size, -1, dtype=np.intp)
    for index, (dy, dx) in reversed(list(enumerate(_STEPS))):
        found[good[rows + dy, columns + dx]] = index
    return found
