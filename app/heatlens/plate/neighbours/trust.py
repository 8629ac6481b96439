"""Check by depth and brightness whether another frame and its camera belong to this view."""

from dataclasses import dataclass

import numpy as np

from heatlens.plate.neighbours.look import Flags
from heatlens.plate.neighbours.moved import Arrived, Canvas
from heatlens.plate.neighbours.view import View
from heatlens.plate.plate import FloatImage

_SAME_DEPTH = 0.02
_LEAST_SHARED = 0.3  # least share of common pixels with the same depth
_BETTER = 0.85  # ratio to the difference without the camera's movement, or with a shift
_ALIKE = 0.0003  # stops; smaller differences say nothing about the camera
_ASIDE_PX = 2
_NO_MOVE = 0.001  # relative change of depth that counts as none
_LEAST_STILL = 0.8  # least unchanged share of the far half, if the camera stands still
_TELLING = 400  # least number of pixels to compare
_ASKED = 20_000  # evenly spaced pixels that are compared


def size_reason(here: View, other: View) -> str:
    """Return why the two pictures cannot be compared; "" if they can."""
    if not (here.plate.has_distances and other.plate.has_distances):
        return "it holds circles of confusion and no distances."
    mine, its = here.plate.display_window, other.plate.display_window
    if mine.shape != its.shape:
        return f"it is {its.width}x{its.height}, this frame {mine.width}x{mine.height}."
    return ""


def doubt(here: View, arrived: Arrived, canvas: Canvas) -> str:
    """Return why the frame is from another shot, or its camera is wrong; "" if neither."""
    asked = _asked(here, arrived, canvas)
    is_seen = asked.z < asked.front_m * np.float32(1 + _SAME_DEPTH)
    is_same = is_seen & (asked.z > asked.front_m * np.float32(1 - _SAME_DEPTH))
    if is_same.sum() <= _LEAST_SHARED * is_seen.sum():
        return "its depths and those of this frame do not agree: another shot, or a wrong camera."
    if _is_light_explained(asked, is_same, _ASIDE_PX):
        return ""
    return (
        "its camera fits the picture no better than a static camera, so it must be wrong: check "
        "its unit, its axes and the frame it belongs to."
    )


def stands_still(here: View, arrived: Arrived, canvas: Canvas) -> bool:
    """Return True if the camera did not move: the far half has the same depth and brightness.

    Pixels where something came nearer, such as a person walking in, are ignored.
    """
    asked = _asked(here, arrived, canvas)
    is_far = (asked.front_m >= np.median(canvas.front_m)) & (asked.z >= asked.front_m * 0.9)
    is_same = np.abs(asked.z - asked.front_m) <= _NO_MOVE * asked.front_m
    if (is_same & is_far).sum() <= _LEAST_STILL * is_far.sum():
        return False
    return _is_light_explained(asked, is_same, 1)


@dataclass(frozen=True, eq=False)
class _Asked:
    """Pixels (N,) of a frame that are compared with this view's picture.

    light            in stops
    detail           how much that differs from the pixels beside
    still_x, still_y where they are in their own picture, in pixels of the data window
    x, y, z          where they have moved, in the data window of this view, and their depth
    front_m          the depth that is seen there
    mine             the picture of this view
    """

    light: FloatImage
    detail: FloatImage
    still_x: FloatImage
    still_y: FloatImage
    x: FloatImage
    y: FloatImage
    z: FloatImage
    front_m: FloatImage
    mine: FloatImage

    def difference(self, told: Flags, x: FloatImage, y: FloatImage) -> float:
        """Return the median difference of brightness, in stops, with `told` pixels at x and y."""
        told = told & (self.detail >= np.median(self.detail[told]))
        there = _light(_sampled(self.mine, x[told], y[told]))
        return float(np.median(np.abs(there - self.light[told])))


def _asked(here: View, arrived: Arrived, canvas: Canvas) -> _Asked:
    height, width = arrived.z.shape
    step = max(1, round(np.sqrt(height * width / _ASKED)))
    every = np.s_[: height - 1 : step, : width - 1 : step]
    right, below = (
        np.s_[: height - 1 : step, 1:width:step],
        np.s_[1:height:step, : width - 1 : step],
    )
    some = Arrived(arrived.look, arrived.x[every], arrived.y[every], arrived.z[every])
    pixel, is_over = some.over(canvas)
    color = arrived.look.view.plate.color
    light = _light(color[every])
    detail = np.abs(light - _light(color[right])) + np.abs(light - _light(color[below]))
    rows, columns = np.mgrid[every].astype(np.float32) + np.float32(0.5)
    (left, top), (its_left, its_top) = canvas.corner, arrived.look.view.corner
    return _Asked(
        light[is_over],
        detail[is_over],
        columns[is_over] + (its_left - left),
        rows[is_over] + (its_top - top),
        some.x[is_over] - np.float32(left),
        some.y[is_over] - np.float32(top),
        some.z[is_over],
        canvas.front_m.ravel()[pixel[is_over]],
        here.plate.color,
    )


def _is_light_explained(asked: _Asked, is_same: Flags, aside_px: int) -> bool:
    """Return False if brightness fits better without the camera's movement, or with a shift."""
    x, y = asked.x, asked.y
    has_moved = is_same & (np.hypot(x - asked.still_x, y - asked.still_y) > 1)
    if has_moved.sum() > _TELLING:
        still = asked.difference(has_moved, asked.still_x, asked.still_y)
        if asked.difference(has_moved, x, y) > max(_BETTER * still, _ALIKE):
            return False
    steps = ((aside_px, 0), (-aside_px, 0), (0, aside_px), (0, -aside_px))
    aside = min(asked.difference(is_same, x + right, y + down) for right, down in steps)
    return asked.difference(is_same, x, y) <= max(_BETTER * aside, _ALIKE)


def _light(color: FloatImage) -> FloatImage:
    """Return brightness in stops, so that dark and bright pixels count alike."""
    light: FloatImage = np.log2(np.maximum(color[..., :3].sum(-1), 0) + np.float32(0.02))
    return light


def _sampled(color: FloatImage, x: FloatImage, y: FloatImage) -> FloatImage:
    """Return linearly interpolated colours (N, C) of a picture."""
    height, width = color.shape[:2]
    column = np.clip(x - np.float32(0.5), 0, width - np.float32(1.001))
    row = np.clip(y - np.float32(0.5), 0, height - np.float32(1.001))
    c, r = column.astype(np.int32), row.astype(np.int32)
    right, down = (column - c)[:, None], (row - r)[:, None]
    upper = color[r, c] * (1 - right) + color[r, c + 1] * right
    lower = color[r + 1, c] * (1 - right) + color[r + 1, c + 1] * right
    sampled: FloatImage = upper * (1 - down) + lower * down
    return sampled
