"""Choose the neighbouring frames to read: those that show enough of what is hidden here.

Depth and brightness tell whether another frame and its camera belong to this view.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from heatlens.media.plate.neighbours.moved import Arrived, Canvas, arrived_in, canvas_of
from heatlens.media.plate.neighbours.view import Flags, FloatMatrix, View, look_of
from heatlens.media.plate.plate import FloatImage, Plate

_SAME_DEPTH = 0.02
_LEAST_SHARED = 0.3  # least share of common pixels with the same depth
_BETTER = 0.85  # ratio to the difference without the camera's movement, or with a shift
_ALIKE = 0.0003  # stops; smaller differences say nothing about the camera
_ASIDE_PX = 2
_NO_MOVE = 0.001  # relative change of depth that counts as none
_LEAST_STILL = 0.8  # least unchanged share of the far half, if the camera stands still
_TELLING = 400  # least number of pixels to compare
_ASKED = 20_000  # evenly spaced pixels that are compared
_UNCOVERED = 1 / 16  # share of the width that the frames on one side should uncover
_BORDER = 1 / 48  # share of the width; a border three times as wide was no better
_STEP_MOST = 24  # frames
_STANDING_REACH = 16  # for a static camera: enough time for a person to walk on


def size_reason(here: View, other: View) -> str:
    """Return why the two pictures cannot be compared; "" if they can."""
    if not (here.plate.has_distances and other.plate.has_distances):
        return "it holds circles of confusion and no distances."
    mine, its = here.plate.display_window, other.plate.display_window
    if mine.shape != its.shape:
        return f"it is {its.width}x{its.height}, this frame {mine.width}x{mine.height}."
    return ""


# A frame of another shot, or a camera in feet or with its axes swapped, would put wrong surfaces
# behind every edge. Depth tells another shot. A wrong camera may still agree in depth, so light has
# to agree as well: the movement must explain the picture better than no movement does, and better
# than the same movement shifted by two pixels.
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

    def difference(self, chosen: Flags, x: FloatImage, y: FloatImage) -> float:
        """Return the median difference of brightness, in stops, with `chosen` pixels at x and y."""
        chosen = chosen & (self.detail >= np.median(self.detail[chosen]))
        there = _light(_sampled(self.mine, x[chosen], y[chosen]))
        return float(np.median(np.abs(there - self.light[chosen])))


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


# If each frame chose its own neighbours by distance, all of them would change from frame to frame,
# and what they uncover would flicker; on a grid that all frames share, one frame enters and one
# leaves.
def chosen_frames(
    frame: int, available: Collection[int], count: int, step: int = 1
) -> tuple[int, ...]:
    """Return `count` frames on either side of `frame`, or the same total if one side has fewer.

    All frames of a shot choose from the same frames, one in every `step`, so that the set
    changes by one from frame to frame, and each file is used by many frames.
    """
    first_of = {other // step: other for other in sorted(available, reverse=True)}
    others = [other for other in first_of.values() if other != frame]
    nearest = sorted(others, key=lambda other: (abs(other - frame), other))
    return tuple(sorted(nearest[: 2 * count]))


# A slow dolly uncovers nothing in one frame, so neighbours are taken a step apart. The step belongs
# to the shot and not to the frame, and is the same whichever plate is asked: a step that changed
# within the shot would change the grid of `chosen_frames`.
def step_of(cameras: Mapping[int, FloatMatrix], plate: Plate, focal_px: float, count: int) -> int:
    """Return the interval, in frames, between the chosen frames of a shot.

    `cameras` are world-to-camera matrices by frame, empty for a static camera; `plate` is any plate
    of the shot, always the same. The slower the camera, the larger the interval at which frames
    show something new.
    """
    frames = sorted(cameras)
    if len(frames) < 2:
        return max(1, _STANDING_REACH // count)
    span = frames[-1] - frames[0]
    moves = [cameras[b][:3] @ np.linalg.inv(cameras[a])[:, 3] for a, b in pairwise(frames)]
    width = plate.display_window.width
    reach_px = np.array([focal_px, focal_px, width / 4])  # a forward movement enlarges near objects
    path_px = np.abs(np.array(moves) @ np.diag(reach_px)).sum() * _between_dioptres(plate)
    if not path_px > 0:
        return max(1, _STANDING_REACH // count)
    step = round(float(width * _UNCOVERED / (count * path_px / span)))
    return max(1, min(step, _STEP_MOST, span // (2 * count)))


def border_px(plate: Plate) -> int:
    """Return the width of the border to find; beyond it, the blur repeats the last pixels."""
    return max(1, round(_BORDER * plate.display_window.width))


def _between_dioptres(plate: Plate) -> float:
    """Return the distance between near and far surfaces in dioptres."""
    bins = plate.seen_bins
    share = np.cumsum(bins.counts) / max(1, bins.counts.sum())
    far, near = np.interp((0.1, 0.9), share, bins.middles)
    return float(near - far)


def standing(a: Plate, b: Plate) -> bool:
    """Return True if the camera did not move between two plates: distant pixels are the same.

    Compare plates that lie far apart: a slow camera hardly moves from one frame to the next.
    """
    first, second = (View(k, plate, np.eye(4), (1, 1), (0, 0)) for k, plate in enumerate((a, b)))
    if size_reason(first, second) or a.data_window != b.data_window:
        return False
    return stands_still(first, arrived_in(first, look_of(second)), canvas_of(first))
