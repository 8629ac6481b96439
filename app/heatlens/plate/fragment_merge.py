"""Fragments of pixels: put in order, and merged where no lens can tell them apart."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.fragments import OPAQUE

FRAGMENTS_MOST = 16  # of a pixel; more are merged by likeness of their blur
_CUTS = (256, 128, 64, 32, FRAGMENTS_MOST)  # of the dioptres of a pixel with too many


@dataclass(frozen=True, eq=False)
class Fragments:
    """Fragments of many pixels.

    pixel    (N,) its number
    color    (N, 3) float32, premultiplied
    alpha    (N,) float32, the part of the pixel that it covers, 0..1
    depth_m  (N,) float32, planar metres; +inf where nothing was hit
    """

    pixel: NDArray[np.int64]
    color: NDArray[np.float32]
    alpha: NDArray[np.float32]
    depth_m: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.pixel)

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> "Fragments":
        """Return some of them."""
        return Fragments(
            self.pixel[chosen], self.color[chosen], self.alpha[chosen], self.depth_m[chosen]
        )


def joined(parts: list[Fragments]) -> Fragments:
    """Return the fragments of several together."""
    if len(parts) == 1:
        return parts[0]
    return Fragments(
        np.concatenate([part.pixel for part in parts]),
        np.concatenate([part.color for part in parts]),
        np.concatenate([part.alpha for part in parts]),
        np.concatenate([part.depth_m for part in parts]),
    )


def in_order(fragments: Fragments) -> Fragments:
    """Return the fragments sorted by pixel, and near to far.

    What lies at one distance is sorted by its coverage and colour, so that the order in which
    fragments came does not matter.
    """
    # The bits of a float that is not negative are in the order of its value.
    key = (fragments.pixel.astype(np.uint64) << np.uint64(32)) | fragments.depth_m.view(np.uint32)
    if (key[1:] > key[:-1]).all():
        return fragments
    order = np.argsort(key, kind="stable")
    key = key[order]
    is_twin = key[1:] == key[:-1]
    if is_twin.any():
        at = np.flatnonzero(np.append(is_twin, False) | np.append(False, is_twin))
        twins = fragments.where(order[at])
        by_value = np.lexsort((*twins.color.T, twins.alpha, key[at]))
        order[at] = order[at][by_value]
    return fragments.where(order)


def merged(fragments: Fragments, tolerance: float) -> Fragments:
    """Return one fragment for those of a pixel that are within `tolerance` of their distance.

    `fragments` are in order.
    """
    pixel, depth = fragments.pixel, fragments.depth_m
    is_close = (pixel[1:] == pixel[:-1]) & (depth[1:] <= depth[:-1] * np.float32(1 + tolerance))
    if not is_close.any():
        return fragments
    begins = np.append(True, ~is_close)
    # A long row of close ones is cut into pieces of the tolerance, from its nearest one on.
    with np.errstate(invalid="ignore"):  # infinity over infinity
        ratio = depth / depth[begins][np.cumsum(begins) - 1]
    is_far = ratio > 1 + tolerance
    if is_far.any():
        piece = np.zeros(len(ratio), np.int64)
        piece[is_far] = np.log(ratio[is_far]) / np.log1p(tolerance)
        begins[1:] |= piece[1:] != piece[:-1]
    return _one_of_each(fragments, begins)


def shortened(fragments: Fragments, counts: NDArray[np.int64]) -> Fragments:
    """Return at most FRAGMENTS_MOST fragments for each pixel, merged by likeness of their blur.

    A circle of confusion is a straight line over dioptres, whatever the lens: the dioptres of a
    pixel are cut evenly, as finely as leaves few enough. `fragments` are in order; `counts` has how
    many each pixel has.
    """
    is_long = (counts > FRAGMENTS_MOST)[fragments.pixel]
    if not is_long.any():
        return fragments
    begins = np.append(True, fragments.pixel[1:] != fragments.pixel[:-1])
    first = np.flatnonzero(begins)
    pixel_index = np.cumsum(begins) - 1
    dioptres = _dioptres(fragments.depth_m)
    last = np.append(first[1:], len(begins)) - 1
    span = (dioptres[first] - dioptres[last])[pixel_index]
    part = (dioptres[first][pixel_index] - dioptres) / np.where(span > 0, span, 1.0)
    is_cut = ~is_long
    for cuts in _CUTS:
        bins = np.minimum((part * cuts).astype(np.int64), cuts - 1)
        starts = np.append(True, bins[1:] != bins[:-1]) | begins
        is_few = np.bincount(pixel_index, starts) <= FRAGMENTS_MOST
        settles = is_few[pixel_index] & ~is_cut
        begins |= starts & settles
        is_cut |= settles
    begins |= ~is_long
    return _one_of_each(fragments, begins)


def _one_of_each(fragments: Fragments, begins: NDArray[np.bool_]) -> Fragments:
    """Composite each group of neighbours to one fragment; `begins` is where a group begins.

    Its distance is the mean of the dioptres by what is seen of each.
    """
    first = np.flatnonzero(begins)
    size = np.diff(np.append(first, len(begins)))
    whole = fragments.where(first)
    color, alpha, depth = whole.color, whole.alpha, whole.depth_m
    seen, weighted = 1 - alpha, alpha * _dioptres(depth)
    is_spread = np.zeros(len(first), bool)
    group = np.flatnonzero(size > 1)
    for step in range(1, int(size.max())):
        group = group[size[group] > step]
        at = first[group] + step
        weight = seen[group] * fragments.alpha[at]
        color[group] += seen[group, None] * fragments.color[at]
        alpha[group] += weight
        weighted[group] += weight * _dioptres(fragments.depth_m[at])
        is_spread[group] |= (weight > 0) & (fragments.depth_m[at] != depth[group])
        seen[group] *= 1 - fragments.alpha[at]
    with np.errstate(divide="ignore"):  # nothing was hit
        depth[is_spread] = (alpha / weighted)[is_spread]
    alpha[(size > 1) & (alpha >= OPAQUE)] = 1.0
    return whole


def _dioptres(depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    dioptres: NDArray[np.float32] = np.float32(1.0) / depth_m
    return dioptres
