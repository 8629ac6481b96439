"""Whether another frame and its camera belong to this view: told by depth and by light."""

import numpy as np

from heatlens.plate.neighbours.look import Flags
from heatlens.plate.neighbours.moved import Arrived, Canvas
from heatlens.plate.neighbours.view import View
from heatlens.plate.plate import FloatImage

_SAME_DEPTH = 0.02
_LEAST_SHARED = 0.3  # of the pixels that both frames see, those with the same depth
_BETTER = 0.85  # times the difference of light without the camera's move, or beside it
_ASIDE_PX = 2
_NO_MOVE = 0.001  # of the depth
_LEAST_STILL = 0.8  # of what is far, by a camera that stands
_TELLING = 400  # pixels from which light can be judged
_STEP = 3  # every so many rows and columns are asked


def size_reason(here: View, other: View) -> str:
    """Return why the two pictures cannot be compared; empty if they can."""
    if not (here.plate.has_distances and other.plate.has_distances):
        return "it holds circles of confusion and no distances."
    mine, its = here.plate.display_window, other.plate.display_window
    if mine.shape != its.shape:
        return f"it is {its.width}x{its.height}, this frame {mine.width}x{mine.height}."
    return ""


def doubt(here: View, arrived: Arrived, canvas: Canvas) -> str:
    """Return why the frame cannot be of the same shot, or its camera wrong; empty if neither."""
    every = np.s_[::_STEP, ::_STEP]
    pixel, is_over = arrived.over(canvas)
    pixel, is_over = pixel[every], is_over[every]
    depth_m, its_m = canvas.front_m.ravel()[pixel], arrived.z[every]
    is_seen = is_over & (its_m < depth_m * np.float32(1 + _SAME_DEPTH))
    is_same = is_seen & (its_m > depth_m * np.float32(1 - _SAME_DEPTH))
    if is_same.sum() < _LEAST_SHARED * is_seen.sum() or not is_seen.any():
        return "its depths and those of this frame do not agree: another shot, or a wrong camera."
    if _is_light_explained(here, arrived, canvas, is_same):
        return ""
    return (
        "its camera explains the picture no better than a camera that stands still, so that it is "
        "wrong: check its unit, its axes and the frame it belongs to."
    )


def _is_light_explained(
    here: View, arrived: Arrived, canvas: Canvas, is_same: Flags, aside_px: int = _ASIDE_PX
) -> bool:
    """Return False if light differs less without the camera's move, or a little beside it."""
    every = np.s_[::_STEP, ::_STEP]
    light = _light(arrived.look.view.plate.color)
    detail = (
        np.abs(light - np.roll(light, 1, 1))[every] + np.abs(light - np.roll(light, 1, 0))[every]
    )
    left, top = arrived.look.view.corner
    x, y = arrived.x[every], arrived.y[every]
    rows, columns = np.mgrid[: light.shape[0] : _STEP, : light.shape[1] : _STEP].astype(np.float32)
    still_x, still_y = columns + np.float32(left + 0.5), rows + np.float32(top + 0.5)
    has_moved = is_same & (np.hypot(x - still_x, y - still_y) > 1)
    its, mine = light[every], _light(here.plate.color)

    def difference(told: Flags, at_x: FloatImage, at_y: FloatImage) -> float:
        told = told & (detail >= np.median(detail[told]))
        return float(np.median(np.abs(_sampled(mine, at_x[told], at_y[told], canvas) - its[told])))

    if has_moved.sum() > _TELLING:
        still = difference(has_moved, still_x, still_y)
        if difference(has_moved, x, y) > _BETTER * still:
            return False
    steps = ((aside_px, 0), (-aside_px, 0), (0, aside_px), (0, -aside_px))
    aside = min(difference(is_same, x + right, y + down) for right, down in steps)
    return difference(is_same, x, y) <= _BETTER * aside


def stands_still(here: View, arrived: Arrived, canvas: Canvas) -> bool:
    """Return True if the far half is the same in depth and light: seen by a camera that stands.

    What came nearer, as someone who walks in, does not count.
    """
    is_far = (canvas.front_m >= np.median(canvas.front_m)) & (arrived.z >= canvas.front_m * 0.9)
    is_same = np.abs(arrived.z - canvas.front_m) <= _NO_MOVE * canvas.front_m
    if (is_same & is_far).sum() < _LEAST_STILL * is_far.sum() or not is_far.any():
        return False
    return _is_light_explained(here, arrived, canvas, is_same[::_STEP, ::_STEP], 1)


def _light(color: FloatImage) -> FloatImage:
    """Return light (H, W) in stops, so that dark and bright count alike."""
    light: FloatImage = np.log2(np.maximum(color[..., :3].sum(-1), 0) + np.float32(0.02))
    return light


def _sampled(light: FloatImage, x: FloatImage, y: FloatImage, canvas: Canvas) -> FloatImage:
    """Return light between pixels, linearly."""
    height, width = light.shape
    left, top = canvas.corner
    column = np.clip(x - np.float32(left + 0.5), 0, width - 1.001)
    row = np.clip(y - np.float32(top + 0.5), 0, height - 1.001)
    c, r = column.astype(np.int32), row.astype(np.int32)
    right, down = column - c, row - r
    upper = light[r, c] * (1 - right) + light[r, c + 1] * right
    lower = light[r + 1, c] * (1 - right) + light[r + 1, c + 1] * right
    sampled: FloatImage = upper * (1 - down) + lower * down
    return sampled
