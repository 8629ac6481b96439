"""Find the places of a picture at which the methods differ most."""

import numpy as np
import numpy.typing as npt

from heatlens.measure.compare.metrics import flip_evaluation
from heatlens.model.boxes import Box
from heatlens.plate.picture.display import srgb_encoded
from heatlens.plate.plate import FloatImage

CROPS = 3
_SHARE = 0.22  # of the shorter side of the picture
_SIDE_MIN_PX, _SIDE_MAX_PX = 16, 160


def crop_boxes(pictures: list[FloatImage], reference: FloatImage, count: int = CROPS) -> list[Box]:
    """Return up to `count` squares that do not touch, the most telling first.

    `pictures` and `reference` are scene-linear (H, W, 3). The most telling place is where the
    errors of the best and the worst picture differ most; with one picture, where its error is
    largest.
    """
    side = crop_side(*reference.shape[:2])
    sums = _box_sums(_telling(pictures, reference), side)
    boxes: list[Box] = []
    while len(boxes) < count and np.isfinite(sums).any():
        y, x = (int(i) for i in np.unravel_index(int(np.argmax(sums)), sums.shape))
        boxes.append(Box(x, y, x + side, y + side))
        apart = side + side // 2  # neighbours would show the same thing twice
        sums[max(0, y - apart) : y + apart, max(0, x - apart) : x + apart] = -np.inf
    return boxes


def crop_side(height: int, width: int) -> int:
    """Return the side of a crop in pixels, never more than the picture has."""
    side = min(_SIDE_MAX_PX, max(_SIDE_MIN_PX, round(_SHARE * min(height, width))))
    return min(side, height, width)


def flip_inside(picture: FloatImage, reference: FloatImage, box: Box) -> float:
    """Mean FLIP of a crop as a picture of its own, 0 the same to 1 worst; both (H, W, 3)."""
    rows, columns = slice(box.y0, box.y1), slice(box.x0, box.x1)
    shown, shown_truth = (srgb_encoded(p[rows, columns]) for p in (picture, reference))
    return float(flip_evaluation(shown, shown_truth, "LDR")[1])


def _telling(pictures: list[FloatImage], reference: FloatImage) -> npt.NDArray[np.float64]:
    """Return (H, W): the worst error minus the best error of each pixel's display value."""
    shown = srgb_encoded(reference)
    errors = np.stack([np.abs(srgb_encoded(p) - shown).mean(axis=2) for p in pictures])
    least = errors.min(axis=0) if len(pictures) > 1 else 0.0
    return np.asarray(errors.max(axis=0) - least, np.float64)


def _box_sums(values: npt.NDArray[np.float64], side: int) -> npt.NDArray[np.float64]:
    """Sum over the square that begins at each pixel; summed-area table, Crow 1984."""
    table = np.pad(values, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    return np.asarray(
        table[side:, side:] - table[:-side, side:] - table[side:, :-side] + table[:-side, :-side]
    )
