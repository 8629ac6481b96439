"""Minimum and maximum filters over neighboring pixels and blocks."""

import numpy as np

from heatlens.media.plate.plate import FloatImage

BLOCK = 4  # side of the blocks that wide filters work on


def filter_three_by_three(values: FloatImage, reduce: np.ufunc) -> FloatImage:
    """Return `reduce` (np.minimum or np.maximum) over each pixel (H, W) and the eight around it."""
    rows = values.copy()
    reduce(rows[1:], values[:-1], out=rows[1:])
    reduce(rows[:-1], values[1:], out=rows[:-1])
    nine = rows.copy()
    reduce(nine[:, 1:], rows[:, :-1], out=nine[:, 1:])
    reduce(nine[:, :-1], rows[:, 1:], out=nine[:, :-1])
    return nine


def reduce_blocks(values: FloatImage, reduce: np.ufunc) -> FloatImage:
    """Return `reduce` (np.minimum or np.maximum) over each block of BLOCK x BLOCK pixels."""
    for _ in range(2):  # along columns, then along rows; each pass transposes the values
        lines = values[::BLOCK].copy()
        for step in range(1, BLOCK):
            next_lines = values[step::BLOCK]
            reduce(lines[: len(next_lines)], next_lines, out=lines[: len(next_lines)])
        values = lines.T
    return values


def filter_within(values: FloatImage, reach: int, reduce: np.ufunc) -> FloatImage:
    """Return `reduce` (np.minimum or np.maximum) over all values within `reach` of each (H, W)."""
    for _ in range(2):  # along columns, then along rows; each pass transposes the values
        covered = 0
        while covered < reach:
            step = min(covered + 1, reach - covered)  # each pass doubles the reach
            widened = values.copy()
            reduce(widened[step:], values[:-step], out=widened[step:])
            reduce(widened[:-step], values[step:], out=widened[:-step])
            values, covered = widened, covered + step
        values = values.T
    return values
