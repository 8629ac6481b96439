"""Which neighbouring frames are worth reading: those from which a lens's width more is seen."""

from collections.abc import Collection, Mapping
from itertools import pairwise

import numpy as np

from heatlens.plate.neighbours.look import look_of
from heatlens.plate.neighbours.moved import arrived_in, canvas_of
from heatlens.plate.neighbours.trust import size_reason, stands_still
from heatlens.plate.neighbours.view import FloatMatrix, View
from heatlens.plate.plate import Plate

_UNCOVERED = 1 / 16  # of the width: the frames on one side should uncover about this much
_BORDER = 1 / 48  # of the width; three times as much made pictures no better
_STEP_MOST = 24  # frames
_STANDING_REACH = 16  # frames: whoever walks before a camera that stands has then gone on


def chosen_frames(
    frame: int, available: Collection[int], count: int, step: int = 1
) -> tuple[int, ...]:
    """Return `count` frames on either side of `frame`, as many in all where a side has fewer.

    All frames of a shot choose among the same ones, the first of each `step`, so that the set
    changes by one from frame to frame, and each file serves many.
    """
    first_of = {other // step: other for other in sorted(available, reverse=True)}
    others = [other for other in first_of.values() if other != frame]
    nearest = sorted(others, key=lambda other: (abs(other - frame), other))
    return tuple(sorted(nearest[: 2 * count]))


def step_of(cameras: Mapping[int, FloatMatrix], plate: Plate, focal_px: float, count: int) -> int:
    """Return how many frames of a shot lie between those that are chosen.

    `cameras` are world to camera by frame, empty for a camera that stands; `plate` is any plate
    of the shot, always the same. The slower the camera, the farther apart are frames that know
    more than each other.
    """
    frames = sorted(cameras)
    if len(frames) < 2:
        return max(1, _STANDING_REACH // count)
    span = frames[-1] - frames[0]
    moves = [cameras[b][:3] @ np.linalg.inv(cameras[a])[:, 3] for a, b in pairwise(frames)]
    width = plate.display_window.width
    reach_px = np.array([focal_px, focal_px, width / 4])  # forwards, near things grow
    path_px = np.abs(np.array(moves) @ np.diag(reach_px)).sum() * _between_dioptres(plate)
    if not path_px > 0:
        return max(1, _STANDING_REACH // count)
    step = round(float(width * _UNCOVERED / (count * path_px / span)))
    return max(1, min(step, _STEP_MOST, span // (2 * count)))


def border_px(plate: Plate) -> int:
    """Return how much is found around the frame: the blur repeats what lies farther out."""
    return max(1, round(_BORDER * plate.display_window.width))


def _between_dioptres(plate: Plate) -> float:
    """Return how far near and far surfaces lie apart, in dioptres."""
    bins = plate.seen_bins
    share = np.cumsum(bins.counts) / max(1, bins.counts.sum())
    far, near = np.interp((0.1, 0.9), share, bins.middles)
    return float(near - far)


def standing(a: Plate, b: Plate) -> bool:
    """Return True if the camera stood still between two plates: nothing far has moved.

    Compare plates that lie far apart: a slow camera hardly moves from one frame to the next.
    """
    first, second = (View(k, plate, np.eye(4), (1, 1), (0, 0)) for k, plate in enumerate((a, b)))
    if size_reason(first, second) or a.data_window != b.data_window:
        return False
    return stands_still(first, arrived_in(first, look_of(second)), canvas_of(first))
