"""A part of a plate as a tracker sees it: eight bits of light, colour and depth."""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.extras import import_extra
from heatlens.core.model.boxes import Box
from heatlens.media.plate.plate import FloatImage, Plate

ByteImage = NDArray[np.uint8]

_LUMA = np.array([0.2126, 0.7152, 0.0722], np.float32)
_LEVELS, _MIDDLE = 255.0, 127.5
_BESIDE_PX = 11  # width of the neighbourhood in which something nearer misleads the flow
_FARTHEST = np.float32(1e-9)  # dioptres of the sky, of which logarithms are taken
_DEPTH_OCTAVES = 6.0  # ratios of depth that eight bits span


@dataclass(frozen=True)
class Tones:
    """What all crops of a track have in common.

    white     the light that becomes the largest level
    dioptres  the place in depth that becomes the middle level
    """

    white: float
    dioptres: float


@dataclass(frozen=True)
class Crop:
    """A part of a plate; `image` (H, W, 3) holds light, colour and depth.

    `x0`, `y0` count pixels from the corner of the display window.
    """

    x0: int
    y0: int
    image: ByteImage
    dioptres: FloatImage

    def nearest(self) -> "Crop":
        """Return the crop with the nearest depth of the neighbourhood at each pixel."""
        cv2 = opencv()
        wide = cv2.dilate(self.dioptres, np.ones((_BESIDE_PX, _BESIDE_PX), np.uint8))
        return replace(self, dioptres=wide)

    def depth_at(self, points: FloatImage) -> FloatImage:
        """Return the dioptres at points (N, 2) of the crop; NaN outside of it."""
        columns, rows = np.rint(np.nan_to_num(points, nan=-1.0)).astype(np.int64).T
        height, width = self.dioptres.shape
        inside = (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
        dioptres = np.full(len(points), np.nan, np.float32)
        dioptres[inside] = self.dioptres[rows[inside], columns[inside]]
        return dioptres


def opencv() -> ModuleType:
    """Return the library that tracks. Raises InputError if it is not installed."""
    return import_extra("cv2")


def white_of(plate: Plate) -> float:
    """Return the light that nearly all of a plate is darker than."""
    return max(float(np.percentile(plate.color[::4, ::4, :3], 98)), 1e-6)


def crop_of(plate: Plate, box: Box, tones: Tones) -> Crop | None:
    """Return the part of a plate inside a box of display pixels; None where they do not meet."""
    data, display = plate.data_window, plate.display_window
    dx, dy = data.x0 - display.x0, data.y0 - display.y0
    shown = box.intersection(Box(dx, dy, dx + data.width, dy + data.height))
    if shown.width <= 0 or shown.height <= 0:
        return None
    area = Box(shown.x0 - dx, shown.y0 - dy, shown.x1 - dx, shown.y1 - dy)
    depth_m = np.maximum(plate.pixels.depth_in(area), np.float32(1e-6))
    dioptres = np.maximum(np.reciprocal(depth_m, dtype=np.float32), _FARTHEST)
    image = _image(plate.pixels.color_in(area)[..., :3], dioptres, tones)
    return Crop(shown.x0, shown.y0, image, dioptres)


def _image(color: FloatImage, dioptres: FloatImage, tones: Tones) -> ByteImage:
    light = np.log1p(15.0 * np.clip(np.nan_to_num(color) / tones.white, 0.0, 1.0)) / np.log(16.0)
    tint = _MIDDLE + _MIDDLE * (light[..., 0] - light[..., 2])
    ratio = np.log2(np.maximum(dioptres / tones.dioptres, np.float32(1e-3)))
    depth = _MIDDLE + _LEVELS * ratio / _DEPTH_OCTAVES
    stack = np.stack([_LEVELS * (light @ _LUMA), tint, depth], axis=-1)
    image: ByteImage = np.clip(stack, 0.0, _LEVELS).astype(np.uint8)
    return image


def moved_points(
    before: Crop, after: Crop, points: FloatImage, guess: tuple[float, float]
) -> tuple[FloatImage, FloatImage]:
    """Return where points (N, 2) of one crop are in another, and how far they miss on the way back.

    Pyramidal Lucas and Kanade, both ways. The crops have the same box. A point that is not found
    misses by infinity.
    """
    there = _flow(before.image, after.image, points, points + np.asarray(guess, np.float32))
    back = _flow(after.image, before.image, there, points)
    missed = np.linalg.norm(back - points, axis=1)
    return there, np.where(np.isfinite(missed), missed, np.inf).astype(np.float32)


def _flow(before: ByteImage, after: ByteImage, points: FloatImage, guess: FloatImage) -> FloatImage:
    is_there = np.asarray(np.isfinite(points).all(axis=1))
    start = np.where(is_there[:, None], points, np.float32(0.0)).astype(np.float32)
    cv2 = opencv()
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        start[:, None],
        guess.astype(np.float32)[:, None].copy(),
        winSize=(15, 15),
        maxLevel=3,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    is_found = is_there & (status[:, 0] == 1)
    return np.where(is_found[:, None], moved[:, 0], np.float32(np.nan)).astype(np.float32)
