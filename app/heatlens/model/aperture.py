"""The opening of the lens: the one place on the processor that knows its shape.

An `Aperture` is the shape alone. Its coordinates are in radii of the round lens of the same f-stop:
u to the right and v up, seen from behind the lens. A `Pupil` is an aperture of a size in metres,
through which a scene is seen. A `DiscShape` is the image of an aperture in the pixels of a picture,
which is what a point of light out of focus becomes. The file shaders/lib/aperture.lib.glsl says the
same on the GPU; tests/defocus/test_aperture_on_gpu.py holds the two against each other.

A new property of the opening is a field of `Aperture` and of `Lens`, a uniform in `_uniforms`, and
its geometry here and in that file. Passes, renderers and samplers ask these values and need no
change.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.errors import LensError

SQUEEZE_LEAST, SQUEEZE_MOST = 1.0, 2.0
# The centre of a disc has no direction to its rim; nearer than this, in pixels, is the centre.
_CENTRE_PX = 1e-6

Array = NDArray[np.float64]
Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Aperture:
    """The shape of the opening; without arguments a round one.

    squeeze   1 spherical to 2 anamorphic: the opening is this many times as tall as wide

    Raises LensError naming the value and what it may be.
    """

    squeeze: float = 1.0

    def __post_init__(self) -> None:
        if not SQUEEZE_LEAST <= self.squeeze <= SQUEEZE_MOST:
            raise LensError(
                f"The squeeze must be between {SQUEEZE_LEAST:g} (spherical) and {SQUEEZE_MOST:g} "
                f"(anamorphic), got {self.squeeze:g}."
            )

    @property
    def half_extents(self) -> Pair:
        """Half the width and height of the box around the opening, in radii."""
        return 1.0 / self.squeeze, 1.0

    @property
    def area(self) -> float:
        """Area in square radii; pi for a round opening."""
        across, up = self.half_extents
        return math.pi * across * up

    def covers(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.bool_]:
        """Return whether light passes at the points (u, v), of the shape of the arguments."""
        across, up = self.half_extents
        return np.asarray(np.hypot(np.divide(u, across), np.divide(v, up)) <= 1.0)

    def points(self, square: Array, radius: float = 1.0) -> Array:
        """Return the points (n, 2) of the opening that belong to `square` (n, 2) in [0, 1)^2.

        Equal areas of the square become equal areas of the opening, so that even points stay even.
        `radius` is that of the lens and gives the points its unit. Neighbours stay neighbours,
        as quasi-random points need it: this is the concentric map of Shirley and Chiu 1997.
        """
        across, up = self.half_extents
        return _concentric_disc(square) * (across * radius, up * radius)


@dataclass(frozen=True, slots=True)
class Pupil:
    """An aperture of a size, as a scene is seen through it.

    radius_m   radius of the round lens of the same f-stop in metres; 0 is a pinhole
    """

    aperture: Aperture
    radius_m: float

    @property
    def half_extents_m(self) -> Pair:
        """Half the width and height of the opening in metres."""
        across, up = self.aperture.half_extents
        return across * self.radius_m, up * self.radius_m

    def points_m(self, square: Array) -> Array:
        """Return points (n, 2) of the opening in metres; see `Aperture.points`."""
        return self.aperture.points(square, self.radius_m)

    @property
    def uniforms(self) -> dict[str, object]:
        """Uniforms of lib/aperture.lib.glsl; the unit of the shader is the metre."""
        return _uniforms(self.half_extents_m)


PINHOLE = Pupil(Aperture(), 0.0)


@dataclass(frozen=True, slots=True)
class DiscShape:
    """The image of an aperture in a picture: the disc that a point of light becomes.

    Offsets are in pixels from the centre of the disc, x to the right and y down. A radius is half a
    signed circle of confusion: at radius r the point (u, v) of the aperture lights the offset
    (r u, -r v pixel_aspect_ratio), so that in front of the focus the image stands on its head.

    pixel_aspect_ratio   width of a pixel over its height: where pixels are wide, the same length
                         covers more of them going down
    """

    aperture: Aperture = Aperture()
    pixel_aspect_ratio: float = 1.0

    @property
    def half_extents(self) -> Pair:
        """Half the width and height of the box around the disc for each pixel of radius."""
        across, up = self.aperture.half_extents
        return across, up * self.pixel_aspect_ratio

    @property
    def spreads(self) -> Pair:
        """Standard deviations along x and y over those of a round disc of the same radius.

        This is by how much a diffusion, which knows no shape, has to blur along each axis.
        """
        return self.half_extents

    def light(self, radius_px: float, ramp_px: float) -> float:
        """Return the sum of `coverage` over all pixels of a large disc, to a close approximation.

        It is exact for a round disc, and for any other as long as the ramp is short beside it.
        """
        area = self.aperture.area * self.pixel_aspect_ratio
        return radius_px**2 * area + math.pi * ramp_px**2 / 3

    def coverage(self, x: ArrayLike, y: ArrayLike, radius_px: float, ramp_px: float) -> Array:
        """Return how much of the pixels at the offsets (x, y) is covered, from 0 to 1.

        The rim is a ramp of half width `ramp_px` all around. The distance to it is to first order:
        the implicit function of the opening over the length of its gradient.
        """
        across, down = self.half_extents
        u, v = np.divide(x, across), np.divide(y, down)
        from_centre = np.maximum(np.hypot(u, v), _CENTRE_PX)
        gradient = np.hypot(u / across, v / down) / from_centre
        gradient = np.where(from_centre <= _CENTRE_PX, 1 / min(across, down), gradient)
        to_rim = (abs(radius_px) - from_centre) / gradient
        return np.asarray(np.clip((to_rim + ramp_px) / (2 * ramp_px), 0, 1))

    @property
    def uniforms(self) -> dict[str, object]:
        """Uniforms of lib/aperture.lib.glsl; the unit of the shader is the pixel."""
        return _uniforms(self.half_extents)


def _uniforms(half_axes: Pair) -> dict[str, object]:
    return {"aperture_axes": half_axes}


def _concentric_disc(square: Array) -> Array:
    """Map [0, 1)^2 to the unit disc so that areas are kept and neighbours stay near."""
    x, y = (2.0 * square - 1.0).T
    is_wide = np.abs(x) > np.abs(y)
    radius = np.where(is_wide, x, y)
    other = np.where(is_wide, y, x)
    share = np.divide(other, radius, out=np.zeros_like(radius), where=radius != 0)
    angle = np.where(is_wide, np.pi / 4 * share, np.pi / 2 - np.pi / 4 * share)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
