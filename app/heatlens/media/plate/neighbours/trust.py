"""Choose the neighboring frames to read: those that show enough hidden surfaces of this frame.

Depth and brightness are compared to test whether another frame and its camera belong to this view.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from heatlens.media.plate.neighbours.moved import Canvas, MovedFrame, canvas_of, move_into_view
from heatlens.media.plate.neighbours.view import Flags, FloatMatrix, View, prepare_neighbor
from heatlens.media.plate.plate import FloatImage, Plate

_SAME_DEPTH = 0.02  # relative difference
_LEAST_SHARED = 0.3  # least share of common pixels with the same depth
_BETTER = 0.85  # least gain: ratio to the difference without the camera's movement, or shifted
_SAME_LIGHT = 0.0003  # stops; smaller differences say nothing about the camera
_SHIFT_PX = 2  # shift with which a wrong camera is tested
_NO_MOVE = 0.001  # relative change of depth that counts as none
_LEAST_STILL = 0.8  # least unchanged share of the far half, if the camera stands still
_PIXELS_LEAST = 400  # least number of pixels to compare
_PIXELS_COMPARED = 20_000  # evenly spaced pixels that are compared
_UNCOVERED = 1 / 16  # share of the width that the frames on one side should uncover
_BORDER = 1 / 48  # share of the width; a border three times as wide was no better
_STEP_MOST = 24  # largest interval between chosen frames
_STATIC_REACH = 16  # frames to either side for a static camera: time for a person to walk on


def size_reason(view: View, other_view: View) -> str:
    """Return a sentence on why two pictures cannot be compared; "" if they can."""
    if not (view.plate.has_distances and other_view.plate.has_distances):
        return "it holds circles of confusion and no distances."
    view_window, other_window = view.plate.display_window, other_view.plate.display_window
    if view_window.shape != other_window.shape:
        return (
            f"it is {other_window.width}x{other_window.height}, this frame "
            f"{view_window.width}x{view_window.height}."
        )
    return ""


# Different depths show that a frame is from another shot. A wrong camera, such as one in feet or
# with its axes swapped, may still agree in depth, so the light has to agree as well: the camera's
# movement must explain the picture better than no movement, and better than the same movement
# shifted by two pixels. Such frames would put wrong surfaces behind every edge.
def doubt_reason(view: View, moved_frame: MovedFrame, canvas: Canvas) -> str:
    """Return a sentence if the frame is from another shot or its camera is wrong; else ""."""
    compared = _compare_pixels(view, moved_frame, canvas)
    is_seen = compared.z < compared.front_m * np.float32(1 + _SAME_DEPTH)
    is_same = is_seen & (compared.z > compared.front_m * np.float32(1 - _SAME_DEPTH))
    if is_same.sum() <= _LEAST_SHARED * is_seen.sum():
        return "its depths and those of this frame do not agree: another shot, or a wrong camera."
    if _is_light_explained(compared, is_same, shift_px=_SHIFT_PX):
        return ""
    return (
        "its camera fits the picture no better than a static camera, so it must be wrong: check "
        "its unit, its axes and the frame it belongs to."
    )


def is_static_view(view: View, moved_frame: MovedFrame, canvas: Canvas) -> bool:
    """Return True if the camera did not move: the far half has the same depth and brightness.

    Pixels where something came nearer, such as a person walking in, are ignored.
    """
    compared = _compare_pixels(view, moved_frame, canvas)
    is_far = (compared.front_m >= np.median(canvas.front_m)) & (
        compared.z >= compared.front_m * 0.9
    )
    is_same = np.abs(compared.z - compared.front_m) <= _NO_MOVE * compared.front_m
    if (is_same & is_far).sum() <= _LEAST_STILL * is_far.sum():
        return False
    return _is_light_explained(compared, is_same, shift_px=1)


@dataclass(frozen=True, eq=False)
class _ComparedPixels:
    """Pixels (N,) of a frame that are compared with this view's picture.

    light             brightness in stops
    detail            difference of brightness to the neighboring pixels
    still_x, still_y  positions without movement, in the data window of this view
    x, y, z           positions moved into this view, in its data window, and depths
    front_m           depth of this view at the moved positions
    view_color        the picture (H, W, C) of this view
    """

    light: FloatImage
    detail: FloatImage
    still_x: FloatImage
    still_y: FloatImage
    x: FloatImage
    y: FloatImage
    z: FloatImage
    front_m: FloatImage
    view_color: FloatImage

    def difference(self, is_chosen: Flags, x: FloatImage, y: FloatImage) -> float:
        """Return the median difference of brightness, in stops, with this view's picture.

        The pixels of `is_chosen` are compared at the positions `x` and `y`.
        """
        is_chosen = is_chosen & (self.detail >= np.median(self.detail[is_chosen]))
        shown_light = _brightness_stops(
            _interpolate_color(self.view_color, x[is_chosen], y[is_chosen])
        )
        return float(np.median(np.abs(shown_light - self.light[is_chosen])))


def _compare_pixels(view: View, moved_frame: MovedFrame, canvas: Canvas) -> _ComparedPixels:
    """Return evenly spaced pixels of the moved frame, and the pixels of this view to compare."""
    height, width = moved_frame.z.shape
    step = max(1, round(np.sqrt(height * width / _PIXELS_COMPARED)))
    grid = np.s_[: height - 1 : step, : width - 1 : step]
    right = np.s_[: height - 1 : step, 1:width:step]
    lower = np.s_[1:height:step, : width - 1 : step]
    samples = MovedFrame(
        moved_frame.neighbor, moved_frame.x[grid], moved_frame.y[grid], moved_frame.z[grid]
    )
    pixel, is_over = samples.pixels_on(canvas)
    color = moved_frame.neighbor.view.plate.color
    light = _brightness_stops(color[grid])
    detail = np.abs(light - _brightness_stops(color[right])) + np.abs(
        light - _brightness_stops(color[lower])
    )
    rows, columns = np.mgrid[grid].astype(np.float32) + np.float32(0.5)
    (left, top), (frame_left, frame_top) = canvas.corner, moved_frame.neighbor.view.corner
    return _ComparedPixels(
        light=light[is_over],
        detail=detail[is_over],
        still_x=columns[is_over] + (frame_left - left),
        still_y=rows[is_over] + (frame_top - top),
        x=samples.x[is_over] - np.float32(left),
        y=samples.y[is_over] - np.float32(top),
        z=samples.z[is_over],
        front_m=canvas.front_m.ravel()[pixel[is_over]],
        view_color=view.plate.color,
    )


def _is_light_explained(compared: _ComparedPixels, is_same: Flags, shift_px: int) -> bool:
    """Return False if brightness fits better without the camera's movement, or with a shift."""
    x, y = compared.x, compared.y
    has_moved = is_same & (np.hypot(x - compared.still_x, y - compared.still_y) > 1)
    if has_moved.sum() > _PIXELS_LEAST:
        static_difference = compared.difference(has_moved, compared.still_x, compared.still_y)
        if compared.difference(has_moved, x, y) > max(_BETTER * static_difference, _SAME_LIGHT):
            return False
    steps = ((shift_px, 0), (-shift_px, 0), (0, shift_px), (0, -shift_px))
    shifted_difference = min(
        compared.difference(is_same, x + right, y + down) for right, down in steps
    )
    return compared.difference(is_same, x, y) <= max(_BETTER * shifted_difference, _SAME_LIGHT)


def _brightness_stops(color: FloatImage) -> FloatImage:
    """Return brightness in stops: doubling the light adds 1, for dark and bright pixels alike."""
    light: FloatImage = np.log2(np.maximum(color[..., :3].sum(-1), 0) + np.float32(0.02))
    return light


def _interpolate_color(color: FloatImage, x: FloatImage, y: FloatImage) -> FloatImage:
    """Return linearly interpolated colors (N, C) of a picture."""
    height, width = color.shape[:2]
    column = np.clip(x - np.float32(0.5), 0, width - np.float32(1.001))
    row = np.clip(y - np.float32(0.5), 0, height - np.float32(1.001))
    c, r = column.astype(np.int32), row.astype(np.int32)
    right, down = (column - c)[:, None], (row - r)[:, None]
    upper = color[r, c] * (1 - right) + color[r, c + 1] * right
    lower = color[r + 1, c] * (1 - right) + color[r + 1, c + 1] * right
    interpolated: FloatImage = upper * (1 - down) + lower * down
    return interpolated


# All frames choose their neighbors on one grid, so one neighbor enters and one leaves from frame
# to frame. If each frame chose neighbors by distance, all of them would change at once, and the
# uncovered surfaces would flicker.
def choose_frames(
    frame: int, available: Collection[int], count: int, step: int = 1
) -> tuple[int, ...]:
    """Return `count` frames on either side of `frame`, or the same total if one side has fewer.

    All frames of a shot choose from the same frames, one in every `step`. The set then changes by
    one from frame to frame, and each file is used by many frames.
    """
    first_by_step = {
        other_frame // step: other_frame for other_frame in sorted(available, reverse=True)
    }
    other_frames = [other_frame for other_frame in first_by_step.values() if other_frame != frame]
    nearest = sorted(other_frames, key=lambda other_frame: (abs(other_frame - frame), other_frame))
    return tuple(sorted(nearest[: 2 * count]))


# Neighbors are taken several frames apart, because a slow dolly uncovers nothing in one frame. The
# step is the same for all frames of a shot: a step that changed within the shot would change the
# grid of `choose_frames`.
def choose_frame_step(
    cameras: Mapping[int, FloatMatrix], plate: Plate, focal_px: float, count: int
) -> int:
    """Return the interval, in frames, between the chosen frames of a shot.

    `cameras` are world-to-camera matrices by frame, empty for a static camera; `plate` is any plate
    of the shot, always the same. The slower the camera, the larger the interval at which frames
    show something new.
    """
    frames = sorted(cameras)
    if len(frames) < 2:
        return max(1, _STATIC_REACH // count)
    span = frames[-1] - frames[0]
    moves = [cameras[b][:3] @ np.linalg.inv(cameras[a])[:, 3] for a, b in pairwise(frames)]
    width = plate.display_window.width
    reach_px = np.array([focal_px, focal_px, width / 4])  # a forward movement enlarges near objects
    path_px = np.abs(np.array(moves) @ np.diag(reach_px)).sum() * _depth_range_dioptres(plate)
    if not path_px > 0:
        return max(1, _STATIC_REACH // count)
    step = round(float(width * _UNCOVERED / (count * path_px / span)))
    return max(1, min(step, _STEP_MOST, span // (2 * count)))


def border_px(plate: Plate) -> int:
    """Return the width of the border to find; beyond it, the blur repeats the last pixels."""
    return max(1, round(_BORDER * plate.display_window.width))


def _depth_range_dioptres(plate: Plate) -> float:
    """Return the distance between near and far surfaces in dioptres.

    These are the depths at 10 % and 90 % of the visible pixels, sorted by dioptres.
    """
    bins = plate.visible_bins
    share = np.cumsum(bins.counts) / max(1, bins.counts.sum())
    far, near = np.interp((0.1, 0.9), share, bins.middles)
    return float(near - far)


def is_static_between(a: Plate, b: Plate) -> bool:
    """Return True if the camera did not move between two plates: distant pixels are the same.

    Compare plates that lie far apart: a slow camera hardly moves from one frame to the next.
    """
    # With one camera for both, any focal length serves: no pixel moves between the two.
    first, second = (
        View(frame, plate, world_to_camera=np.eye(4), focal_px=(1, 1), centre_px=(0, 0))
        for frame, plate in enumerate((a, b))
    )
    if size_reason(first, second) or a.data_window != b.data_window:
        return False
    return is_static_view(first, move_into_view(first, prepare_neighbor(second)), canvas_of(first))
