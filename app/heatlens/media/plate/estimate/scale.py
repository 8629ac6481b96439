"""Turn the values of a network into dioptres, by the ends of the depth or a known distance.

Networks drift: scale and shift of a relative depth differ between frames. The estimate of a frame
is fitted to that of an earlier one, over what did not move.
"""

from dataclasses import dataclass

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthModelOutput, KnownDistance
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M
from heatlens.media.plate.plate import FloatImage

DIOPTRES_LEAST = 1e-4  # ten kilometres; networks know no infinity
_ENDS = 0.002, 0.998  # parts of the values of the first frame between which its range lies
_SAME_COLOR = 0.03  # change of display values below which nothing has moved
_STILL_LEAST = 0.05  # least share of the picture that must stand still for a fit
_ROUNDS = 4
_SAMPLES = 160  # samples along each side


@dataclass(frozen=True)
class Scale:
    """Values become `zero` plus `one` for each unit: dioptres, or metres if `is_distance`."""

    zero: float
    one: float
    is_distance: bool = False

    def dioptres(self, values: FloatImage) -> FloatImage:
        """Return values as dioptres."""
        scaled = self.zero + values * np.float32(self.one)
        if self.is_distance:
            scaled = 1.0 / np.maximum(scaled, np.float32(DEPTH_LEAST_M))
        bounded: FloatImage = np.maximum(scaled, np.float32(DIOPTRES_LEAST))
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


@dataclass(frozen=True)
class Fit:
    """Raw values times `scale` plus `shift` are on the scale of the first frame."""

    scale: float = 1.0
    shift: float = 0.0

    def of(self, values: FloatImage) -> FloatImage:
        """Return the values on the scale of the first frame."""
        return values * np.float32(self.scale) + np.float32(self.shift)


@dataclass(frozen=True, eq=False)
class Estimated:
    """The raw estimate of a frame (h, w), and what the network saw of it, (h, w, 3)."""

    values: FloatImage
    seen: FloatImage

    def samples(self) -> tuple[FloatImage, FloatImage]:
        """Return values and colours at up to `_SAMPLES` places a side."""
        step = max(1, max(self.values.shape) // _SAMPLES)
        return self.values[::step, ::step], self.seen[::step, ::step]


# Scale and shift of a network drift from frame to frame, and focus would pump with them. Only what
# did not move is compared, because its true depth is the same in both frames. A camera that moves
# leaves none of it, and then only the distribution of all values can be matched.
def fitted(frame: Estimated, before: Estimated, fit_before: Fit, keeps_zero: bool) -> Fit:
    """Return the fit of a frame, given another frame with its fit.

    With `keeps_zero`, only the scale is fitted: distances have a true zero. If too little stands
    still, the middle and the spread of all values are made equal.
    """
    values, colors = frame.samples()
    wanted, seen_before = before.samples()
    target = fit_before.of(wanted).ravel().astype(np.float64)
    own = values.ravel().astype(np.float64)
    still = (np.abs(colors - seen_before).max(axis=2) < _SAME_COLOR).ravel()
    if still.mean() < _STILL_LEAST:
        return _by_spread(own, target, keeps_zero)
    return _by_least_squares(own[still], target[still], keeps_zero)


# What moved without changing its colour, such as a plain wall that somebody passes, is not excluded
# before the fit. So points far from the line count less in each round, by 1.5 times the median of
# their distances.
def _by_least_squares(
    own: np.ndarray[tuple[int], np.dtype[np.float64]],
    target: np.ndarray[tuple[int], np.dtype[np.float64]],
    keeps_zero: bool,
) -> Fit:
    """Fit a line, in which points far from it count less and less."""
    weight, fit = np.ones_like(own), Fit()
    for _ in range(_ROUNDS):
        middle = 0.0 if keeps_zero else float(np.average(own, weights=weight))
        level = 0.0 if keeps_zero else float(np.average(target, weights=weight))
        spread = float(np.average(np.square(own - middle), weights=weight))
        if spread <= 1e-12:
            return Fit(1.0, level - middle)
        scale = float(np.average((own - middle) * (target - level), weights=weight)) / spread
        fit = Fit(scale, level - scale * middle)
        away = np.abs(own * fit.scale + fit.shift - target)
        usual = 1.5 * float(np.median(away)) + 1e-9
        weight = 1.0 / (1.0 + np.square(away / usual))
    return fit if fit.scale > 0 else Fit()


def _by_spread(
    own: np.ndarray[tuple[int], np.dtype[np.float64]],
    target: np.ndarray[tuple[int], np.dtype[np.float64]],
    keeps_zero: bool,
) -> Fit:
    low, middle, high = np.quantile(own, (0.25, 0.5, 0.75))
    to_low, to_middle, to_high = np.quantile(target, (0.25, 0.5, 0.75))
    if keeps_zero:
        return Fit(float(to_middle / middle)) if middle > 0 else Fit()
    scale = float((to_high - to_low) / (high - low)) if high > low else 1.0
    return Fit(scale, float(to_middle - scale * middle))
