"""Choose the neighbouring frames to read: those that show enough of what is hidden here."""

from collections.abc import Collection, Mapping
from itertools import pairwise

import numpy as np

from heatlens.plate.neighbours.look import look_of
from heatlens.plate.neighbours.moved import arrived_in, canvas_of
from heatlens.plate.neighbours.trust import size_reason, stands_still
from heatlens.plate.neighbours.view import FloatMatrix, View
from heatlens.plate.plate import Plate

_UNCOVERED = 1 / 16  # share of the width that the frames on one side should uncover
_BORDER = 1 / 48  # share of the width; a border three times as wide was no better
_STEP_MOST = 24  # frames
_STANDING_REACH = 16  # for a static camera: enough time for a person to walk on


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
