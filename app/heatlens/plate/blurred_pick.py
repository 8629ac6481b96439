"""Find what is seen at a pixel through the lens: also something near whose blur lies over it."""

from dataclasses import dataclass

import numpy as np

from heatlens.model.boxes import Box
from heatlens.model.focus.coc import coc_px
from heatlens.model.lens.lens import Lens
from heatlens.plate.coc_line import line_of
from heatlens.plate.focus_pick import depth_at_m
from heatlens.plate.plate import Plate

_REACH = (2, 96)  # px: a smaller blur hides nothing; a larger one is looked at up to here
_APART = 1.05  # ratio of depths from which one thing lies in front of another
_SHOWN, _COVERS = 0.1, 0.5  # shares of the light from which a near thing is told, and is meant


@dataclass(frozen=True)
class Surface:
    """Something at a pixel: a pixel (x, y) in which the plate shows it, and how far it is."""

    x: int
    y: int
    depth_m: float


def surfaces_at(plate: Plate, lens: Lens, x: int, y: int) -> tuple[Surface, ...]:
    """Return what is seen at pixel (x, y) of the display window through a lens, in order.

    The first one gives most of the light: that of the pixel itself, or something near whose blur
    covers the pixel. Raises InputError as `depth_at_m` does.
    """
    own = Surface(x, y, depth_at_m(plate, x, y))
    near = _near(plate, lens, own)
    if near is None:
        return (own,)
    surface, share = near
    return (surface, own) if share >= _COVERS else (own, surface)


def _near(plate: Plate, lens: Lens, own: Surface) -> tuple[Surface, float] | None:
    """Return the nearer thing that blurs over a pixel, and its share of the light there."""
    line = line_of(plate, lens)
    widest = abs(float(coc_px(plate.depth.near_m, line))) / 2 if plate.depth.near_m > 0 else 0.0
    reach = int(min(widest, _REACH[1]))
    if not reach >= _REACH[0]:
        return None
    shown, data = plate.display_window, plate.data_window
    column, row = own.x + shown.x0 - data.x0, own.y + shown.y0 - data.y0
    around = Box(column - reach, row - reach, column + reach + 1, row + reach + 1)
    area = around.intersection(Box(0, 0, data.width, data.height))
    depth_m = plate.pixels.depth_in(area).astype(np.float64)
    rows, columns = np.mgrid[area.y0 : area.y1, area.x0 : area.x1]
    away = np.hypot(columns - column, rows - row)
    radius = -coc_px(depth_m, line) / 2
    covers = (depth_m * _APART < own.depth_m) & (radius >= _REACH[0]) & (radius >= away)
    share = float((1.0 / (np.pi * radius[covers] ** 2)).sum())
    if share < _SHOWN:
        return None
    middle = float(np.median(depth_m[covers]))
    is_like = np.maximum(depth_m / middle, middle / depth_m) < _APART
    inside = np.lib.stride_tricks.sliding_window_view(np.pad(is_like, 2), (5, 5)).sum((2, 3))
    at = np.argmin(np.where(is_like, away - np.where(inside > 12, 2.0 * reach, 0.0), np.inf))
    x, y = int(columns.flat[at] - shown.x0 + data.x0), int(rows.flat[at] - shown.y0 + data.y0)
    return Surface(x, y, middle), min(share, 1.0)
