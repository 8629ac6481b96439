"""Follow one surface from plate to plate, in one direction of time.

Points on the surface are tracked by optical flow, forwards and back. Only points count that return
to their start and keep their depth. If too few are left, the surface is hidden. Its last good
appearance is then searched for around its expected position, at depths that it can have reached.
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
    import_opencv,
    track_points,
    white_level,
)

_SAME_OCTAVES = 0.1  # difference of depth within which a pixel belongs to the surface
_STEP_OCTAVES = 0.2  # largest change of its depth in one frame
_RETURN_ERROR_PX = 1.0  # largest distance of a point to its start after tracking there and back
_FOUND_LEAST, _POINTS_LEAST = 0.3, 4  # share and number of points that must be found
_LIKENESS_LEAST = 0.1  # likeness below which something else is followed
_REMEMBER_FROM = 0.8  # share of found points from which the appearance of the surface is remembered
_GRID = 9  # points across the patch
_RADIUS = (8, 28)  # least and most half width of the patch
_NEW_VELOCITY_SHARE = 0.5  # weight of the newest velocity in the running mean
_SEARCH_MOST = 0.4  # share of the picture's width that is searched to each side at most

_CORRELATION_LEAST = 0.7  # correlation from which a position shows the surface
_SURFACE_SHARE_LEAST = 0.6  # share of the surface that must have a possible depth
# The same share if the appearance has changed, and the largest depth tolerance for such a match.
_SURE_SHARE, _SURE_OCTAVES = 0.9, 0.5
_PLAIN_LEVELS = 2.0  # spread below which a surface has no pattern to look for
Position = NDArray[np.float64]


def _position_of(index: np.intp, shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the row and column of an index into the flattened array."""
    row, column = np.unravel_index(index, shape)
    return int(row), int(column)


@dataclass(frozen=True)
class Appearance:
    """The appearance of a surface: light and tint (h, w, 2) around a position, and its mask (h, w).

    `offset` is from the corner of the picture to the position, in pixels (x, y).
    """

    image: ByteImage
    mask: FloatImage
    offset: Position

    @property
    def has_pattern(self) -> bool:
        """True if light or color vary enough over the surface to search for it."""
        return bool(self.image[self.mask > 0].astype(np.float32).std(axis=0).max() > _PLAIN_LEVELS)

    def likeness(self, crop: Crop, position: Position) -> float:
        """Return the likeness, 0 to 1, of a position in a crop; 0 where the crop cuts it off."""
        x, y = np.rint(position - (crop.x0, crop.y0) - self.offset).astype(int)
        height, width = self.mask.shape
        section = crop.image[max(y, 0) : y + height, max(x, 0) : x + width, :2]
        if section.shape != self.image.shape:
            return 0.0
        return (
            min(max(float(self._correlate(section)[0, 0]), 0.0), 1.0) if self.has_pattern else 1.0
        )

    def find_in(
        self, crop: Crop, expected: Position, dioptres: float, octaves: float
    ) -> tuple[Position, float, float] | None:
        """Return position, dioptres and likeness of the surface in a crop; None if it is not found.

        Its depth may differ by `octaves`. For a surface without a pattern, the match closest to the
        expected position is taken. So is it for a surface that looks different, if it was hidden
        only shortly and the match is close to the expected position.
        """
        height, width = self.mask.shape
        rows, columns = crop.dioptres.shape[0] - height + 1, crop.dioptres.shape[1] - width + 1
        if rows <= 0 or columns <= 0:
            return None
        has_possible_depth = np.abs(np.log2(crop.dioptres / dioptres)) < octaves
        cv2 = import_opencv()
        covered_weight = cv2.matchTemplate(
            has_possible_depth.astype(np.float32), self.mask, cv2.TM_CCORR
        )
        share = covered_weight / self.mask.sum()
        y, x = np.mgrid[:rows, :columns]
        corner = expected - (crop.x0, crop.y0) - self.offset
        distance = np.hypot(x - corner[0], y - corner[1]) / (rows + columns)
        likeness = (
            self._correlate(crop.image[..., :2]) if self.has_pattern else 1.0 - 0.2 * distance
        )
        likeness = np.where(share >= _SURFACE_SHARE_LEAST, likeness, -1.0)
        row, column = _position_of(np.argmax(likeness), likeness.shape)
        if likeness[row, column] < _CORRELATION_LEAST:
            close_distance = np.where(
                (share >= _SURE_SHARE) & (distance * (rows + columns) <= width / 2), distance, 2.0
            )
            row, column = _position_of(np.argmin(close_distance), close_distance.shape)
            if close_distance[row, column] == 2.0 or octaves > _SURE_OCTAVES:
                return None
        is_surface = has_possible_depth[row : row + height, column : column + width] & (
            self.mask > 0
        )
        depths = crop.dioptres[row : row + height, column : column + width][is_surface]
        position = np.array([crop.x0 + column, crop.y0 + row], np.float64) + self.offset
        return position, float(np.median(depths)), max(float(likeness[row, column]), 0.0)

    def _correlate(self, image: ByteImage) -> FloatImage:
        """Return the correlation with every position in an image, -1 to 1."""
        cv2 = import_opencv()
        mask = np.repeat(self.mask[..., None], 2, -1)
        pixels = np.ascontiguousarray(image, np.float32)
        correlation = cv2.matchTemplate(
            pixels, self.image.astype(np.float32), cv2.TM_CCOEFF_NORMED, mask=mask
        )
        return np.where(np.isfinite(correlation), correlation, np.float32(-1.0))


def appearance_at(
    crop: Crop, position: Position, radius: int, dioptres: float, octaves: float
) -> Appearance:
    """Return the appearance of the surface around a position.

    Pixels whose depth differs by more than `octaves` are masked out.
    """
    column, row = np.rint(position - (crop.x0, crop.y0)).astype(int)
    x0, y0 = max(column - radius, 0), max(row - radius, 0)
    section = np.s_[y0 : row + radius + 1, x0 : column + radius + 1]
    assert isfinite(dioptres)
    is_surface = np.abs(np.log2(crop.dioptres[section] / dioptres)) < octaves
    offset = position - (crop.x0, crop.y0) - (x0, y0)
    return Appearance(crop.image[section][..., :2].copy(), is_surface.astype(np.float32), offset)


@dataclass(frozen=True)
class Sight:
    """The position and depth of the surface on one plate; `dioptres` is None if it is hidden."""

    x: float
    y: float
    dioptres: float | None
    likeness: float


class SurfaceTracker:
    """Follows the surface under a pixel of the first plate; call `step` for each next one."""

    def __init__(self, plate: Plate, x: float, y: float) -> None:
        """Start at pixel (x, y). Raises InputError outside the picture, and on the sky."""
        depth_m = depth_at_m(plate, int(x), int(y))
        if not np.isfinite(depth_m):
            raise InputError(f"Pixel {x:g},{y:g} shows the sky, which is not a surface to follow.")
        self._tones = Tones(white_level(plate), 1.0 / depth_m)
        width = plate.display_window.width
        self._radius = int(min(max(width / 60, _RADIUS[0]), _RADIUS[1]))
        self._reach = max(width // 10, 5 * self._radius)
        self._widest_reach = int(_SEARCH_MOST * width)
        self._position = np.array([x, y], np.float64)
        self._velocity = np.zeros(2)  # pixels a frame
        self._dioptres, self._depth_velocity = 1.0 / depth_m, 0.0  # octaves a frame
        self._plate, self._hidden_frames = plate, 0
        crop = self._crop_around(plate, self._reach)
        assert crop is not None  # `depth_at_m` found the pixel
        self._appearance = self._appearance_in(crop)

    @property
    def sight(self) -> Sight:
        """The position of the surface on the latest plate; the expected one if it is hidden."""
        visible_dioptres = None if self._hidden_frames else self._dioptres
        return Sight(
            float(self._position[0]), float(self._position[1]), visible_dioptres, self._likeness
        )

    _likeness = 1.0

    def step(self, plate: Plate) -> Sight:
        """Follow the surface to the next plate, and return where it is or is expected there."""
        is_found = not self._hidden_frames and self._follow(plate)
        if not is_found:
            self._hidden_frames += 1
            self._position = self._position + self._velocity
            self._likeness = 0.0
            self._search_hidden(plate)
        self._plate = plate
        return self.sight

    # Visible

    # Three tests keep the points from drifting onto objects that pass in front. Tracking forwards
    # and back rejects points that were covered. The depth rejects points that slid onto another
    # surface of the same appearance. Points at an edge, whose patch shows two surfaces, pass both
    # tests, so points with a nearer surface next to them are rejected as well.
    def _follow(self, plate: Plate) -> bool:
        """Move the position by the median movement of points; return False if too few are found."""
        reach = self._reach + int(np.abs(self._velocity).max())
        before, after = self._crop_around(self._plate, reach), self._crop_around(plate, reach)
        if before is None or after is None or before.image.shape != after.image.shape:
            return False
        points = self._grid_points(before)
        if len(points) < _POINTS_LEAST:
            return False
        tracked_points, return_errors = track_points(
            before, after, points, (self._velocity[0], self._velocity[1])
        )
        depths = after.depth_at(tracked_points)
        depth_velocities = np.log2(depths / before.depth_at(points))
        nearer_octaves = np.log2(after.with_nearest_depth().depth_at(tracked_points) / depths)
        is_good = (return_errors < _RETURN_ERROR_PX) & (
            np.abs(depth_velocities - self._depth_velocity) < _STEP_OCTAVES
        )
        is_good &= nearer_octaves < _STEP_OCTAVES
        if is_good.sum() < max(_POINTS_LEAST, _FOUND_LEAST * len(points)):
            return False
        movement = np.median(tracked_points[is_good] - points[is_good], axis=0)
        is_good &= np.linalg.norm(tracked_points - points - movement, axis=1) < 0.5 * self._radius
        if is_good.sum() < _POINTS_LEAST:
            return False
        self._update(after, movement, float(np.median(depth_velocities[is_good])))
        if self._likeness < _LIKENESS_LEAST:
            return False
        if is_good.mean() > _REMEMBER_FROM:
            self._appearance = self._appearance_in(after)
        return True

    def _update(self, after: Crop, movement: FloatImage, depth_velocity: float) -> None:
        """Update position, velocities, depth and likeness after a movement (x, y) in pixels."""
        self._position = self._position + movement
        self._velocity = (1 - _NEW_VELOCITY_SHARE) * self._velocity + _NEW_VELOCITY_SHARE * movement
        self._depth_velocity = (
            1 - _NEW_VELOCITY_SHARE
        ) * self._depth_velocity + _NEW_VELOCITY_SHARE * depth_velocity
        self._dioptres = self._measure_dioptres(after, self._dioptres * 2.0**depth_velocity)
        self._likeness = self._appearance.likeness(after, self._position)

    def _grid_points(self, crop: Crop) -> FloatImage:
        """Return a grid of points on the surface, in pixels of the crop."""
        side = np.linspace(-self._radius, self._radius, _GRID, dtype=np.float32)
        x, y = np.meshgrid(side, side)
        points = np.stack([x.ravel(), y.ravel()], 1) + np.float32(
            self._position - (crop.x0, crop.y0)
        )
        is_surface = np.abs(np.log2(crop.depth_at(points) / self._dioptres)) < _SAME_OCTAVES
        nearer_octaves = np.log2(crop.with_nearest_depth().depth_at(points) / self._dioptres)
        return np.asarray(points[is_surface & (nearer_octaves < _STEP_OCTAVES)], np.float32)

    def _measure_dioptres(self, crop: Crop, expected: float) -> float:
        """Return the median dioptres of the pixels around the position with the expected depth."""
        column, row = np.rint(self._position - (crop.x0, crop.y0)).astype(int)
        section = np.s_[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
        dioptres = crop.dioptres[section]
        surface_dioptres = dioptres[np.abs(np.log2(dioptres / expected)) < _SAME_OCTAVES]
        return float(np.median(surface_dioptres)) if surface_dioptres.size else expected

    # Hidden

    # The longer the surface is hidden, the less certain is its position: the search radius grows
    # with its last speed, and the tolerance of its depth grows as well, up to an octave.
    def _search_hidden(self, plate: Plate) -> None:
        """Search for the last good appearance around the expected position.

        If it is found, the surface counts as visible again.
        """
        speed = float(np.abs(self._velocity).max())
        reach = self._radius * 3 + int(self._hidden_frames * (0.5 * speed + 1.0))
        crop = self._crop_around(plate, min(reach, self._widest_reach))
        if crop is None:
            return
        octaves = min(2 * _SAME_OCTAVES + 0.03 * self._hidden_frames, 1.0)
        match = self._appearance.find_in(crop, self._position, self._dioptres, octaves)
        if match is None:
            return
        position, dioptres, self._likeness = match
        self._position, self._dioptres = position, dioptres
        self._depth_velocity, self._hidden_frames = 0.0, 0

    def _crop_around(self, plate: Plate, reach: int) -> Crop | None:
        """Return the plate within `reach` pixels of the position; None outside of it."""
        x, y = (int(coordinate) for coordinate in np.rint(self._position))
        box = Box(x - reach, y - reach, x + reach + 1, y + reach + 1)
        return crop_of(plate, box, self._tones)

    def _appearance_in(self, crop: Crop) -> Appearance:
        """Return the current appearance of the surface in a crop."""
        return appearance_at(crop, self._position, self._radius, self._dioptres, _SAME_OCTAVES)
