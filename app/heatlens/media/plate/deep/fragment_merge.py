"""Sort the fragments of pixels, and merge those that no lens can distinguish.

Thick deep samples, which are smoke and fog, are cut into slices that have one distance each.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.media.plate.fragments import OPAQUE

FRAGMENTS_MOST = 16  # in a pixel; if there are more, those of the most similar blur are merged
_BIN_COUNTS = (256, 128, 64, 32, FRAGMENTS_MOST)  # bins of dioptres tried for a pixel with too many
_SLICE = 0.15  # greatest thickness of a slice, as a part of its distance
_SLICES_MOST = 16  # slices of a sample
# Start of the first slice of a sample that begins at the lens, as a share of its far end.
_NEAREST = 1 / 16


@dataclass(frozen=True, eq=False)
class Fragments:
    """Fragments of many pixels.

    pixel    (N,) number of the pixel that each belongs to
    color    (N, 3) float32, premultiplied
    alpha    (N,) float32, the part of the pixel that it covers, 0..1
    depth_m  (N,) float32, planar meters; +inf where nothing was hit
    """

    pixel: NDArray[np.int64]
    color: NDArray[np.float32]
    alpha: NDArray[np.float32]
    depth_m: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.pixel)

    def select(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> "Fragments":
        """Return the fragments that a mask or indices choose."""
        return Fragments(
            self.pixel[chosen], self.color[chosen], self.alpha[chosen], self.depth_m[chosen]
        )


def concatenate_fragments(parts: list[Fragments]) -> Fragments:
    """Return several sets of fragments as one."""
    if len(parts) == 1:
        return parts[0]
    return Fragments(
        pixel=np.concatenate([part.pixel for part in parts]),
        color=np.concatenate([part.color for part in parts]),
        alpha=np.concatenate([part.alpha for part in parts]),
        depth_m=np.concatenate([part.depth_m for part in parts]),
    )


def sort_fragments(fragments: Fragments) -> Fragments:
    """Return the fragments sorted by pixel, and within a pixel from near to far.

    Fragments at the same distance are sorted by coverage and color. The result then does not
    depend on the order of the input files.
    """
    # Floats that are not negative sort in the same order as their bits.
    key = (fragments.pixel.astype(np.uint64) << np.uint64(32)) | fragments.depth_m.view(np.uint32)
    if (key[1:] > key[:-1]).all():
        return fragments
    order = np.argsort(key, kind="stable")
    key = key[order]
    is_twin = key[1:] == key[:-1]
    if is_twin.any():
        twin_positions = np.flatnonzero(np.append(is_twin, False) | np.append(False, is_twin))
        twins = fragments.select(order[twin_positions])
        by_value = np.lexsort((*twins.color.T, twins.alpha, key[twin_positions]))
        order[twin_positions] = order[twin_positions][by_value]
    return fragments.select(order)


# Each fragment is compared with the one before it, which finds the runs in one pass. Smoke in fine
# slices is one long run, because each slice is close to the next: such a run is cut again, by the
# distance from its first fragment.
def merge_close_fragments(fragments: Fragments, tolerance: float) -> Fragments:
    """Merge the fragments of a pixel that are closer than `tolerance`, relative to their distance.

    `fragments` are sorted as by `sort_fragments`.
    """
    pixel, depth = fragments.pixel, fragments.depth_m
    is_close = (pixel[1:] == pixel[:-1]) & (depth[1:] <= depth[:-1] * np.float32(1 + tolerance))
    if not is_close.any():
        return fragments
    is_first = np.append(True, ~is_close)
    # A long run of close fragments is cut into pieces of the tolerance, beginning at the nearest.
    with np.errstate(invalid="ignore"):  # infinity over infinity
        ratio = depth / depth[is_first][np.cumsum(is_first) - 1]
    is_far = ratio > 1 + tolerance
    if is_far.any():
        piece = np.zeros(len(ratio), np.int64)
        piece[is_far] = np.log(ratio[is_far]) / np.log1p(tolerance)
        is_first[1:] |= piece[1:] != piece[:-1]
    return _composite_groups(fragments, is_first)


# Fragments are merged that every lens blurs almost alike. A circle of confusion is linear in
# dioptres with every focus and f-stop, so bins of equal dioptres lose equally little. Most bins of
# equal meters would lie far away, where the blur hardly changes.
def limit_fragments(fragments: Fragments, counts: NDArray[np.int64]) -> Fragments:
    """Merge fragments of similar blur until no pixel has more than FRAGMENTS_MOST.

    The range of dioptres of a pixel is cut into equal bins, as many as leave few enough fragments.
    `fragments` are sorted as by `sort_fragments`; `counts` holds the number of fragments of each
    pixel.
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
    position = (dioptres[first][pixel_index] - dioptres) / np.where(span > 0, span, 1.0)
    is_settled = ~is_long
    for bin_count in _BIN_COUNTS:
        bins = np.minimum((position * bin_count).astype(np.int64), bin_count - 1)
        starts = np.append(True, bins[1:] != bins[:-1]) | begins
        is_within_limit = np.bincount(pixel_index, starts) <= FRAGMENTS_MOST
        settles = is_within_limit[pixel_index] & ~is_settled
        begins |= starts & settles
        is_settled |= settles
    begins |= ~is_long
    return _composite_groups(fragments, begins)


def _composite_groups(fragments: Fragments, begins: NDArray[np.bool_]) -> Fragments:
    """Composite each group of neighbors into one fragment; `begins` marks the first of a group.

    The dioptres of the result are the mean of those of the group, weighted by visible coverage.
    """
    first = np.flatnonzero(begins)
    size = np.diff(np.append(first, len(begins)))
    composites = fragments.select(first)
    color, alpha, depth = composites.color, composites.alpha, composites.depth_m
    transmission, weighted_dioptres = 1 - alpha, alpha * _dioptres(depth)
    is_spread = np.zeros(len(first), bool)
    group = np.flatnonzero(size > 1)
    # Composite from near to far: in each step, the next fragment of every group that has one.
    for step in range(1, int(size.max())):
        group = group[size[group] > step]
        next_fragment = first[group] + step
        weight = transmission[group] * fragments.alpha[next_fragment]
        color[group] += transmission[group, None] * fragments.color[next_fragment]
        alpha[group] += weight
        weighted_dioptres[group] += weight * _dioptres(fragments.depth_m[next_fragment])
        is_spread[group] |= (weight > 0) & (fragments.depth_m[next_fragment] != depth[group])
        transmission[group] *= 1 - fragments.alpha[next_fragment]
    with np.errstate(divide="ignore"):  # nothing was hit
        depth[is_spread] = (alpha / weighted_dioptres)[is_spread]
    alpha[(size > 1) & (alpha >= OPAQUE)] = 1.0
    return composites


def _dioptres(depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the depths as dioptres, in 32 bits."""
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

    def select(self, chosen: NDArray[np.bool_]) -> "DeepSamples":
        """Return the samples that a mask chooses."""
        return DeepSamples(
            pixel=self.pixel[chosen],
            color=self.color[chosen],
            alpha=self.alpha[chosen],
            z=self.z[chosen],
            back=self.back[chosen],
        )


def slice_volumes(samples: DeepSamples) -> tuple[Fragments, int]:
    """Return a fragment for each thin sample, slices for thick ones, and the number of thick ones.

    A fragment lies at the middle of its sample or slice. A volume is taken as equally dense
    throughout, so the transmission of a slice is a power of the transmission of the whole. Source:
    "Interpreting OpenEXR Deep Pixels".
    """
    with np.errstate(invalid="ignore"):
        thickness = samples.back - samples.z  # NaN where nothing was hit
        is_thick = thickness > _SLICE * np.maximum(samples.z, 0)
        middle = np.where(thickness > 0, samples.z + thickness / 2, samples.z)
    if not is_thick.any():
        return Fragments(samples.pixel, samples.color, samples.alpha, middle), 0
    is_thin = ~is_thick
    slices = _cut_slices(samples.select(is_thick))
    return Fragments(
        pixel=np.concatenate([samples.pixel[is_thin], slices.pixel]),
        color=np.concatenate([samples.color[is_thin], slices.color]),
        alpha=np.concatenate([samples.alpha[is_thin], slices.alpha]),
        depth_m=np.concatenate([middle[is_thin], slices.depth_m]),
    ), int(is_thick.sum())


# Slices grow with the distance by a constant factor, because no lens distinguishes depths that are
# closer together than a share of their distance. The same number of equal slices would be too
# coarse in front, where the blur changes fastest. The first slice starts at the near end of the
# sample, even where that is nearer than `begin`.
def _cut_slices(samples: DeepSamples) -> Fragments:
    """Cut each sample into slices whose distances grow by a constant factor."""
    begin = np.maximum(samples.z, _NEAREST * samples.back)
    ratio = samples.back / begin
    counts = np.ceil(np.log(ratio) / np.log1p(_SLICE)).clip(1, _SLICES_MOST).astype(np.int64)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    sample_index = np.repeat(np.arange(len(counts)), counts)
    near = begin[sample_index] * ratio[sample_index] ** (step / counts[sample_index])
    far = begin[sample_index] * ratio[sample_index] ** ((step + 1) / counts[sample_index])
    near = np.where(step == 0, samples.z[sample_index], near)
    share = (far - near) / (samples.back - samples.z)[sample_index]
    whole_alpha = samples.alpha[sample_index].astype(np.float64)
    alpha = -np.expm1(share * np.log1p(-np.minimum(whole_alpha, 1 - 1e-7)))
    return Fragments(
        pixel=samples.pixel[sample_index],
        color=(samples.color[sample_index] * (alpha / whole_alpha)[:, None]).astype(np.float32),
        alpha=alpha.astype(np.float32),
        depth_m=((np.maximum(near, 0) + far) / 2).astype(np.float32),
    )
