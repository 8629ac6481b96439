"""Turn the values of a network into dioptres, by the ends of the depth or a known distance."""

from dataclasses import dataclass

import numpy as np

from heatlens.base.errors import InputError
from heatlens.model.depth_words import DepthModelOutput, KnownDistance
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.plate.bounds import DEPTH_LEAST_M
from heatlens.plate.plate import FloatImage

DIOPTRES_LEAST = 1e-4  # ten kilometres; networks know no infinity
_ENDS = 0.002, 0.998  # parts of the values of the first frame between which its range lies


@dataclass(frozen=True)
class Scale:
    """Values become `zero` plus `one` for each unit: dioptres, or metres if `is_distance`."""

    zero: float
    one: float
    is_distance: bool = False

    def dioptres(self, values: FloatImage) -> FloatImage:
        """Return values as dioptres."""
        found = self.zero + values * np.float32(self.one)
        if self.is_distance:
            found = 1.0 / np.maximum(found, np.float32(DEPTH_LEAST_M))
        bounded: FloatImage = np.maximum(found, np.float32(DIOPTRES_LEAST))
        return bounded


def scale_of(
    first: FloatImage, output: DepthModelOutput, options: PlateOptions, shape: tuple[int, ...]
) -> Scale:
    """Return the scale for the values (h, w) of the first frame, whose picture has this shape.

    A disparity needs near and far in `options`. Raises InputError for a known distance outside the
    picture.
    """
    known = options.depth_known
    value = None if known is None else _value_at(first, known, shape)
    if output is DepthModelOutput.DISPARITY:
        return _of_disparity(first, options, value)
    is_distance = output is DepthModelOutput.METRES
    if known is None or not value or value < 0:
        return Scale(0.0, 1.0, is_distance)
    true = known.distance_m if is_distance else 1.0 / known.distance_m
    return Scale(0.0, true / value, is_distance)


def _value_at(first: FloatImage, known: KnownDistance, shape: tuple[int, ...]) -> float:
    """Return the value of the network at the pixel whose distance is known."""
    row, column = (int(at // 1) for at in (known.y_px, known.x_px))
    height, width = shape[:2]
    if not (0 <= row < height and 0 <= column < width):
        raise InputError(f"--depth-known {known}: the pixel is outside the picture.")
    return float(first[row * first.shape[0] // height, column * first.shape[1] // width])


def _of_disparity(first: FloatImage, options: PlateOptions, value: float | None) -> Scale:
    """Return the scale of values that are even over 1/distance, of any scale and shift."""
    assert options.near_m is not None and options.far_m is not None
    low, high = (float(it) for it in np.quantile(first, _ENDS))
    far, near = 1.0 / options.far_m, 1.0 / options.near_m
    one = (near - far) / max(high - low, 1e-12)
    if options.depth_known is not None and value is not None and value > low:
        one = max(1.0 / options.depth_known.distance_m - far, 0.0) / (value - low)
    return Scale(far - one * low, one)
