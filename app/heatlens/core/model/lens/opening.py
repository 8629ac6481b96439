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
center of the picture, they shift to opposite sides. The disc is the light that passes both: a cat's
eye with the same center as the full disc.
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
_TINY = 1e-12  # least distance from the middle, so that nothing is divided by 0
_TABLE_ANGLES = 257  # angles of a blade in a table
_ANGLES = 720  # angles of the quadrature; corners make its error second order


class Blades(NamedTuple):
    """The blades of a diaphragm.

    number     how many there are; 0 for a round diaphragm
    turn       angle of the first corner, radians
    curvature  0 for straight blades to 1 for arcs of the round opening
    """

    number: int
    turn: float
    curvature: float


class Barrel(NamedTuple):
    """The two circles of the barrel, seen from a position in the picture.

    Light passes at a point p where |p + shift| and |p - shift| are at most `radius`.
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
    half_angle = math.pi / blades.number
    sector = np.floor((np.arctan2(y, x) - blades.turn) / (2 * half_angle))
    chord_angle = blades.turn + (2 * sector + 1) * half_angle  # towards the middle of the blade
    out_x, out_y = np.cos(chord_angle), np.sin(chord_angle)
    sine, straightness = math.sin(half_angle), _straightness(blades.curvature, half_angle)
    outward = x * out_x + y * out_y - math.cos(half_angle)
    sideways = out_x * y - out_y * x
    bow = blades.curvature * (outward**2 + sideways**2 - sine**2) / 2
    gradient_out = blades.curvature * outward + straightness
    gradient_side = blades.curvature * sideways
    gradient_x = gradient_out * out_x - gradient_side * out_y
    gradient_y = gradient_out * out_y + gradient_side * out_x
    return bow + straightness * outward, gradient_x, gradient_y


# The barrel is two circles, its front and its rear rim, shifted by `shift` to either side. Light
# must pass both circles, so the one that is farther from the point decides, and by symmetry a sign
# tells which one this is. With one circle alone, the middle of a disc would move towards the
# corner; the diffusion cannot move its blur, so that the discs of highlights would lie beside the
# blur of their surroundings.
def past_barrel(x: Array, y: Array, barrel: Barrel) -> tuple[Array, Array, Array]:
    """Return the signed distance of points from the edge of the barrel, and its gradient.

    The distance is negative inside, as in `past_blades`.
    """
    side = np.where(x * barrel.shift[0] + y * barrel.shift[1] < 0, -1.0, 1.0)
    across, up = x + side * barrel.shift[0], y + side * barrel.shift[1]
    from_middle = np.maximum(np.hypot(across, up), _TINY)
    return from_middle - barrel.radius, across / from_middle, up / from_middle


def profile(square: ArrayLike, rim: float) -> Array:
    """Return the brightness of a disc at a squared distance from its middle, 0 to 1.

    `rim` is -1 for a disc that fades towards its rim, 0 for a flat one, 1 for a bright ring. The
    mean over the unit disc is always 1.
    """
    share = np.asarray(square, np.float64)
    weight = share if rim > 0 else 1 - share
    return np.asarray(1 + RIM_MOST * abs(rim) * ((RIM_POWER + 1) * weight**RIM_POWER - 1))


def rim_radius(angle: Array, blades: Blades, barrel: Barrel | None) -> Array:
    """Return how far the opening reaches from its middle, in radii, at each angle in radians."""
    radius = _blade_radius(angle, blades)
    return radius if barrel is None else np.minimum(radius, _barrel_radius(angle, barrel))


# The map keeps areas, because the sample points of the lens must stay evenly spread: another map
# would crowd them in the corners of a blade. The area up to an angle has no simple inverse, so it
# is looked up in a table.
def map_to_blades(points: Array, blades: Blades) -> Array:
    """Return points (n, 2) of the unit disc moved into the opening; equal areas stay equal."""
    angle = np.arctan2(points[:, 1], points[:, 0]) - blades.turn
    sector = 2 * math.pi / blades.number
    corner = np.floor(angle / sector)
    table_angles, table_areas = _areas_from_corner(blades)
    angle = (
        blades.turn
        + sector * corner
        + np.interp(angle - sector * corner, table_areas, table_angles)
    )
    radius = np.hypot(*points.T) * rim_radius(angle, blades, barrel=None)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


@lru_cache(maxsize=16)
def _areas_from_corner(blades: Blades) -> tuple[Array, Array]:
    """Return angles from a corner to the next, and the area from the corner up to each.

    An area is given as the angle of a disc's sector that has the same share of the area.
    """
    sector = 2 * math.pi / blades.number
    angle = np.linspace(0.0, sector, _TABLE_ANGLES)
    square = rim_radius(angle + blades.turn, blades, barrel=None) ** 2
    area = np.concatenate([[0.0], np.cumsum(square[1:] + square[:-1])])
    return angle, area * (sector / area[-1])


def light(blades: Blades, barrel: Barrel | None, rim: float) -> float:
    """Return the integral of `profile` over the opening, in square radii; pi for a round one."""
    angle, step = _angles()
    square = rim_radius(angle, blades, barrel) ** 2
    # Twice the integral of the rim's brightness times the radius, from the middle to the edge.
    if rim < 0:
        rim_term = 1 - (1 - square) ** (RIM_POWER + 1)
    else:
        rim_term = square ** (RIM_POWER + 1)
    return float(np.sum(square + RIM_MOST * abs(rim) * (rim_term - square)) * step / 2)


def variance(blades: Blades, rim: float) -> float:
    """Return the variance of the light along an axis, radii^2, without a barrel; 1/4 if round.

    Regular polygons have the same along every axis.
    """
    angle, step = _angles()
    square = rim_radius(angle, blades, barrel=None) ** 2
    # The integral of s^2 profile(s^2) s ds, by Gauss and Legendre exact for its polynomial in s^2.
    nodes, weights = np.polynomial.legendre.leggauss(RIM_POWER + 2)
    squares = square[:, None] * (nodes + 1) / 2
    moment = np.sum(squares * profile(squares, rim) * weights, axis=1) * square / 4
    return float(np.sum(moment) * step / 2 / light(blades, barrel=None, rim=rim))


def variances(barrel: Barrel) -> Pair:
    """Return the variance of a round disc that a barrel cuts along x, its shift, and along y."""
    angle, _ = _angles()
    radius = rim_radius(angle, Blades(number=0, turn=0.0, curvature=0.0), barrel)
    area = np.sum(radius**2) / 2
    along, across = (
        float(np.sum(radius**4 * component**2) / 4 / area)
        for component in (np.cos(angle), np.sin(angle))
    )
    return along, across


def _angles() -> tuple[Array, float]:
    """Return the angles of the quadrature over a full turn, and the step between them."""
    step = 2 * math.pi / _ANGLES
    return np.asarray((np.arange(_ANGLES) + 0.5) * step, np.float64), step


def _straightness(curvature: float, half_angle: float) -> float:
    """Return sqrt(1 - c^2 sin^2 h), the linear term of the equation of a blade's arc."""
    return math.sqrt(1 - (curvature * math.sin(half_angle)) ** 2)


# The root stands in the denominator, so that one formula serves for all curvatures and no digits
# cancel. The usual formula divides by the curvature, which is 0 for straight blades.
def _blade_radius(angle: Array, blades: Blades) -> Array:
    """Return the root of the arc's equation along a ray from the middle."""
    if blades.number == 0:
        return np.ones_like(angle)
    half_angle, curvature = math.pi / blades.number, blades.curvature
    sine, cosine = math.sin(half_angle), math.cos(half_angle)
    straightness = _straightness(curvature, half_angle)
    angle_from_chord = np.mod(angle - blades.turn, 2 * half_angle) - half_angle
    linear = (straightness - curvature * cosine) * np.cos(angle_from_chord)
    constant = straightness * cosine - curvature * (cosine**2 - sine**2) / 2
    return 2 * constant / (linear + np.sqrt(linear**2 + 2 * curvature * constant))


def _barrel_radius(angle: Array, barrel: Barrel) -> Array:
    """Return how far light passes the barrel along a ray from the middle, at each angle."""
    along = np.abs(np.cos(angle) * barrel.shift[0] + np.sin(angle) * barrel.shift[1])
    left = barrel.radius**2 - barrel.shift[0] ** 2 - barrel.shift[1] ** 2
    return np.asarray(np.sqrt(along**2 + left) - along)
