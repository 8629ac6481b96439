"""The geometry of an opening that is more than an ellipse, in NumPy.

Points are in the plane of the lens, in radii of the round lens of the same f-stop and before the
squeeze: x to the right and y up, seen from behind the lens. The file
shaders/lib/shaped_aperture.lib.glsl has the same functions;
tests/render/defocus/test_aperture_on_gpu.py compares the two.

Blades are arcs between corners on the unit circle. With the half angle h = pi / blades and a point
(x, y) relative to the middle of its blade's chord, x outwards, the arc of curvature c is where

    c / 2 (x^2 + y^2 - sin^2 h) + sqrt(1 - c^2 sin^2 h) x = 0

which is a straight line for c = 0 and the unit circle for c = 1. The gradient has length 1 there.

The barrel of the lens ends in a circle at the front and another at the back. Seen from off the
centre of the picture, they shift to opposite sides. The disc is the light that passes both: a cat's
eye with the same centre as the full disc.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Pair = tuple[float, float]

# The power of the profile of a bright or soft rim; see `profile`.
RIM_POWER = 2
RIM_MOST = 0.98  # some light is left at every point, so that every pixel gets some
FIELD_STEPS = 9  # steps from the middle of a picture to its corner for tabulated variances
_TINY = 1e-12
_TABLE = 257  # angles of a blade in a table
_ANGLES = 720  # angles of the quadrature; corners make its error second order


class Blades(NamedTuple):
    """The diaphragm: blades 0 for a round one; the first corner's angle in radians."""

    number: int
    turn: float
    curvature: float


class Barrel(NamedTuple):
    """The circles of the barrel, seen from a place in the picture.

    |p + shift| and |p - shift| are at most the radius for a point p that lets light through.
    """

    shift: Pair
    radius: float


def past_blades(x: Array, y: Array, blades: Blades) -> tuple[Array, Array, Array]:
    """Return the signed distance of points from the diaphragm, negative inside, and its gradient.

    The distance is a first-order estimate, in radii.
    """
    if blades.number == 0:
        from_middle = np.maximum(np.hypot(x, y), _TINY)
        return from_middle - 1.0, x / from_middle, y / from_middle
    half = math.pi / blades.number
    sector = np.floor((np.arctan2(y, x) - blades.turn) / (2 * half))
    middle = blades.turn + (2 * sector + 1) * half
    out_x, out_y = np.cos(middle), np.sin(middle)
    sine, straight = math.sin(half), _straightness(blades.curvature, half)
    across = x * out_x + y * out_y - math.cos(half)
    along = out_x * y - out_y * x
    bent = blades.curvature * (across**2 + along**2 - sine**2) / 2
    outwards, aside = blades.curvature * across + straight, blades.curvature * along
    gradient_x, gradient_y = outwards * out_x - aside * out_y, outwards * out_y + aside * out_x
    return bent + straight * across, gradient_x, gradient_y


# Both circles let the light pass, so the one that is farther from the point decides, and by
# symmetry its side is known from a sign. A disc that only one circle cut would move its middle
# towards the corner, and what is diffused cannot be moved: lamps would stand beside their blur.
def past_barrel(x: Array, y: Array, barrel: Barrel) -> tuple[Array, Array, Array]:
    """Return the same as `past_blades`, for the barrel."""
    side = np.where(x * barrel.shift[0] + y * barrel.shift[1] < 0, -1.0, 1.0)
    across, up = x + side * barrel.shift[0], y + side * barrel.shift[1]
    from_middle = np.maximum(np.hypot(across, up), _TINY)
    return from_middle - barrel.radius, across / from_middle, up / from_middle


def profile(square: ArrayLike, rim: float) -> Array:
    """Return the brightness of a disc at a squared distance from its middle, 0 to 1.

    `rim` is -1 for a disc that fades towards its rim, 0 for a flat one, 1 for a bright ring. The
    mean over the unit disc is always 1.
    """
    part = np.asarray(square, np.float64)
    bright = part if rim > 0 else 1 - part
    return np.asarray(1 + RIM_MOST * abs(rim) * ((RIM_POWER + 1) * bright**RIM_POWER - 1))


def rim_radius(angle: Array, blades: Blades, barrel: Barrel | None) -> Array:
    """Return how far the opening reaches from its middle, in radii, at each angle in radians."""
    reach = _blade_radius(angle, blades)
    return reach if barrel is None else np.minimum(reach, _barrel_radius(angle, barrel))


# Parts of the lens and views of a scene are evenly spread points, and any other map would crowd
# them in the corners of a blade. The area up to an angle has no simple inverse, so it is looked up.
def between_blades(points: Array, blades: Blades) -> Array:
    """Return points (n, 2) of the unit disc moved into the opening; equal areas stay equal."""
    angle = np.arctan2(points[:, 1], points[:, 0]) - blades.turn
    sector = 2 * math.pi / blades.number
    corner = np.floor(angle / sector)
    known, area = _areas_from_corner(blades)
    angle = blades.turn + sector * corner + np.interp(angle - sector * corner, area, known)
    reach = np.hypot(*points.T) * rim_radius(angle, blades, None)
    return np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=-1)


@lru_cache(maxsize=16)
def _areas_from_corner(blades: Blades) -> tuple[Array, Array]:
    """Return angles from a corner to the next, and the area up to each as the angle of a disc."""
    sector = 2 * math.pi / blades.number
    angle = np.linspace(0.0, sector, _TABLE)
    square = rim_radius(angle + blades.turn, blades, None) ** 2
    area = np.concatenate([[0.0], np.cumsum(square[1:] + square[:-1])])
    return angle, area * (sector / area[-1])


def light(blades: Blades, barrel: Barrel | None, rim: float) -> float:
    """Return the integral of `profile` over the opening, in square radii; pi for a round one."""
    angle, step = _angles()
    square = rim_radius(angle, blades, barrel) ** 2
    if rim < 0:
        bright = 1 - (1 - square) ** (RIM_POWER + 1)
    else:
        bright = square ** (RIM_POWER + 1)
    return float(np.sum(square + RIM_MOST * abs(rim) * (bright - square)) * step / 2)


def variance(blades: Blades, rim: float) -> float:
    """Return the variance of the light along an axis, radii^2, without a barrel; 1/4 if round.

    Regular polygons have the same along every axis.
    """
    angle, step = _angles()
    square = rim_radius(angle, blades, None) ** 2
    # The integral of s^2 profile(s^2) s ds, by Gauss and Legendre exact for its polynomial in s^2.
    nodes, weights = np.polynomial.legendre.leggauss(RIM_POWER + 2)
    part = square[:, None] * (nodes + 1) / 2
    moment = np.sum(part * profile(part, rim) * weights, axis=1) * square / 4
    return float(np.sum(moment) * step / 2 / light(blades, None, rim))


def variances(barrel: Barrel) -> Pair:
    """Return the variance of a round disc that a barrel cuts along x, its shift, and along y."""
    angle, _ = _angles()
    reach = rim_radius(angle, Blades(0, 0.0, 0.0), barrel)
    area = np.sum(reach**2) / 2
    along, across = (
        float(np.sum(reach**4 * part**2) / 4 / area) for part in (np.cos(angle), np.sin(angle))
    )
    return along, across


def _angles() -> tuple[Array, float]:
    step = 2 * math.pi / _ANGLES
    return np.asarray((np.arange(_ANGLES) + 0.5) * step, np.float64), step


def _straightness(curvature: float, half: float) -> float:
    return math.sqrt(1 - (curvature * math.sin(half)) ** 2)


# The usual formula for the root divides by the curvature, which is 0 for straight blades. With the
# root in the denominator one formula serves for all, and no digits cancel.
def _blade_radius(angle: Array, blades: Blades) -> Array:
    """Return the root of the arc's equation along a ray from the middle."""
    if blades.number == 0:
        return np.ones_like(angle)
    half, curvature = math.pi / blades.number, blades.curvature
    sine, cosine = math.sin(half), math.cos(half)
    straight = _straightness(curvature, half)
    aside = np.mod(angle - blades.turn, 2 * half) - half
    linear = (straight - curvature * cosine) * np.cos(aside)
    constant = straight * cosine - curvature * (cosine**2 - sine**2) / 2
    return 2 * constant / (linear + np.sqrt(linear**2 + 2 * curvature * constant))


def _barrel_radius(angle: Array, barrel: Barrel) -> Array:
    along = np.abs(np.cos(angle) * barrel.shift[0] + np.sin(angle) * barrel.shift[1])
    left = barrel.radius**2 - barrel.shift[0] ** 2 - barrel.shift[1] ** 2
    return np.asarray(np.sqrt(along**2 + left) - along)
