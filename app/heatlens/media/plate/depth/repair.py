"""Repair values that no camera records, so that diffusion never spreads them.

NaN and infinity are replaced by neighboring values. A damaged file, a wrong unit or a program's
marker for "nothing here" gives other values: how near, how blurred and how bright the pixels of a
plate may be is limited, because beyond these limits sums over a picture would overflow. Such values
are clamped when a plate is read, and one note tells the user.
"""

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import COC_MOST_PX
from heatlens.media.plate.plate import FloatImage

# With more bad pixels than this, most of the picture would be invented.
MAX_BAD_FRACTION = 0.5
# Pixels filled at once; this limits the memory for many bad pixels to about 50 MB.
_BATCH_PIXELS = 1 << 17

_Mask = NDArray[np.bool_]
_NEIGHBOUR_STEPS = ((0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))


def check_mostly_good(bad_count: int, size: int, label: str) -> None:
    """Raise InputError if more than half of the pixels are bad; `label` names file and channel."""
    if bad_count > MAX_BAD_FRACTION * size:
        raise InputError(
            f"{label} has no usable value in {bad_count} of {size} pixels (NaN, infinite, of the "
            "wrong sign or nearer than a micrometre): too many to repair. Render the frame again "
            "or choose another channel."
        )


def repair_color(color: FloatImage, label: str) -> int:
    """Replace pixels of `color` (H, W, C) with NaN or infinity in place; return their count.

    Such a pixel takes the median of its good neighbors, in 3x3 or else 5x5 pixels, so that a
    single lamp nearby does not matter. Larger holes are filled from their edge inwards. Negative
    values are valid and stay. Raises InputError if more than half of the pixels are bad.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(color.sum()):  # a bad pixel makes the sum bad: quick for good pictures
            return 0
    bad = ~np.isfinite(color).all(axis=2)
    rows, columns = np.nonzero(bad)
    if rows.size == 0:
        return 0
    check_mostly_good(rows.size, bad.size, label)
    padded = np.pad(color, ((2, 2), (2, 2), (0, 0)), constant_values=np.nan)
    padded[2:-2, 2:-2][bad] = np.nan
    count = int(rows.size)
    while rows.size:  # each round fills the outermost pixels of every hole
        batches = [
            slice(start, start + _BATCH_PIXELS) for start in range(0, rows.size, _BATCH_PIXELS)
        ]
        fill_colors = np.concatenate(
            [_fill_from_neighbours(padded, rows[b], columns[b]) for b in batches]
        )
        color[rows, columns] = padded[rows + 2, columns + 2] = fill_colors
        is_unfilled = np.isnan(fill_colors[:, 0])
        rows, columns = rows[is_unfilled], columns[is_unfilled]
    return count


def _fill_from_neighbours(
    padded: FloatImage, rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> FloatImage:
    """Return new colors (N, C) for the pixels at `rows` and `columns` of the unpadded picture.

    A color is NaN if the pixel has no good neighbor yet.
    """
    colors = _neighbour_median(padded, rows, columns, 1)
    is_isolated = np.isnan(colors[:, 0])
    colors[is_isolated] = _neighbour_median(padded, rows[is_isolated], columns[is_isolated], 2)
    return colors


def _neighbour_median(
    padded: FloatImage, rows: NDArray[np.intp], columns: NDArray[np.intp], radius: int
) -> FloatImage:
    """Return the lower median (N, C) of the good pixels within `radius`; NaN if there are none."""
    offsets = range(2 - radius, 3 + radius)
    stack = np.stack([padded[rows + dy, columns + dx] for dy in offsets for dx in offsets])
    stack.sort(axis=0)  # NaN sorts last
    good_count = np.count_nonzero(~np.isnan(stack[:, :, 0]), axis=0)
    median: FloatImage = stack[np.maximum(good_count - 1, 0) // 2, np.arange(rows.size)]
    return median


def repair_depth(depth: FloatImage, bad: _Mask, label: str) -> int:
    """Replace every `bad` pixel of `depth` (H, W) by its nearest good neighbor, in place.

    Values are copied, never averaged, because a depth between two surfaces belongs to neither.
    Returns the number of bad pixels; raises InputError if they are more than half.
    """
    rows, columns = np.nonzero(bad)
    count = int(rows.size)
    if count == 0:
        return 0
    check_mostly_good(count, bad.size, label)
    good = np.pad(~bad, 1)
    values = np.pad(depth, 1)
    rows, columns = rows + 1, columns + 1
    while rows.size:  # each round fills the outermost pixels of every hole; there are good pixels
        step = _nearest_step(good, rows, columns)
        has_neighbour = step >= 0
        steps = np.array(_NEIGHBOUR_STEPS)[step[has_neighbour]]
        filled_pixels = rows[has_neighbour], columns[has_neighbour]
        values[filled_pixels] = values[
            filled_pixels[0] + steps[:, 0], filled_pixels[1] + steps[:, 1]
        ]
        good[filled_pixels] = True
        rows, columns = rows[~has_neighbour], columns[~has_neighbour]
    depth[:] = values[1:-1, 1:-1]
    return count


def _nearest_step(
    good: _Mask, rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return for each pixel the index into _NEIGHBOUR_STEPS of its first good neighbor, or -1."""
    step = np.full(rows.size, -1, dtype=np.intp)
    # The last write wins, so the preferred steps are written last.
    for index, (dy, dx) in reversed(list(enumerate(_NEIGHBOUR_STEPS))):
        step[good[rows + dy, columns + dx]] = index
    return step


# A thousandth of a millimeter in front of the lens. Anything nearer is treated as a missing depth
# and repaired: its blur would overflow on a GPU.
DEPTH_LEAST_M = 1e-6
# The sum over all pixels of the largest plate, and its square, stay below float32's 3.4e38.
LIGHT_MOST = 1e14


def bound_coc(coc_px: FloatImage, label: str) -> tuple[str, ...]:
    """Clamp diameters (H, W) of the circle of confusion in place, and return notes about it.

    The notes are empty if nothing had to be clamped. `label` names the file and the channel.
    """
    count = int(np.count_nonzero(np.abs(coc_px) > COC_MOST_PX))
    np.clip(coc_px, -COC_MOST_PX, COC_MOST_PX, out=coc_px)
    words = f"a circle of confusion of more than {COC_MOST_PX:,.0f} px"
    return _clamp_note(label, words, count, coc_px.size)


def bound_color(color: FloatImage, label: str) -> tuple[str, ...]:
    """Clamp finite colors (H, W, C) in place, and return notes, as `bound_coc` does."""
    if -LIGHT_MOST <= color.min() and color.max() <= LIGHT_MOST:
        return ()
    count = int(np.count_nonzero((np.abs(color) > LIGHT_MOST).any(axis=2)))
    np.clip(color, -LIGHT_MOST, LIGHT_MOST, out=color)
    words = f"light beyond {LIGHT_MOST:g}"
    return _clamp_note(label, words, count, color.shape[0] * color.shape[1])


def _clamp_note(label: str, words: str, count: int, size: int) -> tuple[str, ...]:
    """Return a note that `count` of `size` pixels held `words` and were clamped; () if none did."""
    if not count:
        return ()
    return (f"{label} holds {words} in {count} of {size} pixels: they were set to this limit.",)
