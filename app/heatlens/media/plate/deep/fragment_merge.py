"""Sort the fragments of pixels, and merge those that no lens can distinguish.

Thick deep samples, which are smoke and fog, are cut into slices that have one distance each.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.media.plate.fragments import OPAQUE

FRAGMENTS_MOST = 16  # in a pixel; if there are more, those of the most similar blur are merged
_CUTS = (256, 128, 64, 32, FRAGMENTS_MOST)  # bins of dioptres tried for a pixel with too many
_SLICE = 0.15  # greatest thickness of a slice, as a part of its distance
_SLICES_MOST = 16  # slices of a sample
# Start of the first slice if a sample begins at the lens, as a part of its far end.
_NEAREST = 1 / 16


@dataclass(frozen=True, eq=False)
class Fragments:
    """Fragments of many pixels.

    pixel    (N,) number of the pixel that each belongs to
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
        return Fragments(
            self.pixel[chosen], self.color[chosen], self.alpha[chosen], self.depth_m[chosen]
        )


def joined(parts: list[Fragments]) -> Fragments:
    """Concatenate several sets of fragments."""
    if len(parts) == 1:
        return parts[0]
    return Fragments(
        np.concatenate([part.pixel for part in parts]),
        np.concatenate([part.color for part in parts]),
        np.concatenate([part.alpha for part in parts]),
        np.concatenate([part.depth_m for part in parts]),
    )


# Samples at the same distance would otherwise lie in the order of the files, and the same surfaces
# given in another order would make another picture.
def in_order(fragments: Fragments) -> Fragments:
    """Return the fragments sorted by pixel, and within a pixel from near to far.

    Fragments at the same distance are sorted by coverage and colour, so that the result does not
    depend on the order of the input.
    """
    # Floats that are not negative sort in the same order as their bits.
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


# Each fragment is compared with the one before it, so that one pass finds the runs. But smoke in
# fine slices is one run from end to end, in which each is close to the next: such a run is cut
# again, by the distance from where it begins.
def merged(fragments: Fragments, tolerance: float) -> Fragments:
    """Merge the fragments of a pixel that are closer than `tolerance`, relative to their distance.

    `fragments` are sorted as by `in_order`.
    """
    pixel, depth = fragments.pixel, fragments.depth_m
    is_close = (pixel[1:] == pixel[:-1]) & (depth[1:] <= depth[:-1] * np.float32(1 + tolerance))
    if not is_close.any():
        return fragments
    begins = np.append(True, ~is_close)
    # A long run of close fragments is cut into pieces of the tolerance, beginning at the nearest.
    with np.errstate(invalid="ignore"):  # infinity over infinity
        ratio = depth / depth[begins][np.cumsum(begins) - 1]
    is_far = ratio > 1 + tolerance
    if is_far.any():
        piece = np.zeros(len(ratio), np.int64)
        piece[is_far] = np.log(ratio[is_far]) / np.log1p(tolerance)
        begins[1:] |= piece[1:] != piece[:-1]
    return _one_of_each(fragments, begins)


# What may be merged is what no lens blurs differently. A circle of confusion is linear in dioptres
# with every focus and f-stop, so bins of equal dioptres lose equally little, whereas bins of equal
# metres would spend themselves on the distance.
def shortened(fragments: Fragments, counts: NDArray[np.int64]) -> Fragments:
    """Merge fragments of similar blur until no pixel has more than FRAGMENTS_MOST.

    A circle of confusion is linear in dioptres, whatever the lens. The range of dioptres of a pixel
    is therefore cut into equal bins, as many as leave few enough fragments. `fragments` are sorted
    as by `in_order`; `counts` holds the number of fragments of each pixel.
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
    """Composite each group of neighbours into one fragment; `begins` marks the first of a group.

    The dioptres of the result are the mean of those of the group, weighted by visible coverage.
    """
    first = np.flatnonzero(begins)
    size = np.diff(np.append(first, len(begins)))
    whole = fragments.where(first)
    color, alpha, depth = whole.color, whole.alpha, whole.depth_m
    left, weighted = 1 - alpha, alpha * _dioptres(depth)
    is_spread = np.zeros(len(first), bool)
    group = np.flatnonzero(size > 1)
    for step in range(1, int(size.max())):
        group = group[size[group] > step]
        at = first[group] + step
        weight = left[group] * fragments.alpha[at]
        color[group] += left[group, None] * fragments.color[at]
        alpha[group] += weight
        weighted[group] += weight * _dioptres(fragments.depth_m[at])
        is_spread[group] |= (weight > 0) & (fragments.depth_m[at] != depth[group])
        left[group] *= 1 - fragments.alpha[at]
    with np.errstate(divide="ignore"):  # nothing was hit
        depth[is_spread] = (alpha / weighted)[is_spread]
    alpha[(size > 1) & (alpha >= OPAQUE)] = 1.0
    return whole


def _dioptres(depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    dioptres: NDArray[np.float32] = np.float32(1.0) / depth_m
    return dioptres


@dataclass(frozen=True, eq=False)
class DeepSamples:
    """Samples of many pixels, as in `Fragments`; `z` and `back` are the near and far end in m."""

    pixel: NDArray[np.int64]
    color: NDArray[np.float32]
    alpha: NDArray[np.float32]
    z: NDArray[np.float32]
    back: NDArray[np.float32]

    def where(self, chosen: NDArray[np.bool_]) -> "DeepSamples":
        return DeepSamples(
            self.pixel[chosen],
            self.color[chosen],
            self.alpha[chosen],
            self.z[chosen],
            self.back[chosen],
        )


def without_volumes(samples: DeepSamples) -> tuple[Fragments, int]:
    """Return fragments at the middle of each sample, and how many samples were cut into slices.

    A volume is taken as equally dense throughout, so the transmission of a slice is a power of the
    transmission of the whole. Source: "Interpreting OpenEXR Deep Pixels".
    """
    with np.errstate(invalid="ignore"):
        thickness = samples.back - samples.z  # NaN where nothing was hit
        is_thick = thickness > _SLICE * np.maximum(samples.z, 0)
        middle = np.where(thickness > 0, samples.z + thickness / 2, samples.z)
    if not is_thick.any():
        return Fragments(samples.pixel, samples.color, samples.alpha, middle), 0
    thin = ~is_thick
    slices = _slices(samples.where(is_thick))
    return Fragments(
        np.concatenate([samples.pixel[thin], slices.pixel]),
        np.concatenate([samples.color[thin], slices.color]),
        np.concatenate([samples.alpha[thin], slices.alpha]),
        np.concatenate([middle[thin], slices.depth_m]),
    ), int(is_thick.sum())


# No lens can tell apart what is closer together than a share of its distance, so slices grow with
# the distance by a constant factor. The same number of equal slices would be too coarse in front,
# where blur changes fastest. The first slice starts at the sample itself, even before `begin`.
def _slices(samples: DeepSamples) -> Fragments:
    """Cut each sample into slices whose distances grow by a constant factor."""
    begin = np.maximum(samples.z, _NEAREST * samples.back)
    ratio = samples.back / begin
    counts = np.ceil(np.log(ratio) / np.log1p(_SLICE)).clip(1, _SLICES_MOST).astype(np.int64)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    each = np.repeat(np.arange(len(counts)), counts)
    near = begin[each] * ratio[each] ** (step / counts[each])
    far = begin[each] * ratio[each] ** ((step + 1) / counts[each])
    near = np.where(step == 0, samples.z[each], near)
    part = (far - near) / (samples.back - samples.z)[each]
    whole = samples.alpha[each].astype(np.float64)
    alpha = -np.expm1(part * np.log1p(-np.minimum(whole, 1 - 1e-7)))
    return Fragments(
        samples.pixel[each],
        (samples.color[each] * (alpha / whole)[:, None]).astype(np.float32),
        alpha.astype(np.float32),
        ((np.maximum(near, 0) + far) / 2).astype(np.float32),
    )
