"""Cut thick deep samples, which are smoke and fog, into slices that have one distance each."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.deep.fragment_merge import Fragments

_SLICE = 0.15  # greatest thickness of a slice, as a part of its distance
_SLICES_MOST = 16  # slices of a sample
# Start of the first slice if a sample begins at the lens, as a part of its far end.
_NEAREST = 1 / 16


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
