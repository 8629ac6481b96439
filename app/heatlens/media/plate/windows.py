"""Convert data and display windows between closed intervals in files and half-open boxes.

Only this module knows the closed intervals of the file.
"""

import math
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.media.plate.header.channels import Header
from heatlens.media.plate.plate import FloatImage

Number = TypeVar("Number", bound=np.generic)
HeaderWindow = tuple[NDArray[np.int32], NDArray[np.int32]]


def read_header_window(header: Header, key: str) -> Box:
    """Return the window `key` ("dataWindow" or "displayWindow") of an EXR header."""
    (x_min, y_min), (x_max, y_max) = header[key]
    return Box(int(x_min), int(y_min), int(x_max) + 1, int(y_max) + 1)


def make_header_window(box: Box) -> HeaderWindow:
    """Return `box` as a window of an EXR header: its first and its last pixel."""
    return (
        np.array([box.x0, box.y0], dtype=np.int32),
        np.array([box.x1 - 1, box.y1 - 1], dtype=np.int32),
    )


def move_to_window(
    values: NDArray[Number], source: Box, target: Box, outside: float
) -> NDArray[Number]:
    """Return `values` (H, W) moved from window `source` to `target`, elsewhere `outside`."""
    moved: NDArray[Number] = np.full((target.height, target.width), outside, dtype=values.dtype)
    shared = source.intersection(target)
    if not shared.is_empty:
        moved[shared.relative_to(target).slices] = values[shared.relative_to(source).slices]
    return moved


def resize_nearest(values: FloatImage, shape: tuple[int, ...]) -> FloatImage:
    """Resize `values` (H, W) by the nearest pixel: a mean of two depths lies on no surface."""
    rows = ((np.arange(shape[0]) + 0.5) * values.shape[0] / shape[0]).astype(np.intp)
    columns = ((np.arange(shape[1]) + 0.5) * values.shape[1] / shape[1]).astype(np.intp)
    resized: FloatImage = np.ascontiguousarray(values[rows[:, None], columns[None, :]])
    return resized


def pixel_aspect_of(path: Path, header: Header) -> tuple[float, tuple[str, ...]]:
    """Return the aspect ratio of a pixel; 1 with a note if the header has no valid value."""
    aspect = float(header.get("pixelAspectRatio", 1.0))
    if 0 < aspect < math.inf:
        return aspect, ()
    return 1.0, (
        f"{path} has an invalid pixel aspect ratio of {aspect:g}: its pixels are taken as square.",
    )
