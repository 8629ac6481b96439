"""Follow one surface from plate to plate, in one direction of time.

Points on the surface are moved by optical flow there and back. Only those count that come back and
keep their depth. Where too few are left the surface is hidden, and its last good look is searched
for around the place where it should be, at depths that it can have reached.
"""

from dataclasses import dataclass

import numpy as np

from heatlens.base.errors import InputError
from heatlens.model.boxes import Box
from heatlens.plate.focus_pick import depth_at_m
from heatlens.plate.plate import FloatImage, Plate
from heatlens.plate.tracking.crops import Crop, Tones, crop_of, moved_points, white_of
from heatlens.plate.tracking.look import Look, look_at

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
        kept = (missed < _BACK_PX) & (np.abs(nearing - self._nearing) < _STEP_OCTAVES)
        kept &= beside < _STEP_OCTAVES
        if kept.sum() < max(_POINTS_LEAST, _FOUND_LEAST * len(points)):
            return False
        moved = np.median(there[kept] - points[kept], axis=0)
        kept &= np.linalg.norm(there - points - moved, axis=1) < 0.5 * self._radius
        if kept.sum() < _POINTS_LEAST:
            return False
        self._take(after, moved, float(np.median(nearing[kept])))
        if self._likeness < _LIKE_LEAST:
            return False
        if kept.mean() > _GOOD:
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

    def _search(self, plate: Plate) -> None:
        """Find the last good look again, near where it should be."""
        speed = float(np.abs(self._moves).max())
        reach = self._radius * 3 + int(self._hidden_frames * (0.5 * speed + 1.0))
        crop = self._crop(plate, min(reach, self._widest))
        if crop is None:
            return
        octaves = min(2 * _SAME_OCTAVES + 0.03 * self._hidden_frames, 1.0)
        found = self._look.found(crop, self._at, self._dioptres, octaves)
        if found is None:
            return
        place, dioptres, self._likeness = found
        self._at, self._dioptres = place, dioptres
        self._nearing, self._hidden_frames = 0.0, 0

    def _crop(self, plate: Plate, reach: int) -> Crop | None:
        x, y = (int(it) for it in np.rint(self._at))
        box = Box(x - reach, y - reach, x + reach + 1, y + reach + 1)
        return crop_of(plate, box, self._tones)

    def _look_in(self, crop: Crop) -> Look:
        return look_at(crop, self._at, self._radius, self._dioptres, _SAME_OCTAVES)
