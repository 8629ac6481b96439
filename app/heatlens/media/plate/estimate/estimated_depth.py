"""Estimate the depth of a picture that has none, with edges as sharp as those of its colors.

Networks blur the edges of depth into ramps, whose pixels would hang in mid-air between two objects.
Each pixel of a ramp takes the nearer or the farther value next to it, whose color is more like its
own.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Explained
from heatlens.core.model.depth_words import DepthConvention, DepthKind, DepthModelOutput
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.depth.depth import DepthResult, require_ends, settle_ends
from heatlens.media.plate.depth.depth_guess import Guess
from heatlens.media.plate.depth.raw_depth import DepthOrigin, measure_raw_depth
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M
from heatlens.media.plate.estimate.chain import Chain, ReadColor, estimate_frame
from heatlens.media.plate.estimate.network import (
    Network,
    convert_to_display,
    network_at,
    resize_plane,
)
from heatlens.media.plate.estimate.scale import DIOPTRES_LEAST, Fit, scale_of
from heatlens.media.plate.plate import DepthReport, FloatImage
from heatlens.media.sequence.sequence import Sequence
from heatlens.media.sequence.sequence_search import find_sequence

CHANNEL = "estimate"
_RAMP_PX = 3.0  # half the width of the ramp to which the network blurs an edge, in its pixels
_REACH_MOST_PX = 24  # largest half width of a ramp in pixels of the picture
_STEP_LEAST = 0.04  # share of the range: smaller steps stay as they are
_STEEP = 0.65  # part of a step that a ramp climbs over its width; an even slope climbs a half
_END = 0.2  # pixels within this share of a step at either end show the colors of the two sides
_NOISE = 0.01  # squared difference of two colors that are alike


def estimate_depth(
    path: Path, color: FloatImage, options: PlateOptions, read_color: ReadColor
) -> DepthResult:
    """Return the estimated depth (H, W) in meters of light (H, W, 3 or more).

    `read_color` reads other frames of the sequence. Raises InputError if the network cannot be run,
    or if its values need distances that are missing and `options` are strict.
    """
    assert options.depth_model is not None
    network = network_at(options.depth_model, options.depth_model_output)
    frame, sequence = estimate_frame(network, color), _sequence_of(path)
    fit, first_frame = Fit(), frame
    if sequence is not None:
        chain = Chain(network, sequence, read_color)
        fit, first_frame = chain.fit_of(path, frame), chain.start_estimate(0)
    values = fit.apply(frame.values)
    options, guess = _settle_guess(path, network, options, first_frame.values)
    scale = scale_of(first_frame.values, network.facts.output, options, color.shape)
    height, width = color.shape[:2]
    dioptres = scale.dioptres(resize_plane(values, width, height))
    depth = 1.0 / _sharpen_dioptres(dioptres, color, values.shape)
    depth = np.clip(depth, DEPTH_LEAST_M, 1.0 / DIOPTRES_LEAST).astype(np.float32)
    report = DepthReport(
        channel=CHANNEL,
        convention=guess.convention,
        kind=DepthKind.PLANAR,
        why=guess.why,
        near_m=float(depth.min()),
        far_m=float(depth.max()),
        infinite_count=0,
        repaired_count=0,
        question=guess.question,
    )
    sentence = f"{path}: the depth is estimated. {guess.advice}"
    note = Explained(sentence, guess.question) if guess.question else ""
    return DepthResult(depth, report, tuple(filter(None, [network.note, note])))


def _settle_guess(
    path: Path, network: Network, options: PlateOptions, first_values: FloatImage
) -> tuple[PlateOptions, Guess]:
    """Return the options with the ends of a disparity filled in, and the guess to show to the user.

    `first_values` is the raw estimate of the first frame, (h, w).
    """
    why = f"Estimated by {network.path.name}."
    if network.facts.output is not DepthModelOutput.DISPARITY:
        return options, Guess(DepthConvention.DISTANCE, why)
    raw = measure_raw_depth(first_values, f"{path}: the estimate", CHANNEL, DepthOrigin())
    options, guess = settle_ends(raw, options, Guess(DepthConvention.DISPARITY, why))
    require_ends(raw, options)
    return options, guess


def _sequence_of(path: Path) -> Sequence | None:
    """Return the sequence of the file at `path`; None for a single picture and standard input."""
    try:
        sequence = find_sequence(path)
    except InputError:  # standard input
        return None
    return None if sequence.is_single else sequence


def _sharpen_dioptres(
    dioptres: FloatImage, color: FloatImage, estimate_shape: tuple[int, ...]
) -> FloatImage:
    """Return dioptres (H, W) with the ramps at edges turned into steps where the colors change.

    `color` holds light (H, W, 3 or more). `estimate_shape` is the size of the network's estimate
    before it was resized.
    """
    low, high = (float(it) for it in np.quantile(dioptres[::4, ::4], (0.0, 1.0)))
    scale = max(dioptres.shape[0] / estimate_shape[0], dioptres.shape[1] / estimate_shape[1])
    reach = min(round(_RAMP_PX * max(scale, 1.0)), _REACH_MOST_PX)
    span = np.float32(max(high - low, 1e-9))
    shares = (dioptres - np.float32(low)) / span
    sharp_shares = sharpen_edges(shares, convert_to_display(color), max(reach, 1))
    sharpened: FloatImage = np.maximum(
        sharp_shares * span + np.float32(low), np.float32(DIOPTRES_LEAST)
    )
    return sharpened


def sharpen_edges(values: FloatImage, color: FloatImage, ramp_px: int) -> FloatImage:
    """Return `values` (H, W) of 0 to 1 with steps in place of ramps about `ramp_px` pixels wide.

    `color` holds display values (H, W, 3). Where colors do not distinguish the two sides, as
    between textures, the step lies at the middle of the ramp.
    """
    low, high = _window_minimum(values, ramp_px), -_window_minimum(-values, ramp_px)
    step = high - low  # height of the step within the window of each pixel
    least_climb = _STEEP * step * _border_narrowing(values.shape, ramp_px)
    is_steep = (_slope(values) * ramp_px > least_climb) & (step > _STEP_LEAST)
    is_ramp = -_window_minimum(-is_steep.astype(np.float32), max(1, ramp_px // 2)) > 0
    position = (values - low) / np.maximum(step, 1e-6)
    near_colors = _measure_colors(color, (position >= 1 - _END) & (step > _STEP_LEAST), ramp_px)
    far_colors = _measure_colors(color, (position <= _END) & (step > _STEP_LEAST), ramp_px)
    color_distance = np.square(near_colors.mean - far_colors.mean).sum(axis=2)
    # Trust in the colors is 0 to 1: near 1 if the two sides differ more than each of them varies.
    trust = color_distance / (
        color_distance + 2.0 * (near_colors.variance + far_colors.variance) + _NOISE
    )
    to_near, to_far = (np.square(color - it.mean).sum(axis=2) for it in (near_colors, far_colors))
    # The position of the pixel's color between those of the far side (0) and of the near side (1).
    position_by_color = np.clip(
        0.5 + (to_far - to_near) / (2.0 * np.maximum(color_distance, 1e-6)), 0.0, 1.0
    )
    is_near = trust * position_by_color + (1.0 - trust) * position > 0.5
    return np.where(is_ramp, np.where(is_near, high, low), values).astype(np.float32)


def _border_narrowing(shape: tuple[int, ...], reach_px: int) -> FloatImage:
    """Return the factor (H, W), 1 to 2, by which the border narrows the window around a pixel."""
    height, width = (
        2 * reach_px / np.maximum(_window_length(count, reach_px), 1) for count in shape
    )
    factor: FloatImage = np.maximum(height[:, None], width[None, :])
    return factor


def _window_length(count: int, reach_px: int) -> NDArray[np.int64]:
    """Return the length of the window around each of `count` pixels; the border cuts it off."""
    index = np.arange(count)
    return np.minimum(index + reach_px, count - 1) - np.maximum(index - reach_px, 0)


@dataclass(frozen=True, eq=False)
class _ColorStatistics:
    """Mean (H, W, 3) and variance (H, W) of the colors around each pixel."""

    mean: FloatImage
    variance: FloatImage


def _measure_colors(color: FloatImage, mask: NDArray[np.bool_], reach_px: int) -> _ColorStatistics:
    """Return mean and variance of the colors in `mask` within `reach_px` pixels of each pixel."""
    weight = mask.astype(np.float32)[:, :, None]
    total = np.maximum(_box_sum(weight, reach_px), 1e-6)
    mean = _box_sum(color * weight, reach_px) / total
    squares = _box_sum(np.square(color) * weight, reach_px) / total
    variance = np.maximum(squares - np.square(mean), 0.0).sum(axis=2)
    return _ColorStatistics(np.asarray(mean, np.float32), np.asarray(variance, np.float32))


def _slope(values: FloatImage) -> FloatImage:
    """Return the magnitude of the gradient of values (H, W), per pixel."""
    # A map of one row or column has no slope across it.
    gradients = (
        np.gradient(values, axis=axis) if values.shape[axis] > 1 else np.zeros_like(values)
        for axis in (0, 1)
    )
    slope: FloatImage = np.hypot(*gradients)
    return slope


def _window_minimum(values: FloatImage, reach_px: int) -> FloatImage:
    """Return the least value within `reach_px` pixels along both axes.

    The window doubles in each step until it is wide enough.
    """
    for _ in range(2):  # along columns, then along rows; each pass transposes the values
        minimum: FloatImage = np.pad(values, ((reach_px, reach_px), (0, 0)), "edge")
        length, target_length = 1, 2 * reach_px + 1
        while length < target_length:
            step = min(length, target_length - length)
            minimum = np.minimum(minimum[:-step], minimum[step:])
            length += step
        values = minimum.T
    return values


def _box_sum(values: FloatImage, reach_px: int) -> FloatImage:
    """Return sums (H, W, C) over squares with sides of 2 `reach_px` + 1 pixels.

    Beyond the border the values are 0.
    """
    summed: FloatImage = values
    for axis in (0, 1):
        pad = [(reach_px + 1, reach_px) if a == axis else (0, 0) for a in range(3)]
        sums = np.cumsum(np.pad(summed, pad), axis=axis, dtype=np.float64)
        index = np.arange(summed.shape[axis])
        window_sums = np.take(sums, index + 2 * reach_px + 1, axis=axis) - np.take(
            sums, index, axis=axis
        )
        summed = window_sums.astype(np.float32)
    return summed
