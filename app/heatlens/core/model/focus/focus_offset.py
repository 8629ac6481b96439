"""How far the focus of parts of the picture is from the set distance: tilt, curvature, a split."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.aperture import FOCUS_OFFSET_TERMS
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import Values, options_of

Triple = tuple[float, float, float]  # for each pixel to the right, for each one down, and at (0, 0)
_EDGE_LEAST_PX = 1.0  # narrowest transition of a split


# Code asks `is_level` and `is_plane` instead of tilt and split by name, so that it covers every
# term of the focus. Otherwise a new term is drawn by every pass, but accumulation and the focus on
# a mark ignore it without a warning.
@dataclass(frozen=True, slots=True)
class FocusOffset:
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
        """Whether the focus is the same in all of the picture."""
        return self == LEVEL

    @property
    def is_plane(self) -> bool:
        """Whether all that is sharp lies on one plane, which may lean."""
        return self == FocusOffset(slope=self.slope, edge=self.edge)

    def dioptres_at(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return the dioptres at positions in pixels; the first pixel's middle is (0.5, 0.5)."""
        tilted, split_part = (
            gradient[0] * np.asarray(x) + gradient[1] * np.asarray(y) + gradient[2]
            for gradient in self._gradients
        )
        share = np.clip(split_part, 0.0, 1.0)
        return np.asarray(tilted + self.split * share * share * (3 - 2 * share), np.float64)

    def dioptre_limits(self, area: Box) -> tuple[float, float]:
        """Return a lower and an upper limit of the dioptres in an area of pixels.

        They need not be reached: the whole split counts, wherever its edge lies.
        """
        area_corners = ((x, y) for x in (area.x0, area.x1) for y in (area.y0, area.y1))
        corner_dioptres = [self.slope[0] * x + self.slope[1] * y for x, y in area_corners]
        split_limits = min(self.split, 0.0), max(self.split, 0.0)
        return min(corner_dioptres) + self.slope[2] + split_limits[0], max(
            corner_dioptres
        ) + self.slope[2] + split_limits[1]

    def moved(self, px: tuple[float, float]) -> "FocusOffset":
        """Return the offset for a picture that begins this many pixels farther left and up."""
        slope, edge = ((a, b, c - a * px[0] - b * px[1]) for a, b, c in self._gradients)
        return replace(self, slope=slope, edge=edge)

    def scaled(self, scale: float) -> "FocusOffset":
        """Return the offset for the picture at `scale` times its size."""
        slope, edge = ((a / scale, b / scale, c) for a, b, c in self._gradients)
        return replace(self, slope=slope, edge=edge)

    def uniforms(self, per_dioptre: float) -> dict[str, object]:
        """Return the uniforms of focus_offset.lib.glsl; `per_dioptre` is the coc of one dioptre."""
        slope = tuple(per_dioptre * term for term in self.slope)
        return {
            "focus_offset_slope": slope,
            "focus_offset_edge": self.edge,
            "focus_offset_split": per_dioptre * self.split,
        }

    @property
    def _gradients(self) -> tuple[Triple, Triple]:
        """The slope of the focus across the picture, and that of its edge, for each color."""
        return self.slope, self.edge


LEVEL = FocusOffset()


def focus_offset_of(
    lens: Lens, size: tuple[int, int], pixel_aspect_ratio: float = 1.0
) -> FocusOffset:
    """Return the offset of the focus by tilt and split in a picture of this width and height.

    The sensor's width fills the picture.
    """
    if not any(getattr(lens, term) for term in FOCUS_OFFSET_TERMS):
        return LEVEL
    width, height = size
    focal_px = width * lens.focal_length_mm / lens.sensor_width_mm
    # Dioptres for each pixel: a point's tangent grows by 1 / focal_px from pixel to pixel.
    steepness = 1e3 * math.sin(math.radians(lens.tilt_deg)) / lens.focal_length_mm / focal_px
    slope = _gradient(steepness, lens.tilt_direction_deg - 90.0, pixel_aspect_ratio)
    sharpness = 1.0 / max(lens.split_softness * width, _EDGE_LEAST_PX)
    edge = _gradient(sharpness, lens.split_direction_deg, pixel_aspect_ratio)
    edge_at_middle = 0.5 - lens.split_position * width / 2 * sharpness
    centered = FocusOffset((*slope, 0.0), (*edge, edge_at_middle), lens.split_dioptres)
    return centered.moved((width / 2, height / 2))


def non_planar_terms(lens: Lens) -> list[str]:
    """Return the labels of the lens's terms by which its sharp points lie on no single plane."""
    no_focus_offset: Values = dict.fromkeys(FOCUS_OFFSET_TERMS, 0.0)
    single_terms: list[Values] = [
        no_focus_offset | {term: getattr(lens, term)} for term in FOCUS_OFFSET_TERMS
    ]
    are_planes = [
        focus_offset_of(replace(lens, **single_term), (1, 1)).is_plane
        for single_term in single_terms
    ]
    options = options_of(Lens)
    return [
        options[term].label
        for term, is_flat in zip(FOCUS_OFFSET_TERMS, are_planes, strict=True)
        if not is_flat
    ]


def _gradient(
    steepness: float, direction_deg: float, pixel_aspect_ratio: float
) -> tuple[float, float]:
    """Return the rise for each pixel to the right and down of a slope in a direction.

    `direction_deg` counts anticlockwise from the right.
    """
    angle = math.radians(direction_deg)
    return steepness * math.cos(angle), -steepness * math.sin(angle) / pixel_aspect_ratio
