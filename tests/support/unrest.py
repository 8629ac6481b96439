"""How much a slow pull jumps."""

from collections.abc import Sequence

import numpy as np

from support.plates import Image


def unrest(frames: Sequence[Image]) -> float:
    """Return how far the least steady frame of a slow pull stands out, 1 for none.

    `frames` are linear (H, W, 3). Each one's display values are compared with the mean of the
    frames before and after it; the result is the largest mean difference over the median one.
    """
    shown = np.array([_display(frame) for frame in frames])
    second = np.abs(shown[2:] - 2 * shown[1:-1] + shown[:-2]).mean(axis=(1, 2, 3))
    return float(second.max() / np.median(second))


def _display(frame: Image) -> Image:
    light = np.clip(frame, 0.0, 1.0)
    return np.where(light < 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def flash(frames: Sequence[Image], side: int = 4) -> float:
    """Return by how many display code values a block of pixels is off for one frame, at most.

    Blocks of `side` pixels count if their mean differs from that in the frame before and in the
    frame after in the same direction, and then with the smaller difference.
    """
    shown = np.array([_display(frame) for frame in frames]).mean(axis=-1)
    count, height, width = shown.shape
    whole = shown[:, : height - height % side, : width - width % side]
    cells = (count, height // side, side, width // side, side)
    before, here, after = (
        whole.reshape(cells).mean(axis=(2, 4))[i : count - 2 + i] for i in range(3)
    )
    up = np.minimum(here - before, here - after)
    down = np.minimum(before - here, after - here)
    return 255.0 * float(np.maximum(up, down).max())
