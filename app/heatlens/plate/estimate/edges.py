"""Repair the edges of an estimated depth by the colour.

Networks blur the edges of depth, which puts rims in mid-air between two objects. Each pixel of
such a ramp takes the nearer or the farther value beside it, whose colour is more like its own.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.plate import FloatImage

_STEP_LEAST = 0.04  # share of the range: smaller steps stay as they are
_STEEP = 0.65  # part of a step that a ramp climbs over its width; an even slope climbs a half
_END = 0.2  # part of a step at either end from which colours are taken
_NOISE = 0.01  # squared difference of two colours that are alike


def with_sharp_edges(values: FloatImage, color: FloatImage, ramp_px: int) -> FloatImage:
    """Return `values` (H, W) of 0 to 1 with steps in place of ramps about `ramp_px` pixels wide.

    `color` holds display values (H, W, 3). Where colours do not tell the two sides apart, as
    between textures, the middle of the ramp decides.
    """
    low, high = _least(values, ramp_px), -_least(-values, ramp_px)
    step = high - low
    climb = _STEEP * step * _cut_off(values.shape, ramp_px)
    is_steep = (_slope(values) * ramp_px > climb) & (step > _STEP_LEAST)
    is_ramp = -_least(-is_steep.astype(np.float32), max(1, ramp_px // 2)) > 0
    place = (values - low) / np.maximum(step, 1e-6)
    near = _colors(color, (place >= 1 - _END) & (step > _STEP_LEAST), ramp_px)
    far = _colors(color, (place <= _END) & (step > _STEP_LEAST), ramp_px)
    apart = np.square(near.mean - far.mean).sum(axis=2)
    trust = apart / (apart + 2.0 * (near.variance + far.variance) + _NOISE)
    to_near, to_far = (np.square(color - it.mean).sum(axis=2) for it in (near, far))
    by_color = np.clip(0.5 + (to_far - to_near) / (2.0 * np.maximum(apart, 1e-6)), 0.0, 1.0)
    is_near = trust * by_color + (1.0 - trust) * place > 0.5
    return np.where(is_ramp, np.where(is_near, high, low), values).astype(np.float32)


def _cut_off(shape: tuple[int, ...], reach_px: int) -> FloatImage:
    """Return how many times narrower the border makes the square around each pixel: 1 to 2."""
    height, width = (2 * reach_px / np.maximum(_span(count, reach_px), 1) for count in shape)
    factor: FloatImage = np.maximum(height[:, None], width[None, :])
    return factor


def _span(count: int, reach_px: int) -> NDArray[np.int64]:
    """Return the distance between the ends of the span around each of `count` pixels."""
    at = np.arange(count)
    return np.minimum(at + reach_px, count - 1) - np.maximum(at - reach_px, 0)


@dataclass(frozen=True, eq=False)
class _Colors:
    """Mean (H, W, 3) and variance (H, W) of the colours around each pixel."""

    mean: FloatImage
    variance: FloatImage


def _colors(color: FloatImage, where: NDArray[np.bool_], reach_px: int) -> _Colors:
    """Return the colours of the pixels in `where` within `reach_px` pixels."""
    weight = where.astype(np.float32)[:, :, None]
    total = np.maximum(_box_sum(weight, reach_px), 1e-6)
    mean = _box_sum(color * weight, reach_px) / total
    squares = _box_sum(np.square(color) * weight, reach_px) / total
    variance = np.maximum(squares - np.square(mean), 0.0).sum(axis=2)
    return _Colors(np.asarray(mean, np.float32), np.asarray(variance, np.float32))


def _slope(values: FloatImage) -> FloatImage:
    """Return how much the values change from pixel to pixel."""
    along_y, along_x = np.gradient(values)
    slope: FloatImage = np.hypot(along_y, along_x)
    return slope


def _least(values: FloatImage, reach_px: int) -> FloatImage:
    """Return the least value within `reach_px` pixels along both axes, by windows that double."""
    for _ in range(2):  # along columns, then along rows
        least: FloatImage = np.pad(values, ((reach_px, reach_px), (0, 0)), "edge")
        length, wanted = 1, 2 * reach_px + 1
        while length < wanted:
            step = min(length, wanted - length)
            least = np.minimum(least[:-step], least[step:])
            length += step
        values = least.T
    return values


def _box_sum(values: FloatImage, reach_px: int) -> FloatImage:
    """Return sums over squares of 2 reach + 1 pixels; beyond the border the values are 0."""
    summed: FloatImage = values
    for axis in (0, 1):
        pad = [(reach_px + 1, reach_px) if a == axis else (0, 0) for a in range(3)]
        sums = np.cumsum(np.pad(summed, pad), axis=axis, dtype=np.float64)
        at = np.arange(summed.shape[axis])
        both = np.take(sums, at + 2 * reach_px + 1, axis=axis) - np.take(sums, at, axis=axis)
        summed = both.astype(np.float32)
    return summed
