"""Deep samples that are thick: smoke and fog, cut into slices that each have one distance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.fragment_merge import Fragments

_SLICE = 0.15  # of its distance: how thick a slice may be
_SLICES_MOST = 16  # of a sample
_NEAREST = 1 / 16  # of its far end: where the slices of what begins at the lens begin


@dataclass(frozen=True, eq=False)
class DeepSamples:
    """Samples of many pixels, as in `Fragments`; `z` and `back` are metres of both ends."""

    pixel: NDArray[np.int64]
    color: NDArray[np.float32]
    alpha: NDArray[np.float32]
    z: NDArray[np.float32]
    back: NDArray[np.float32]

    def where(self, chosen: NDArray[np.bool_]) -> "DeepSamples":
        """Return some of them."""
        return DeepSamples(
            self.pixel[chosen],
            self.color[chosen],
            self.alpha[chosen],
            self.z[chosen],
            self.back[chosen],
        )


def without_volumes(samples: DeepSamples) -> tuple[Fragments, int]:
    """Return each sample in the middle of its ends, and how many were cut into slices before.

    A volume is taken as equally dense throughout, so what passes through a slice is a power of
    what passes through all of it. Source: "Interpreting OpenEXR Deep Pixels".
    """
    with np.errstate(invalid="ignore"):
        thickness = samples.back - samples.z  # not a number where nothing was hit
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


def _slices(samples: DeepSamples) -> Fragments:
    """Cut each sample where distances grow by the same factor."""
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
