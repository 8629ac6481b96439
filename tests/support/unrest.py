"""Measure how much a slow focus pull jumps or flashes from frame to frame."""

from collections.abc import Sequence

import numpy as np

from support.plates import Image


def unrest(frames: Sequence[Image]) -> float:
    """Return the unsteadiness of the worst frame of a slow pull, 1 for a perfectly steady pull.

    `frames` are linear (H, W, 3). Each one's display values are compared with the mean of the
    frames before and after it; the result is the largest mean difference over the median one.
    """
    display = np.array([display_of(frame) for frame in frames])
    mean_differences = np.abs(display[2:] - 2 * display[1:-1] + display[:-2]).mean(axis=(1, 2, 3))
    return float(mean_differences.max() / np.median(mean_differences))


def display_of(frame: Image) -> Image:
    """Return display values (sRGB), 0..1, of scene-linear light."""
    light = np.clip(frame, 0.0, 1.0)
    return np.where(light < 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def flash(frames: Sequence[Image], side: int = 4) -> float:
    """Return the largest one-frame deviation of a block of pixels in display code values.

    Blocks of `side` pixels count if their mean differs from that in the frame before and in the
    frame after in the same direction, and then with the smaller difference.
    """
    display = np.array([display_of(frame) for frame in frames]).mean(axis=-1)
    count, height, width = display.shape
    cropped = display[:, : height - height % side, : width - width % side]
    cells = (count, height // side, side, width // side, side)
    before, current, after = (
        cropped.reshape(cells).mean(axis=(2, 4))[i : count - 2 + i] for i in range(3)
    )
    up = np.minimum(current - before, current - after)
    down = np.minimum(before - current, after - current)
    return 255.0 * float(np.maximum(up, down).max())
