"""The plan of a shot: camera, surfaces and marks from above, in metres."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import Lean, lean_of
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.media.plate.plate import Plate

_COLUMNS, _ROWS = 64, 36  # largest number of plotted pixels
_SEEN_PART, _MEDIANS, _MARKS, _ROOM = 0.95, 3.0, 2.5, 1.12  # see `_reach_m`
_LEAST_M = 0.5  # shortest reach
_PLANE = 33  # places across the picture at which a leaning plane of focus is plotted


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
    points        (N, 2): metres right of the axis and in front of the camera
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
        self._made_of: object = None
        self._surfaces = np.zeros((0, 4), np.float32)  # see `_surfaces`

    def plan(
        self, plate: Plate, lens: Lens, marks: Iterable[tuple[Mark, float]], width_px: float
    ) -> Plan:
        """Return the plan of a plate with distances.

        `marks` are paired with their distances in m, in a picture that is `width_px` wide.
        """
        if self._made_of is not plate:
            self._surfaces, self._made_of = _surfaces(plate), plate
        half = lens.sensor_width_mm / lens.focal_length_mm / 2.0
        shown = tuple(_placed(mark, at_m, width_px, half) for mark, at_m in marks)
        points, (x, y) = self._surfaces[:, :2].copy(), self._surfaces[:, 2:].T
        points[:, 0] *= np.float32(half) * points[:, 1]
        lean, display = _lean(plate, lens), plate.display_window
        columns = np.linspace(0.0, display.width, 2 if lean.is_level else _PLANE)
        plane = lean.dioptres_at(columns, display.height / 2)
        nearer = lean.dioptres_at(x, y)
        return Plan(half, points, _reach_m(points, shown), shown, nearer, plane)


def _lean(plate: Plate, lens: Lens) -> Lean:
    shown = plate.display_window
    return lean_of(lens, (shown.width, shown.height), plate.pixel_aspect_ratio)


def _surfaces(plate: Plate) -> NDArray[np.float32]:
    """Return (N, 4) for some pixels: -1 to 1 over the display window, distance in m, and place."""
    data, display = plate.data_window, plate.display_window
    depth = plate.pixels.depth_in(Box(0, 0, data.width, data.height))
    rows = np.arange(0, data.height, max(data.height // _ROWS, 1))
    columns = np.arange(0, data.width, max(data.width // _COLUMNS, 1))
    far = depth[np.ix_(rows, columns)]
    x, y = columns + 0.5 + data.x0 - display.x0, rows[:, None] + 0.5 + data.y0 - display.y0
    parts = np.broadcast_arrays(x / display.width * 2.0 - 1.0, far, x, y)
    points = np.stack(parts, axis=-1).reshape(-1, 4).astype(np.float32)
    return np.ascontiguousarray(points[np.isfinite(points[:, 1]) & (points[:, 1] > 0)])


def _placed(mark: Mark, distance_m: float, width: float, half: float) -> PlanMark:
    side = 0.0
    if isinstance(mark, PointMark) and math.isfinite(distance_m):
        side = ((mark.x_px + 0.5) / width * 2.0 - 1.0) * half * distance_m
    return PlanMark(mark.name, side, distance_m, isinstance(mark, DistanceMark))


def _reach_m(points: NDArray[np.float32], marks: Iterable[PlanMark]) -> float:
    """Return the largest distance on the plan: nearly everything is on it, but no far background.

    If there are marks, it is limited to a little beyond the farthest one.
    """
    middle, most = np.quantile(points[:, 1], (0.5, _SEEN_PART)) if len(points) else (0.0, 0.0)
    reach_m = float(min(most, _MEDIANS * middle))
    marked = [mark.distance_m for mark in marks if math.isfinite(mark.distance_m)]
    if marked:
        reach_m = min(reach_m, _MARKS * max(marked))
    return _ROOM * max(reach_m, *marked, _LEAST_M)
