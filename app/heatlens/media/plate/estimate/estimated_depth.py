"""Estimate the depth of a picture that has none, with the edges of its colours.

Networks blur the edges of depth, which puts rims in mid-air between two objects. Each pixel of such
a ramp takes the nearer or the farther value beside it, whose colour is more like its own.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention, DepthKind, DepthModelOutput
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.depth.depth import DepthResult, checked_ends, with_ends
from heatlens.media.plate.depth.depth_guess import DepthOrigin, Guess, looked_at
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M
from heatlens.media.plate.estimate.chain import Chain, Look, estimated
from heatlens.media.plate.estimate.network import Network, as_display, network_at, resized
from heatlens.media.plate.estimate.scale import DIOPTRES_LEAST, Fit, scale_of
from heatlens.media.plate.plate import DepthReport, FloatImage
from heatlens.media.sequence.sequence import Sequence, find_sequence

CHANNEL = "estimate"
_RAMP_PX = 3.0  # pixels of the network over which it blurs an edge, to either side
_REACH_MOST_PX = 24
_STEP_LEAST = 0.04  # share of the range: smaller steps stay as they are
_STEEP = 0.65  # part of a step that a ramp climbs over its width; an even slope climbs a half
_END = 0.2  # part of a step at either end from which colours are taken
_NOISE = 0.01  # squared difference of two colours that are alike


def estimated_depth(
    path: Path, color: FloatImage, options: PlateOptions, look: Look
) -> DepthResult:
    """Return the estimated depth (H, W) in metres of light (H, W, 3 or more).

    `look` reads other frames of the sequence. Raises InputError if the network cannot be run, or if
    its values need distances that are missing and `options` are strict.
    """
    assert options.depth_model is not None
    network = network_at(options.depth_model, options.depth_model_output)
    frame, sequence = estimated(network, color), _sequence_of(path)
    fit, first = Fit(), frame
    if sequence is not None:
        chain = Chain(network, sequence, look)
        fit, first = chain.fit_of(path, frame), chain.start(0)
    values = fit.of(frame.values)
    options, guess = _guess(path, network, options, first.values)
    scale = scale_of(first.values, network.facts.output, options, color.shape)
    height, width = color.shape[:2]
    dioptres = scale.dioptres(resized(values, width, height))
    depth = 1.0 / _sharp(dioptres, color, values.shape)
    depth = np.clip(depth, DEPTH_LEAST_M, 1.0 / DIOPTRES_LEAST).astype(np.float32)
    report = DepthReport(
        CHANNEL,
        guess.convention,
        DepthKind.PLANAR,
        guess.why,
        float(depth.min()),
        float(depth.max()),
        infinite_count=0,
        repaired_count=0,
        question=guess.question,
    )
    question = f"{guess.question} {guess.why}" if guess.question else ""
    return DepthResult(depth, report, tuple(filter(None, [network.note, question])))


def _guess(
    path: Path, network: Network, options: PlateOptions, first: FloatImage
) -> tuple[PlateOptions, Guess]:
    """Return the options with both ends of a disparity, and what the user is told of the depth."""
    by = f"Estimated by {network.path.name}."
    if network.facts.output is not DepthModelOutput.DISPARITY:
        return options, Guess(DepthConvention.DISTANCE, by)
    raw = looked_at(first, f"{path}: the estimate", CHANNEL, DepthOrigin())
    options, guess = with_ends(raw, options, Guess(DepthConvention.DISPARITY, by))
    checked_ends(raw, options)
    return options, guess


def _sequence_of(path: Path) -> Sequence | None:
    try:
        sequence = find_sequence(path)
    except InputError:  # standard input
        return None
    return None if sequence.is_single else sequence


def _sharp(dioptres: FloatImage, color: FloatImage, own: tuple[int, ...]) -> FloatImage:
    """Return dioptres (H, W) with the edges of the picture; `own` is the size of the estimate."""
    low, high = (float(it) for it in np.quantile(dioptres[::4, ::4], (0.0, 1.0)))
    scale = max(dioptres.shape[0] / own[0], dioptres.shape[1] / own[1])
    reach = min(round(_RAMP_PX * max(scale, 1.0)), _REACH_MOST_PX)
    span = np.float32(max(high - low, 1e-9))
    shares = (dioptres - np.float32(low)) / span
    sharp = with_sharp_edges(shares, as_display(color), max(reach, 1))
    sharpened: FloatImage = np.maximum(sharp * span + np.float32(low), np.float32(DIOPTRES_LEAST))
    return sharpened


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
    # A map of one row or column has no slope across it.
    along = (
        np.gradient(values, axis=axis) if values.shape[axis] > 1 else np.zeros_like(values)
        for axis in (0, 1)
    )
    slope: FloatImage = np.hypot(*along)
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
