"""Fit the estimate of a frame to that of an earlier one, because networks drift.

Scale and shift of a relative depth differ between frames. They are fitted over what did not move.
"""

from dataclasses import dataclass

import numpy as np

from heatlens.plate.plate import FloatImage

_SAME_COLOR = 0.03  # change of display values below which nothing has moved
_STILL_LEAST = 0.05  # least share of the picture that must stand still for a fit
_ROUNDS = 4
_SAMPLES = 160  # samples along each side


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


def fitted(frame: Estimated, before: Estimated, fit_before: Fit, keeps_zero: bool) -> Fit:
    """Return the fit of a frame, given another frame with its fit.

    With `keeps_zero`, only the scale is fitted: distances have a true zero. If too little stands
    still, the middle and the spread of all values are made equal.
    """
    values, seen = frame.samples()
    wanted, seen_before = before.samples()
    target = fit_before.of(wanted).ravel().astype(np.float64)
    own = values.ravel().astype(np.float64)
    still = (np.abs(seen - seen_before).max(axis=2) < _SAME_COLOR).ravel()
    if still.mean() < _STILL_LEAST:
        return _by_spread(own, target, keeps_zero)
    return _by_least_squares(own[still], target[still], keeps_zero)


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
