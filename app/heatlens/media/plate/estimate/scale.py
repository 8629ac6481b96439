"""Turn the values of a network into dioptres, by the ends of the depth or a known distance.

Networks drift: scale and shift of a relative depth differ between frames. The estimate of a frame
is fitted to that of an earlier one, over the pixels that did not move.
"""

from dataclasses import dataclass

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthModelOutput, KnownDistance
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M
from heatlens.media.plate.plate import FloatImage

DIOPTRES_LEAST = 1e-4  # ten kilometers; networks know no infinity
_ENDS = 0.002, 0.998  # quantiles of the first frame's values that count as far and near
_SAME_COLOR = 0.03  # change of display values below which nothing has moved
_STILL_LEAST = 0.05  # least share of the picture that must stand still for a fit
_ROUNDS = 4  # of the fit, each of which reweights the samples
_SAMPLES = 160  # samples along each side


@dataclass(frozen=True)
class Scale:
    """Values times `factor` plus `offset` are dioptres, or meters if `is_distance`."""

    offset: float
    factor: float
    is_distance: bool = False

    def dioptres(self, values: FloatImage) -> FloatImage:
        """Return values of the network as dioptres (1 / meters), at least DIOPTRES_LEAST."""
        scaled = self.offset + values * np.float32(self.factor)
        if self.is_distance:
            scaled = 1.0 / np.maximum(scaled, np.float32(DEPTH_LEAST_M))
        bounded: FloatImage = np.maximum(scaled, np.float32(DIOPTRES_LEAST))
        return bounded


def scale_of(
    first_values: FloatImage,
    output: DepthModelOutput,
    options: PlateOptions,
    shape: tuple[int, ...],
) -> Scale:
    """Return the scale for the values (h, w) of the first frame, whose picture has this shape.

    A disparity needs near and far in `options`. Raises InputError for a known distance outside the
    picture.
    """
    known_distance = options.depth_known
    value = None if known_distance is None else _value_at(first_values, known_distance, shape)
    if output is DepthModelOutput.DISPARITY:
        return _scale_of_disparity(first_values, options, value)
    is_distance = output is DepthModelOutput.METRES
    if known_distance is None or not value or value < 0:
        return Scale(0.0, 1.0, is_distance)
    true_value = known_distance.distance_m if is_distance else 1.0 / known_distance.distance_m
    return Scale(0.0, true_value / value, is_distance)


def _value_at(
    first_values: FloatImage, known_distance: KnownDistance, shape: tuple[int, ...]
) -> float:
    """Return the value of the network at the pixel of the picture whose distance is known.

    `first_values` are those of the first frame, at the size of the network. `shape` is the shape of
    the picture. Raises InputError if the pixel is outside it.
    """
    row, column = (int(at // 1) for at in (known_distance.y_px, known_distance.x_px))
    height, width = shape[:2]
    if not (0 <= row < height and 0 <= column < width):
        raise InputError(f"--depth-known {known_distance}: the pixel is outside the picture.")
    return float(
        first_values[row * first_values.shape[0] // height, column * first_values.shape[1] // width]
    )


def _scale_of_disparity(
    first_values: FloatImage, options: PlateOptions, value: float | None
) -> Scale:
    """Return the scale of a disparity: values that are linear in 1/distance.

    The low end of `first_values` becomes far and the high end near. If a distance is known, its
    pixel, with the network's `value`, decides the factor instead of near.
    """
    assert options.near_m is not None and options.far_m is not None
    low, high = (float(it) for it in np.quantile(first_values, _ENDS))
    far, near = 1.0 / options.far_m, 1.0 / options.near_m
    factor = (near - far) / max(high - low, 1e-12)
    if options.depth_known is not None and value is not None and value > low:
        factor = max(1.0 / options.depth_known.distance_m - far, 0.0) / (value - low)
    return Scale(far - factor * low, factor)


@dataclass(frozen=True)
class Fit:
    """A line: raw values times `scale` plus `shift` are on the scale of the first frame."""

    scale: float = 1.0
    shift: float = 0.0

    def apply(self, values: FloatImage) -> FloatImage:
        """Return the values on the scale of the first frame."""
        return values * np.float32(self.scale) + np.float32(self.shift)


@dataclass(frozen=True, eq=False)
class FrameEstimate:
    """The raw estimate of a frame (h, w), and its display colors in the same size (h, w, 3)."""

    values: FloatImage
    color: FloatImage

    def sample_grid(self) -> tuple[FloatImage, FloatImage]:
        """Return the values and colors at up to `_SAMPLES` pixels along each side."""
        step = max(1, max(self.values.shape) // _SAMPLES)
        return self.values[::step, ::step], self.color[::step, ::step]


# Scale and shift of a network drift from frame to frame, and the focus would pump with them. Only
# pixels that did not move are compared, because their true depth is the same in both frames. Where
# the camera moves there are none, and the distribution of all values is matched instead.
def fit_to_frame(
    frame: FrameEstimate, earlier_frame: FrameEstimate, earlier_fit: Fit, keeps_zero: bool
) -> Fit:
    """Return the fit of a frame, given another frame with its fit.

    With `keeps_zero`, only the scale is fitted: distances have a true zero. If too few pixels stand
    still, the median and the spread of all values are made equal.
    """
    values, colors = frame.sample_grid()
    earlier_values, earlier_colors = earlier_frame.sample_grid()
    target = earlier_fit.apply(earlier_values).ravel().astype(np.float64)
    frame_values = values.ravel().astype(np.float64)
    is_still = (np.abs(colors - earlier_colors).max(axis=2) < _SAME_COLOR).ravel()
    if is_still.mean() < _STILL_LEAST:
        return _fit_by_spread(frame_values, target, keeps_zero)
    return _fit_by_least_squares(frame_values[is_still], target[is_still], keeps_zero)


# Points far from the line count less in each round; the scale is 1.5 times the median of all
# distances. This excludes pixels that moved without changing their color, such as those of a plain
# wall that somebody passes.
def _fit_by_least_squares(
    frame_values: np.ndarray[tuple[int], np.dtype[np.float64]],
    target: np.ndarray[tuple[int], np.dtype[np.float64]],
    keeps_zero: bool,
) -> Fit:
    """Fit a line from `frame_values` to `target`; points far from it weigh less in each round."""
    weight, fit = np.ones_like(frame_values), Fit()
    for _ in range(_ROUNDS):
        frame_mean = 0.0 if keeps_zero else float(np.average(frame_values, weights=weight))
        target_mean = 0.0 if keeps_zero else float(np.average(target, weights=weight))
        variance = float(np.average(np.square(frame_values - frame_mean), weights=weight))
        if variance <= 1e-12:
            return Fit(1.0, target_mean - frame_mean)
        scale = (
            float(np.average((frame_values - frame_mean) * (target - target_mean), weights=weight))
            / variance
        )
        fit = Fit(scale, target_mean - scale * frame_mean)
        distance = np.abs(frame_values * fit.scale + fit.shift - target)
        tolerance = 1.5 * float(np.median(distance)) + 1e-9
        weight = 1.0 / (1.0 + np.square(distance / tolerance))
    # A negative scale would exchange near and far.
    return fit if fit.scale > 0 else Fit()


def _fit_by_spread(
    frame_values: np.ndarray[tuple[int], np.dtype[np.float64]],
    target: np.ndarray[tuple[int], np.dtype[np.float64]],
    keeps_zero: bool,
) -> Fit:
    """Fit a line that makes the median of the values, and their quartiles, equal to `target`'s.

    With `keeps_zero`, only the median is made equal, by the scale alone.
    """
    low, middle, high = np.quantile(frame_values, (0.25, 0.5, 0.75))
    to_low, to_middle, to_high = np.quantile(target, (0.25, 0.5, 0.75))
    if keeps_zero:
        return Fit(float(to_middle / middle)) if middle > 0 else Fit()
    scale = float((to_high - to_low) / (high - low)) if high > low else 1.0
    return Fit(scale, float(to_middle - scale * middle))
