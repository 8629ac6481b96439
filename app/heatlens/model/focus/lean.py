"""Where in the picture the focus is nearer than in its middle: tilt and split diopter.

A tilted lens is sharp on a plane that leans. It goes through the hinge line, f / sin(tilt) from
the lens at right angles to its axis, whatever its ring says (Merklinger 1992). In dioptres every
plane is linear over the picture, so that with a point's tangents x, y from the middle of the view

    1 / focus(x, y)  =  1 / focus(0, 0) + sin(tilt) / f * (x, y) . direction

A split diopter is a close-up lens over a part of the picture, which adds its power there. Both add
to the circle of confusion what `Lean` says, to first order in the size of the opening.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.model.boxes import Box
from heatlens.model.lens.lens import Lens

Triple = tuple[float, float, float]  # for each pixel to the right, for each one down, and at (0, 0)
_EDGE_LEAST_PX = 1.0  # narrowest transition of a split


@dataclass(frozen=True, slots=True)
class Lean:
    """Dioptres by which the focus at a pixel exceeds that in the middle of the picture.

    slope  dioptres of the tilt
    edge   share of the split that a pixel has, 0 to 1, before it is limited to that and smoothed
    split  dioptres of the split
    """

    slope: Triple = (0.0, 0.0, 0.0)
    edge: Triple = (0.0, 0.0, 0.0)
    split: float = 0.0

    @property
    def is_level(self) -> bool:
        """Return whether the focus is the same in all of the picture."""
        return self == LEVEL

    def dioptres_at(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return the dioptres at places in pixels; the first pixel's middle is (0.5, 0.5)."""
        tilted, part = (of[0] * np.asarray(x) + of[1] * np.asarray(y) + of[2] for of in self._both)
        share = np.clip(part, 0.0, 1.0)
        return np.asarray(tilted + self.split * share * share * (3 - 2 * share), np.float64)

    def ends(self, area: Box) -> tuple[float, float]:
        """Return limits of the dioptres in an area of pixels."""
        places = ((x, y) for x in (area.x0, area.x1) for y in (area.y0, area.y1))
        corners = [self.slope[0] * x + self.slope[1] * y for x, y in places]
        split = min(self.split, 0.0), max(self.split, 0.0)
        return min(corners) + self.slope[2] + split[0], max(corners) + self.slope[2] + split[1]

    def moved(self, px: tuple[float, float]) -> "Lean":
        """Return the same in a picture that begins this many pixels farther left and up."""
        slope, edge = ((a, b, c - a * px[0] - b * px[1]) for a, b, c in self._both)
        return replace(self, slope=slope, edge=edge)

    def scaled(self, scale: float) -> "Lean":
        """Return the same in the picture at another size."""
        slope, edge = ((a / scale, b / scale, c) for a, b, c in self._both)
        return replace(self, slope=slope, edge=edge)

    def uniforms(self, per_dioptre: float) -> dict[str, object]:
        """Return the uniforms of lib/lean.lib.glsl, which has `per_dioptre` for each dioptre."""
        slope = tuple(per_dioptre * it for it in self.slope)
        return {"lean_slope": slope, "lean_edge": self.edge, "lean_split": per_dioptre * self.split}

    @property
    def _both(self) -> tuple[Triple, Triple]:
        return self.slope, self.edge


LEVEL = Lean()


def lean_of(lens: Lens, size: tuple[int, int], pixel_aspect_ratio: float = 1.0) -> Lean:
    """Return where the focus lies in a picture of this width and height, which the sensor fills."""
    if lens.tilt_deg == 0.0 and lens.split_dioptres == 0.0:
        return LEVEL
    width, height = size
    focal_px = width * lens.focal_length_mm / lens.sensor_width_mm
    steepness = 1e3 * math.sin(math.radians(lens.tilt_deg)) / lens.focal_length_mm / focal_px
    slope = _rising(steepness, lens.tilt_direction_deg - 90.0, pixel_aspect_ratio)
    sharpness = 1.0 / max(lens.split_softness * width, _EDGE_LEAST_PX)
    edge = _rising(sharpness, lens.split_direction_deg, pixel_aspect_ratio)
    middle = 0.5 - lens.split_position * width / 2 * sharpness
    level = Lean((*slope, 0.0), (*edge, middle), lens.split_dioptres)
    return level.moved((width / 2, height / 2))


def _rising(by: float, direction_deg: float, pixel_aspect_ratio: float) -> tuple[float, float]:
    """Return the rise for each pixel right and down; the direction is anticlockwise from right."""
    angle = math.radians(direction_deg)
    return by * math.cos(angle), -by * math.sin(angle) / pixel_aspect_ratio
