"""Measure the grain that a path tracer leaves, and remove single pixels that are far too bright."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.shot.plate_options import SPIKE_FROM, SPIKE_WHOLE
from heatlens.media.plate.plate import FloatImage

# Noise relative to the light, in the evenest parts of a plate, from which grain shows as discs.
# Clean plates of wires, leaves and patterns were measured at up to 0.013, path-traced ones of 24
# samples at 0.16.
NOISE_DOUBTFUL = 0.05
DESPIKE_HELPS = "; --despike removes single pixels that are far too bright"
_BLOCK = 8  # side of the blocks in which noise is measured, pixels
_BLOCKS_LEAST = 50
_EVENEST = 5  # per cent of the blocks that count as the evenest
_DARK = 0.1  # share of the mean light, clipped at 1: darker blocks are left out
_MAD_TO_SIGMA = 1.4826  # from the median absolute deviation to the deviation of normal noise
_ISOLATION = 0.01  # relative distance to all neighbors from which a pixel is an object of its own
_NARROW = 3  # a lamp stands on a thing up to so many pixels wide, such as a pole
_NEIGHBOURS = [(y, x) for y in range(3) for x in range(3) if (y, x) != (1, 1)]


# The noise is the median roughness of a block, in the evenest blocks: texture and edges raise the
# roughness of a block, but nothing lowers it below its grain. It is divided by the light of the
# block, because the grain of a path tracer grows with the light. Dark blocks are left out, where
# this quotient means nothing.
def measure_noise(color: FloatImage) -> float:
    """Return the relative noise of the evenest parts of a picture (H, W, C); 0 if it is too small.

    Each pixel is compared with its neighbors by a mask that is 0 on ramps and on straight edges.
    Source: J. Immerkaer, Fast Noise Variance Estimation, 1996; here with medians, which ignore
    spikes.
    """
    light = color[..., :3].mean(axis=2, dtype=np.float64)
    rows, columns = (((side - 2) // _BLOCK) for side in light.shape)
    if rows * columns < _BLOCKS_LEAST:
        return 0.0
    shifted = [light[y : y - 2 or None, x : x - 2 or None] for y in range(3) for x in range(3)]
    corners = shifted[0] + shifted[2] + shifted[6] + shifted[8]
    sides = shifted[1] + shifted[3] + shifted[5] + shifted[7]
    roughness = np.abs(corners - 2.0 * sides + 4.0 * shifted[4]) / 6.0
    block_noise, block_light = (
        _percentile(_split_into_blocks(values, rows, columns), 50)
        for values in (roughness, shifted[4])
    )
    is_lit = block_light > max(_DARK * float(np.minimum(light, 1.0).mean()), 1e-6)
    if np.count_nonzero(is_lit) < _BLOCKS_LEAST:
        return 0.0
    return _MAD_TO_SIGMA * float(_percentile(block_noise[is_lit] / block_light[is_lit], _EVENEST))


def _percentile(values: NDArray[np.float64], percent: float) -> NDArray[np.float64]:
    """Return a percentile along the last axis.

    NumPy's own loads masked arrays first, which takes longer than the rest of `info`'s work.
    """
    ordered = np.sort(values, axis=-1)
    position = percent / 100 * (ordered.shape[-1] - 1)
    low, high = ordered[..., math.floor(position)], ordered[..., math.ceil(position)]
    return np.asarray(low + (position % 1) * (high - low))


def _split_into_blocks(values: NDArray[np.float64], rows: int, columns: int) -> NDArray[np.float64]:
    """Return the complete blocks of an image as rows of an array (blocks, pixels)."""
    cropped = values[: rows * _BLOCK, : columns * _BLOCK].reshape(rows, _BLOCK, columns, _BLOCK)
    return cropped.swapaxes(1, 2).reshape(-1, _BLOCK * _BLOCK)


def noise_note(noise: float, label: str, cure: str = "") -> tuple[str, ...]:
    """Return a note if the noise of a picture is too much; `cure` ends the advice."""
    if noise < NOISE_DOUBTFUL:
        return ()
    return (
        (
            f"{label} is noisy: its flat parts vary by {100 * noise:.0f} % from pixel to pixel, "
            "and each bright grain becomes a small disc out of focus. Denoise it or render more "
            f"samples{cure}."
        ),
    )


# A bright grain becomes a disc whether it is drawn as a highlight or diffused, because both keep
# its light, so the light itself is removed. A pixel that is isolated in depth, or on a pole, is
# spared: it may be a lamp, which otherwise looks like a grain.
def despike(color: FloatImage, depth: FloatImage) -> int:
    """Replace pixels of `color` (H, W, C) far brighter than all around them, in place; count them.

    The more a pixel outshines the brightest of its eight neighbors, the more it is mixed with
    their median; this gradual change avoids pops between frames. A pixel far from all its
    neighbors in `depth` (H, W), or on a narrow thing in front of others, is a lamp and stays.
    """
    light = color[..., :3].mean(axis=2)
    brightest = np.maximum(np.max(list(_neighbours(light)), axis=0), 0.0)
    is_spike = (
        (light > SPIKE_FROM * brightest) & ~_mask_isolated(depth) & ~_mask_on_narrow_thing(depth)
    )
    rows, columns = np.nonzero(is_spike)
    if not rows.size:
        return 0
    padded = np.pad(color[..., :3], ((1, 1), (1, 1), (0, 0)), mode="reflect")
    median_color = np.median([padded[rows + y, columns + x] for y, x in _NEIGHBOURS], axis=0)
    ratio = light[is_spike] / np.maximum(brightest[is_spike], np.float32(1e-30))
    weight = np.minimum((ratio - SPIKE_FROM) / (SPIKE_WHOLE - SPIKE_FROM), 1.0)[:, None]
    color[is_spike, :3] += weight * (median_color - color[is_spike, :3])
    return int(rows.size)


def despike_with_note(color: FloatImage, depth: FloatImage, label: str) -> tuple[str, ...]:
    """Despike the picture, and return a sentence with the number of changed pixels."""
    count = despike(color, depth)
    words = f"{count} of {depth.size} pixels were far brighter than their neighbours"
    return (f"{label}: {words} and were replaced by their median (--despike).",)


def _neighbours(values: FloatImage) -> Iterator[FloatImage]:
    """Yield eight arrays: the neighbors of every pixel; the picture is mirrored at the border."""
    (height, width), padded = values.shape, np.pad(values, 1, mode="reflect")
    return (padded[y : y + height, x : x + width] for y, x in _NEIGHBOURS)


def _mask_isolated(depth: FloatImage) -> NDArray[np.bool_]:
    """Return a mask of the pixels at another depth than each of their neighbors."""
    is_apart = np.ones(depth.shape, bool)
    with np.errstate(invalid="ignore"):  # infinity minus infinity in the sky
        for neighbour in _neighbours(depth):
            nearer_depth = np.minimum(np.abs(depth), np.abs(neighbour))
            is_apart &= np.abs(depth - neighbour) > _ISOLATION * nearer_depth
    return is_apart


def _mask_on_narrow_thing(depth: FloatImage) -> NDArray[np.bool_]:
    """Return a mask of the pixels on things at most `_NARROW` pixels wide or high.

    Such a pixel has something farther away on both sides along a row or a column.
    """
    is_narrow = np.zeros(depth.shape, bool)
    for oriented_depth, oriented_mask in ((depth, is_narrow), (depth.T, is_narrow.T)):
        padded = np.pad(oriented_depth, ((_NARROW, _NARROW), (0, 0)), mode="edge")
        rows = len(oriented_depth)
        is_behind = [
            padded[i : i + rows] > (1 + _ISOLATION) * oriented_depth for i in range(2 * _NARROW + 1)
        ]
        for rows_before in range(
            1, _NARROW + 1
        ):  # the sides of the thing lie _NARROW + 1 rows apart
            oriented_mask |= np.logical_or.reduce(
                is_behind[_NARROW - rows_before : _NARROW]
            ) & np.logical_or.reduce(is_behind[_NARROW + 1 : 2 * _NARROW + 2 - rows_before])
    return is_narrow
