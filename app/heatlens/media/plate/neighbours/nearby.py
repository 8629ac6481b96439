"""Minimum and maximum filters over neighbouring pixels and blocks."""

import numpy as np

from heatlens.media.plate.plate import FloatImage

BLOCK = 4  # side of the blocks that wide filters work on


def of_nine(values: FloatImage, least: np.ufunc) -> FloatImage:
    """Return the minimum, or the maximum, over each pixel (H, W) and the eight around it."""
    rows = values.copy()
    least(rows[1:], values[:-1], out=rows[1:])
    least(rows[:-1], values[1:], out=rows[:-1])
    both = rows.copy()
    least(both[:, 1:], rows[:, :-1], out=both[:, 1:])
    least(both[:, :-1], rows[:, 1:], out=both[:, :-1])
    return both


def blocks(values: FloatImage, least: np.ufunc) -> FloatImage:
    """Return the minimum, or the maximum, of each block of pixels."""
    for _ in range(2):
        lines = values[::BLOCK].copy()
        for step in range(1, BLOCK):
            others = values[step::BLOCK]
            least(lines[: len(others)], others, out=lines[: len(others)])
        values = lines.T
    return values


def around(values: FloatImage, reach: int, least: np.ufunc) -> FloatImage:
    """Return the minimum, or the maximum, within `reach` of each value (H, W)."""
    for _ in range(2):
        done = 0
        while done < reach:
            step = min(done + 1, reach - done)  # each pass doubles the reach
            other = values.copy()
            least(other[step:], values[:-step], out=other[step:])
            least(other[:-step], values[step:], out=other[:-step])
            values, done = other, done + step
        values = values.T
    return values
