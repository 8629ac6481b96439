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
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.focus_offset import LEVEL, FocusOffset
from heatlens.core.model.lens.lens import Lens

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
