"""Cut sections out of plates for the tracker: light, tint and depth in eight bits each."""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.extras import import_extra
from heatlens.core.model.boxes import Box
from heatlens.media.plate.plate import FloatImage, Plate

ByteImage = NDArray[np.uint8]

_LUMA = np.array([0.2126, 0.7152, 0.0722], np.float32)  # of red, green and blue in Rec. 709
_LEVELS, _MIDDLE_LEVEL = 255.0, 127.5
_NEIGHBOURHOOD_PX = 11  # width of the neighborhood in which something nearer misleads the flow
_DIOPTRES_LEAST = np.float32(1e-9)  # stands for the sky, because 0 has no logarithm
_DEPTH_OCTAVES = 6.0  # ratios of depth that eight bits span


@dataclass(frozen=True)
class Tones:
    """The scale of light and depth that all crops of a track share.

    white     the light that becomes the largest level
    dioptres  the depth that becomes the middle level
    """

    white: float
    dioptres: float


@dataclass(frozen=True)
class Crop:
    """A section of a plate.

    x0, y0    corner of the section in pixels from the corner of the display window
    image     (H, W, 3) light, tint and depth as `_encode_image` returns them
    dioptres  (H, W) 1 / depth in meters
    """

    x0: int
    y0: int
    image: ByteImage
    dioptres: FloatImage

    def with_nearest_depth(self) -> "Crop":
        """Return the crop with the nearest depth around each pixel in place of its own."""
        cv2 = import_opencv()
        nearest_dioptres = cv2.dilate(
            self.dioptres, np.ones((_NEIGHBOURHOOD_PX, _NEIGHBOURHOOD_PX), np.uint8)
        )
        return replace(self, dioptres=nearest_dioptres)

    def depth_at(self, points: FloatImage) -> FloatImage:
        """Return the dioptres at points (N, 2) of the crop; NaN outside of it."""
        columns, rows = np.rint(np.nan_to_num(points, nan=-1.0)).astype(np.int64).T
        height, width = self.dioptres.shape
        is_inside = (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
        dioptres = np.full(len(points), np.nan, np.float32)
        dioptres[is_inside] = self.dioptres[rows[is_inside], columns[is_inside]]
        return dioptres


def import_opencv() -> ModuleType:
    """Return the library that tracks. Raises InputError if it is not installed."""
    return import_extra("cv2")


def white_level(plate: Plate) -> float:
    """Return a light level that nearly all of a plate is darker than; it becomes white."""
    return max(float(np.percentile(plate.color[::4, ::4, :3], 98)), 1e-6)


def crop_of(plate: Plate, box: Box, tones: Tones) -> Crop | None:
    """Return the section of a plate inside a box of display pixels; None if they do not overlap."""
    data = plate.data_window.relative_to(plate.display_window)
    overlap = box.intersection(data)
    if overlap.width <= 0 or overlap.height <= 0:
        return None
    area = overlap.relative_to(data)
    depth_m = np.maximum(plate.pixels.depth_in(area), np.float32(1e-6))
    dioptres = np.maximum(np.reciprocal(depth_m, dtype=np.float32), _DIOPTRES_LEAST)
    image = _encode_image(plate.pixels.color_in(area)[..., :3], dioptres, tones)
    return Crop(overlap.x0, overlap.y0, image, dioptres)


def _encode_image(color: FloatImage, dioptres: FloatImage, tones: Tones) -> ByteImage:
    """Return light, tint (red minus blue) and depth (H, W, 3) on logarithmic scales of 0 to 255."""
    light = np.log1p(15.0 * np.clip(np.nan_to_num(color) / tones.white, 0.0, 1.0)) / np.log(16.0)
    tint = _MIDDLE_LEVEL + _MIDDLE_LEVEL * (light[..., 0] - light[..., 2])
    ratio = np.log2(np.maximum(dioptres / tones.dioptres, np.float32(1e-3)))
    depth = _MIDDLE_LEVEL + _LEVELS * ratio / _DEPTH_OCTAVES
    stack = np.stack([_LEVELS * (light @ _LUMA), tint, depth], axis=-1)
    image: ByteImage = np.clip(stack, 0.0, _LEVELS).astype(np.uint8)
    return image


def track_points(
    before: Crop, after: Crop, points: FloatImage, guess: tuple[float, float]
) -> tuple[FloatImage, FloatImage]:
    """Return the positions (N, 2) of `points` of one crop in another, and return errors (N,).

    `guess` is the expected movement (x, y) in pixels. Points are tracked forwards and back by
    pyramidal Lucas and Kanade. The return error is the distance in pixels to the start; it is
    infinite for a point that is not found. The crops have the same box.
    """
    tracked = _optical_flow(
        before.image, after.image, points, points + np.asarray(guess, np.float32)
    )
    returned = _optical_flow(after.image, before.image, tracked, points)
    miss_px = np.linalg.norm(returned - points, axis=1)
    return tracked, np.where(np.isfinite(miss_px), miss_px, np.inf).astype(np.float32)


def _optical_flow(
    before: ByteImage, after: ByteImage, points: FloatImage, guess: FloatImage
) -> FloatImage:
    """Return the positions (N, 2) of points in `after`; NaN for points that are not found."""
    is_valid = np.asarray(np.isfinite(points).all(axis=1))
    start = np.where(is_valid[:, None], points, np.float32(0.0)).astype(np.float32)
    cv2 = import_opencv()
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        start[:, None],
        guess.astype(np.float32)[:, None].copy(),
        winSize=(15, 15),
        maxLevel=3,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    is_found = is_valid & (status[:, 0] == 1)
    return np.where(is_found[:, None], moved[:, 0], np.float32(np.nan)).astype(np.float32)
