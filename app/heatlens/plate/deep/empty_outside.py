"""Widen plates with alpha to their display window: in EXR, pixels outside the data are empty."""

from dataclasses import replace

import numpy as np

from heatlens.model.boxes import Box
from heatlens.plate.deep.stacked import Stacked, lists_over
from heatlens.plate.plate import DepthReport, FloatImage, Plate, ReadPixels
from heatlens.plate.windows import moved_to_window

# A header may claim any display window without further bytes. For a file with few pixels, a frame
# of 8K is enough, and takes a gigabyte of memory.
_EMPTY_MOST = 8192 * 4320
_OF_DATA_MOST = 4  # times the data window, whose pixels the file must contain


def window_of_all(data: Box, display: Box) -> Box:
    """Return the box around both windows; `data` alone where such a picture would be too large."""
    if display.is_empty:
        return data
    both = data.union(display)
    most = max(_EMPTY_MOST, _OF_DATA_MOST * data.width * data.height)
    return both if both.width * both.height <= most else data


def with_empty_outside(plate: Plate) -> Plate:
    """Return a plate with alpha over both of its windows; added pixels have no light or surfaces.

    Renderers cut the data window to the box around an element, so that its edges could not blur
    beyond that box. A plate without alpha stays as it is, because its surroundings are unknown.
    """
    source, target = plate.data_window, window_of_all(plate.data_window, plate.display_window)
    if not plate.has_alpha or source == target:
        return plate
    color = _color_over(plate.color, source, target)
    if plate.coc_px is not None:
        pixels = ReadPixels(color, coc_px=_coc_over(plate.coc_px, source, target))
        return replace(plate, pixels=pixels, data_window=target)
    assert plate.depth_m is not None
    depth_m = moved_to_window(plate.depth_m, source, target, np.inf)
    added = depth_m.size - plate.depth_m.size
    pixels = ReadPixels(color, depth_m)
    return replace(plate, pixels=pixels, data_window=target, depth=_with_empty(plate.depth, added))


def stacked_over(made: Stacked, source: Box, target: Box) -> Stacked:
    """Return the picture of deep samples over `target`; it has no surfaces outside `source`."""
    if source == target:
        return made
    lists = None if made.lists is None else lists_over(made.lists, source, target)
    depth_m = moved_to_window(made.depth_m, source, target, np.inf)
    return replace(
        made, color=_color_over(made.color, source, target), depth_m=depth_m, lists=lists
    )


def _color_over(color: FloatImage, source: Box, target: Box) -> FloatImage:
    planes = [moved_to_window(color[..., k], source, target, 0.0) for k in range(color.shape[2])]
    return np.stack(planes, axis=-1)


def _coc_over(coc_px: FloatImage, source: Box, target: Box) -> FloatImage:
    """Return circles of confusion over `target`; empty pixels are as far as the farthest pixel.

    Any nearer, it would hide the blur of surfaces behind it.
    """
    return moved_to_window(coc_px, source, target, float(coc_px.max()))


def _with_empty(report: DepthReport, added: int) -> DepthReport:
    return replace(report, infinite_count=report.infinite_count + added)
