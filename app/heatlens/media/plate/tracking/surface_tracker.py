"""Follow one surface from plate to plate, in one direction of time.

Points on the surface are moved by optical flow there and back. Only those count that come back and
keep their depth. Where too few are left the surface is hidden, and its last good look is searched
for around the place where it should be, at depths that it can have reached.
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.media.plate.coc_line import depth_at_m
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.plate.tracking.crops import (
    ByteImage,
    Crop,
    Tones,
    crop_of,
    moved_points,
    opencv,
    white_of,
)

_SAME_OCTAVES = 0.1  # depths nearer together than this belong to the surface
_STEP_OCTAVES = 0.2  # most that its depth changes in one frame
_BACK_PX = 1.0  # how far a point may miss on the way back
_FOUND_LEAST, _POINTS_LEAST = 0.3, 4  # of the points that must be found
_LIKE_LEAST = 0.1  # likeness below which something else is followed
_GOOD = 0.8  # share of found points from which the look of the surface is remembered
_GRID = 9  # points across the patch
_RADIUS = (8, 28)  # least and most half width of the patch
_SETTLES = 0.5  # share of a new velocity
_WIDEST = 0.4  # of the picture's width that is searched to each side

_SHOWS_LEAST = 0.7  # correlation from which a place shows the surface
_SEEN_LEAST = 0.6  # share of the surface that must have a possible depth
_SURE, _SURE_OCTAVES = 0.9, 0.5  # the same where it looks different, and for how long
_PLAIN_LEVELS = 2.0  # spread below which a surface has no pattern to look for
Place = NDArray[np.float64]


@dataclass(frozen=True)
class Look:
    """A picture (h, w, 2) of light and colour around the place, and what of it is the surface.

    `offset` is from the corner of the picture to the place, in pixels (x, y).
    """

    image: ByteImage
    mask: FloatImage
    offset: Place

    @property
    def has_pattern(self) -> bool:
        """Return True if it can be told from a plain surface."""
        return bool(self.image[self.mask > 0].astype(np.float32).std(axis=0).max() > _PLAIN_LEVELS)

    def likeness(self, crop: Crop, at: Place) -> float:
        """Return how much a place of a crop looks like this, 0 to 1; 0 where it is cut off."""
        x, y = np.rint(at - (crop.x0, crop.y0) - self.offset).astype(int)
        height, width = self.mask.shape
        part = crop.image[max(y, 0) : y + height, max(x, 0) : x + width, :2]
        if part.shape != self.image.shape:
            return 0.0
        return min(max(float(self._matches(part)[0, 0]), 0.0), 1.0) if self.has_pattern else 1.0

    def found(
        self, crop: Crop, expected: Place, dioptres: float, octaves: float
    ) -> tuple[Place, float, float] | None:
        """Return place, dioptres and likeness where the surface is seen again; None if nowhere.

        Its depth may differ by some octaves. Of a plain surface the nearest part is taken, and so
        of one that looks different, soon after it was seen and close to where it should be.
        """
        height, width = self.mask.shape
        rows, columns = crop.dioptres.shape[0] - height + 1, crop.dioptres.shape[1] - width + 1
        if rows <= 0 or columns <= 0:
            return None
        near = np.abs(np.log2(crop.dioptres / dioptres)) < octaves
        cv2 = opencv()
        covered = cv2.matchTemplate(near.astype(np.float32), self.mask, cv2.TM_CCORR)
        share = covered / self.mask.sum()
        y, x = np.mgrid[:rows, :columns]
        corner = expected - (crop.x0, crop.y0) - self.offset
        away = np.hypot(x - corner[0], y - corner[1]) / (rows + columns)
        like = self._matches(crop.image[..., :2]) if self.has_pattern else 1.0 - 0.2 * away
        like = np.where(share >= _SEEN_LEAST, like, -1.0)
        row, column = (int(it) for it in np.unravel_index(np.argmax(like), like.shape))
        if like[row, column] < _SHOWS_LEAST:
            close = np.where((share >= _SURE) & (away * (rows + columns) <= width / 2), away, 2.0)
            row, column = (int(it) for it in np.unravel_index(np.argmin(close), close.shape))
            if close[row, column] == 2.0 or octaves > _SURE_OCTAVES:
                return None
        seen = near[row : row + height, column : column + width] & (self.mask > 0)
        depths = crop.dioptres[row : row + height, column : column + width][seen]
        place = np.array([crop.x0 + column, crop.y0 + row], np.float64) + self.offset
        return place, float(np.median(depths)), max(float(like[row, column]), 0.0)

    def _matches(self, image: ByteImage) -> FloatImage:
        """Return the correlation with every place of an image, -1 to 1."""
        cv2 = opencv()
        mask = np.repeat(self.mask[..., None], 2, -1)
        part = np.ascontiguousarray(image, np.float32)
        correlation = cv2.matchTemplate(
            part, self.image.astype(np.float32), cv2.TM_CCOEFF_NORMED, mask=mask
        )
        return np.where(np.isfinite(correlation), correlation, np.float32(-1.0))


def look_at(crop: Crop, at: Place, radius: int, dioptres: float, octaves: float) -> Look:
    """Return the look of the surface at a place; what lies farther in depth is left out."""
    column, row = np.rint(at - (crop.x0, crop.y0)).astype(int)
    x0, y0 = max(column - radius, 0), max(row - radius, 0)
    part = np.s_[y0 : row + radius + 1, x0 : column + radius + 1]
    assert isfinite(dioptres)
    near = np.abs(np.log2(crop.dioptres[part] / dioptres)) < octaves
    offset = at - (crop.x0, crop.y0) - (x0, y0)
    return Look(crop.image[part][..., :2].copy(), near.astype(np.float32), offset)


@dataclass(frozen=True)
class Sight:
    """Where the surface is on one plate; `dioptres` is None where it is not seen."""

    x: float
    y: float
    dioptres: float | None
    likeness: float


class SurfaceTracker:
    """Follows the surface under a pixel of the first plate; call `step` for each next one."""

    def __init__(self, plate: Plate, x: float, y: float) -> None:
        """Begin. Raises InputError outside the picture, and where there is nothing to see."""
        depth_m = depth_at_m(plate, int(x), int(y))
        if not np.isfinite(depth_m):
            raise InputError(f"Pixel {x:g},{y:g} shows the sky, which is not a surface to follow.")
        self._tones = Tones(white_of(plate), 1.0 / depth_m)
        width = plate.display_window.width
        self._radius = int(min(max(width / 60, _RADIUS[0]), _RADIUS[1]))
        self._reach, self._widest = max(width // 10, 5 * self._radius), int(_WIDEST * width)
        self._at = np.array([x, y], np.float64)
        self._moves = np.zeros(2)  # pixels a frame
        self._dioptres, self._nearing = 1.0 / depth_m, 0.0  # octaves a frame
        self._plate, self._hidden_frames = plate, 0
        crop = self._crop(plate, self._reach)
        assert crop is not None  # `depth_at_m` found the pixel
        self._look = self._look_in(crop)

    @property
    def sight(self) -> Sight:
        """Where it was seen last, or should be now."""
        seen = None if self._hidden_frames else self._dioptres
        return Sight(float(self._at[0]), float(self._at[1]), seen, self._likeness)

    _likeness = 1.0

    def step(self, plate: Plate) -> Sight:
        """Follow the surface to the next plate."""
        is_found = not self._hidden_frames and self._follow(plate)
        if not is_found:
            self._hidden_frames += 1
            self._at = self._at + self._moves
            self._likeness = 0.0
            self._search(plate)
        self._plate = plate
        return self.sight

    # Seen

    # Flow alone drifts onto whatever passes in front. Going there and back finds points that were
    # covered; the depth finds those that slid onto another surface of the same look. What was left
    # over by both are points at an edge, whose patch holds two surfaces: so they may have nothing
    # nearer beside them.
    def _follow(self, plate: Plate) -> bool:
        """Move to where most of the points went; return False if too few are found."""
        reach = self._reach + int(np.abs(self._moves).max())
        before, after = self._crop(self._plate, reach), self._crop(plate, reach)
        if before is None or after is None or before.image.shape != after.image.shape:
            return False
        points = self._points(before)
        if len(points) < _POINTS_LEAST:
            return False
        there, missed = moved_points(before, after, points, (self._moves[0], self._moves[1]))
        depths = after.depth_at(there)
        nearing = np.log2(depths / before.depth_at(points))
        beside = np.log2(after.nearest().depth_at(there) / depths)
        good = (missed < _BACK_PX) & (np.abs(nearing - self._nearing) < _STEP_OCTAVES)
        good &= beside < _STEP_OCTAVES
        if good.sum() < max(_POINTS_LEAST, _FOUND_LEAST * len(points)):
            return False
        moved = np.median(there[good] - points[good], axis=0)
        good &= np.linalg.norm(there - points - moved, axis=1) < 0.5 * self._radius
        if good.sum() < _POINTS_LEAST:
            return False
        self._take(after, moved, float(np.median(nearing[good])))
        if self._likeness < _LIKE_LEAST:
            return False
        if good.mean() > _GOOD:
            self._look = self._look_in(after)
        return True

    def _take(self, after: Crop, moved: FloatImage, nearing: float) -> None:
        self._at = self._at + moved
        self._moves = (1 - _SETTLES) * self._moves + _SETTLES * moved
        self._nearing = (1 - _SETTLES) * self._nearing + _SETTLES * nearing
        self._dioptres = self._depth_near(after, self._dioptres * 2.0**nearing)
        self._likeness = self._look.likeness(after, self._at)

    def _points(self, crop: Crop) -> FloatImage:
        """Return a grid of points on the surface, in pixels of the crop."""
        side = np.linspace(-self._radius, self._radius, _GRID, dtype=np.float32)
        x, y = np.meshgrid(side, side)
        points = np.stack([x.ravel(), y.ravel()], 1) + np.float32(self._at - (crop.x0, crop.y0))
        is_own = np.abs(np.log2(crop.depth_at(points) / self._dioptres)) < _SAME_OCTAVES
        beside = np.log2(crop.nearest().depth_at(points) / self._dioptres)
        return np.asarray(points[is_own & (beside < _STEP_OCTAVES)], np.float32)

    def _depth_near(self, crop: Crop, expected: float) -> float:
        """Return the median of what is seen around the place at about the expected depth."""
        column, row = np.rint(self._at - (crop.x0, crop.y0)).astype(int)
        part = np.s_[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
        around = crop.dioptres[part]
        same = around[np.abs(np.log2(around / expected)) < _SAME_OCTAVES]
        return float(np.median(same)) if same.size else expected

    # Hidden

    # The longer it is hidden, the less is known of where it went: the reach grows with the speed
    # that it had, and the depth that it may have reached grows as well, up to an octave.
    def _search(self, plate: Plate) -> None:
        """Find the last good look again, near where it should be."""
        speed = float(np.abs(self._moves).max())
        reach = self._radius * 3 + int(self._hidden_frames * (0.5 * speed + 1.0))
        crop = self._crop(plate, min(reach, self._widest))
        if crop is None:
            return
        octaves = min(2 * _SAME_OCTAVES + 0.03 * self._hidden_frames, 1.0)
        again = self._look.found(crop, self._at, self._dioptres, octaves)
        if again is None:
            return
        place, dioptres, self._likeness = again
        self._at, self._dioptres = place, dioptres
        self._nearing, self._hidden_frames = 0.0, 0

    def _crop(self, plate: Plate, reach: int) -> Crop | None:
        x, y = (int(it) for it in np.rint(self._at))
        box = Box(x - reach, y - reach, x + reach + 1, y + reach + 1)
        return crop_of(plate, box, self._tones)

    def _look_in(self, crop: Crop) -> Look:
        return look_at(crop, self._at, self._radius, self._dioptres, _SAME_OCTAVES)
