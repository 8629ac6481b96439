"""The circle of confusion of a thin lens, and the limits of what looks sharp.

    A   diameter of the aperture
    f   focal length
    v   distance from the lens to the image
    S   focus distance
    z   depth of a point
    c   the acceptable circle of confusion: the diameter up to which a disc looks sharp

A point at depth z makes a disc on the sensor of diameter

    coc(z) = A v (1 / S - 1 / z)  =  A v / S  -  A v * 1 / z

negative in front of the focus, zero on it, positive behind. That is a straight line over 1/z, the
dioptres, and stays one for focus at infinity: 0 - A f / z. Everything here follows from the line.
`LensModel` says what v is: f / (1 - f / S) for a real lens, so that A v / S is the well-known
A f / (S - f), and the focal length f for a renderer.

`FocusOffset` is how much nearer than in its middle the focus of a picture is: tilt and split.
A tilted lens is sharp on a plane that leans. It goes through the hinge line, f / sin(tilt) from
the lens at right angles to its axis, whatever its ring says (Merklinger 1992). In dioptres every
plane is linear over the picture, so that with a point's tangents x, y from the middle of the view

    1 / focus(x, y)  =  1 / focus(0, 0) + sin(tilt) / f * (x, y) . direction

A split diopter is a close-up lens over a part of the picture, which adds its power there. Both add
to the circle of confusion what `FocusOffset` says, to first order in the size of the opening.
"""

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
        """Return whether the focus is the same in all of the picture."""
        return self == LEVEL

    @property
    def is_plane(self) -> bool:
        """Return whether all that is sharp lies on one plane, which may lean."""
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
        """Return the uniforms of focus_offset.lib.glsl, which has `per_dioptre` for a dioptre."""
        slope = tuple(per_dioptre * term for term in self.slope)
        return {
            "focus_offset_slope": slope,
            "focus_offset_edge": self.edge,
            "focus_offset_split": per_dioptre * self.split,
        }

    @property
    def _gradients(self) -> tuple[Triple, Triple]:
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


# Sixty times the width of the largest plate; sums over wider discs would overflow on a GPU.
COC_MOST_PX = 1e6


@dataclass(frozen=True, slots=True)
class CocLine:
    """Signed diameter over dioptres: coc_px = at_infinity_px + per_dioptre_px / depth_m.

    Pictures are made of diameters up to COC_MOST_PX.

    at_infinity_px   diameter of a point at infinity, in pixels across; 0 with focus at infinity
    per_dioptre_px   pixels for each 1/m that the point is nearer; always negative
    focus_offset     what a tilt or a split adds at a pixel, in dioptres
    """

    at_infinity_px: float
    per_dioptre_px: float
    focus_offset: FocusOffset = LEVEL

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms of lib/coc.lib.glsl."""
        ends = {"at_infinity_px": self.at_infinity_px, "per_dioptre_px": self.per_dioptre_px}
        return ends | self.focus_offset_uniforms

    @property
    def focus_offset_uniforms(self) -> dict[str, object]:
        """The uniforms of lib/focus_offset.lib.glsl, in pixels."""
        return self.focus_offset.uniforms(-self.per_dioptre_px)

    def scaled(self, scale: float) -> "CocLine":
        """Return the line for the picture at `scale` times its size."""
        ends = self.at_infinity_px * scale, self.per_dioptre_px * scale
        return CocLine(*ends, self.focus_offset.scaled(scale))

    def focus_offset_limits_px(self, area: Box) -> tuple[float, float]:
        """Return the lower and the upper limit, in pixels, of what the offset adds in an area."""
        least, most = self.focus_offset.dioptre_limits(area)
        return -self.per_dioptre_px * least, -self.per_dioptre_px * most


NO_LINE = CocLine(0.0, 0.0)  # for a plate that holds the coc itself


def coc_line(lens: Lens, display_width_px: int) -> CocLine:
    """Return the line of a spherical lens of this focal length and f-stop, in pixels across.

    `display_width_px` is the width of the display window, which the sensor's width fills.
    `DiscShape` says what shape of that diameter a disc has, and counts pixels that are not square.
    """
    per_dioptre_px = _per_dioptre_mm(lens) * display_width_px / lens.sensor_width_mm
    # With this division, `coc_px` gives exactly zero on the focus.
    return CocLine(-per_dioptre_px / lens.focus_distance_m, per_dioptre_px)


def coc_px(depth_m: ArrayLike, line: CocLine) -> NDArray[np.float64]:
    """Return signed diameters in pixels, in the shape of `depth_m`; the sky's may be infinite.

    They are those of a level focus; add `focus_offset_coc_px` for a tilt or a split.
    """
    return np.asarray(line.at_infinity_px + line.per_dioptre_px / np.asarray(depth_m, np.float64))


def focus_offset_coc_px(line: CocLine, area: Box) -> NDArray[np.float64] | float:
    """Return the diameters that the offset adds to an area's pixels, (height, width), or 0."""
    if line.focus_offset.is_level:
        return 0.0
    x, y = np.arange(area.x0, area.x1) + 0.5, np.arange(area.y0, area.y1)[:, None] + 0.5
    return -line.per_dioptre_px * line.focus_offset.dioptres_at(x, y)


def lens_diameter_m(lens: Lens) -> float:
    """Return the diameter in meters of the opening that makes the discs of `coc_line`.

    With aperture diameter A, focal length f, image distance v, focus distance S and depth z, the
    diameter A v (1/S - 1/z) on the sensor is f D (1/S - 1/z) for an opening of the diameter
    D = A v / f. This suits a pinhole picture, whose magnification is f / z. The image of a real
    lens lies a little behind the focal length, that of a renderer's lens on it, so that there D is
    the aperture.
    """
    return -_per_dioptre_mm(lens) / lens.focal_length_mm


def axial_px(lens: Lens, display_width_px: int) -> float:
    """Return the signed difference in disc diameter of blue and green, and of green and red.

    For light that focuses a distance d farther behind the lens, the sensor is too near by d. With
    aperture diameter A and image distance v, this changes the diameter of a disc by A d / v.
    """
    shift_mm = lens.axial_colour_mm / 2
    wider_mm = shift_mm * _focal_over_image_distance(lens) / lens.f_stop
    return wider_mm * display_width_px / lens.sensor_width_mm


def axial_dioptres(lens: Lens) -> float:
    """Return 1 / focus distance in blue minus that in green, and in green minus that in red.

    This makes discs wider by `axial_px`.
    """
    return axial_px(lens, 1) * lens.sensor_width_mm / -_per_dioptre_mm(lens)


def sharp_px(lens: Lens, display_width_px: int) -> float:
    """Return the diameter in pixels up to which a point counts as sharp."""
    return lens.coc_limit_mm * display_width_px / lens.sensor_width_mm


def hyperfocal_m(lens: Lens) -> float:
    """Return the nearest focus distance, in meters, at which infinity still looks sharp.

    With aperture diameter A, focal length f, image distance v, focus distance S and acceptable
    circle of confusion c, a point at infinity makes a disc of diameter A v / S. That equals c for
    S = f + A f / c with a real lens, and for S = A f / c with a renderer's, whose image does not
    move. c applies to the height of the disc, which a squeeze does not change.
    """
    f_mm = lens.focal_length_mm
    nearest_mm = f_mm if lens.model.facts.image_moves else 0.0
    return 1e-3 * (nearest_mm + lens.aperture_diameter_mm * f_mm / lens.coc_limit_mm)


def near_limit_m(lens: Lens) -> float:
    """Return the nearest depth in meters that looks sharp: its disc is as large as is allowed."""
    return 1.0 / (1.0 / lens.focus_distance_m + sharp_dioptres(lens))


def far_limit_m(lens: Lens) -> float:
    """Return the farthest depth in meters that looks sharp: its disc is as large as is allowed.

    It is infinite from the hyperfocal distance on.
    """
    dioptres = 1.0 / lens.focus_distance_m - sharp_dioptres(lens)
    return 1.0 / dioptres if dioptres > 0 else math.inf


def depth_of_field_m(lens: Lens) -> float:
    """Return the distance from the near to the far limit; infinite from the hyperfocal on."""
    return far_limit_m(lens) - near_limit_m(lens)


def sharp_dioptres(lens: Lens) -> float:
    """Return how far from the focus, in 1/m and to either side, a point still looks sharp."""
    return lens.coc_limit_mm / -_per_dioptre_mm(lens)


def _per_dioptre_mm(lens: Lens) -> float:
    """Return the diameter on the sensor in mm for each dioptre from the focus.

    It is -A v, aperture diameter times image distance, without a special case for infinity.
    """
    f_mm = lens.focal_length_mm
    return -1e-3 * lens.aperture_diameter_mm * f_mm / _focal_over_image_distance(lens)


def _focal_over_image_distance(lens: Lens) -> float:
    """Return focal length over image distance, f / v, of the lens at its focus distance."""
    return lens.model.focal_over_image_distance(lens.focal_length_mm, lens.focus_distance_m)
