"""Make the plan of a shot: camera, surfaces and marks seen from above, in meters."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.focus_offset import FocusOffset, focus_offset_of
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.media.plate.plate import Plate

_COLUMNS, _ROWS = 64, 36  # largest number of plotted pixels
_SHOWN_SHARE, _MAX_MEDIANS, _MAX_MARK_RATIO, _MARGIN = 0.95, 3.0, 2.5, 1.12  # see `_reach_m`
_MIN_REACH_M = 0.5  # shortest reach
_PLANE_POINTS = 33  # positions across the picture at which a tilted plane of focus is plotted


@dataclass(frozen=True)
class PlanMark:
    """A mark seen from above. `side_m` is measured to the right; 0 for a mark without a point."""

    name: str
    side_m: float
    distance_m: float
    is_movable: bool


@dataclass(frozen=True, eq=False)
class Plan:
    """The plan, seen from above.

    half_tangent  tangent of half the horizontal angle of view
    points        (N, 2): meters right of the axis and in front of the camera
    reach_m       the largest distance on the plan
    marks         the marks that have a distance at this frame
    nearer        (N,) dioptres by which the focus is nearer at each point than in the middle
    plane         the same from the left to the right end of the picture's middle row
    """

    half_tangent: float
    points: NDArray[np.float32]
    reach_m: float
    marks: tuple[PlanMark, ...]
    nearer: NDArray[np.float64]
    plane: NDArray[np.float64]


class PlanDrawer:
    """Makes the plan; the surfaces of each plate are computed once."""

    def __init__(self) -> None:
        self._plate: object = None
        self._surfaces = np.zeros((0, 4), np.float32)  # see `_sample_surfaces`

    def plan(
        self, plate: Plate, lens: Lens, marks: Iterable[tuple[Mark, float]], width_px: float
    ) -> Plan:
        """Return the plan of a plate that has distances.

        `marks` are pairs of a mark and its distance in meters. `width_px` is the width of the
        picture that the marks are set in.
        """
        if self._plate is not plate:
            self._surfaces, self._plate = _sample_surfaces(plate), plate
        half_tangent = lens.sensor_width_mm / lens.focal_length_mm / 2.0
        plan_marks = tuple(_plan_mark(mark, at_m, width_px, half_tangent) for mark, at_m in marks)
        points, (x, y) = self._surfaces[:, :2].copy(), self._surfaces[:, 2:].T
        points[:, 0] *= np.float32(half_tangent) * points[:, 1]
        focus_plane, display = _focus_plane(plate, lens), plate.display_window
        columns = np.linspace(0.0, display.width, 2 if focus_plane.is_level else _PLANE_POINTS)
        plane = focus_plane.dioptres_at(columns, display.height / 2)
        nearer = focus_plane.dioptres_at(x, y)
        return Plan(half_tangent, points, _reach_m(points, plan_marks), plan_marks, nearer, plane)


def _focus_plane(plate: Plate, lens: Lens) -> FocusOffset:
    """Return how much nearer the focus is at each pixel than in the middle, in dioptres."""
    window = plate.display_window
    return focus_offset_of(lens, (window.width, window.height), plate.pixel_aspect_ratio)


def _sample_surfaces(plate: Plate) -> NDArray[np.float32]:
    """Return (N, 4) for some pixels: x from -1 to 1, distance in m, and pixel position x, y.

    x is -1 at the left edge of the display window and 1 at its right edge.
    """
    display = plate.display_window
    data = plate.data_window.relative_to(display)
    depth = plate.pixels.depth_in(Box(0, 0, data.width, data.height))
    rows = np.arange(0, data.height, max(data.height // _ROWS, 1))
    columns = np.arange(0, data.width, max(data.width // _COLUMNS, 1))
    distances = depth[np.ix_(rows, columns)]
    x, y = columns + 0.5 + data.x0, rows[:, None] + 0.5 + data.y0
    columns_of_points = np.broadcast_arrays(x / display.width * 2.0 - 1.0, distances, x, y)
    points = np.stack(columns_of_points, axis=-1).reshape(-1, 4).astype(np.float32)
    return np.ascontiguousarray(points[np.isfinite(points[:, 1]) & (points[:, 1] > 0)])


def _plan_mark(mark: Mark, distance_m: float, width_px: float, half_tangent: float) -> PlanMark:
    """Return a mark on the plan, in a picture `width_px` wide; see `Plan` for `half_tangent`."""
    side_m = 0.0
    if isinstance(mark, PointMark) and math.isfinite(distance_m):
        side_m = ((mark.x_px + 0.5) / width_px * 2.0 - 1.0) * half_tangent * distance_m
    return PlanMark(mark.name, side_m, distance_m, isinstance(mark, DistanceMark))


def _reach_m(points: NDArray[np.float32], marks: Iterable[PlanMark]) -> float:
    """Return the largest distance on the plan: it shows nearly everything but no far background.

    If there are marks, the distance is limited to a multiple of that of the farthest mark.
    """
    median, nearly_all = (
        np.quantile(points[:, 1], (0.5, _SHOWN_SHARE)) if len(points) else (0.0, 0.0)
    )
    reach_m = float(min(nearly_all, _MAX_MEDIANS * median))
    mark_distances = [mark.distance_m for mark in marks if math.isfinite(mark.distance_m)]
    if mark_distances:
        reach_m = min(reach_m, _MAX_MARK_RATIO * max(mark_distances))
    return _MARGIN * max(reach_m, *mark_distances, _MIN_REACH_M)
