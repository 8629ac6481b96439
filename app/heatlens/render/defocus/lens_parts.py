"""Cut the opening of the lens into parts, each with a center, a width and a share of the light."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.lens.disc_shape import DiscShape, Pair
from heatlens.render.gpu.shader_constants import PART_GRID_SIDE

Array = NDArray[np.float64]
_SIDE = 64  # points across the opening at which its light is sampled
_LEAST_LIGHT = 1e-4  # share of the light; parts with less are left out


# A part has the center, the variance and the light of the area of it that is open, because a
# blurred view shows no more of its shape. Against 400 rays a pixel, FLIP fell from .054 to .021
# with five blades, from .060 to .029 with a cat's eye and from .064 to .025 with a heart as the
# opening.
@lru_cache(maxsize=8)
def lens_parts(disc: DiscShape, size: Pair, parts: int) -> Array:
    """Return the parts (n, positions, 4) of the opening as seen from behind the focus.

    Each part has the distance x, y that a point moves for each pixel of its coc, the diameter
    relative to that of the lens, and the share of the light. A plain opening has `parts` of equal
    area. Every other opening has those of these parts that light passes: center, diameter and share
    are those of the open area in the part. An opening that changes over the picture has values at
    PART_GRID_SIDE x PART_GRID_SIDE positions from corner to corner of a picture of `size`, row by
    row; any other has them at one position.
    """
    across, down = disc.half_extents
    parts_at = np.stack(
        [_parts_at(disc, parts, position_px) for position_px in _picture_positions(disc, size)], 1
    )
    # parts that are dark at every position are left out, and the other shares add up to 1 again
    parts_at = parts_at[parts_at[..., 3].max(axis=1) >= _LEAST_LIGHT]
    parts_at[..., 3] /= parts_at[..., 3].sum(axis=0)
    # from radii of the lens to pixels for each pixel of coc, which is a diameter; y runs down
    return np.asarray(parts_at * (across / 2, -down / 2, 1.0, 1.0))


def _picture_positions(disc: DiscShape, size: Pair) -> list[Pair]:
    """Return the pixel positions for which parts are computed; one if all have the same parts."""
    if disc.aperture.cat_eye == 0.0:
        return [(0.0, 0.0)]
    along = np.linspace(0.0, 1.0, PART_GRID_SIDE)
    return [(size[0] * x, size[1] * y) for y in along for x in along]


def _parts_at(disc: DiscShape, parts: int, position_px: Pair) -> Array:
    """Return center x and y in radii of the lens, width and share of light of each part.

    The opening is that which is seen from the position in the picture.
    """
    centers, widths = part_centers(parts), np.full(parts, parts**-0.5)
    if disc.is_plain:
        return np.column_stack([centers, widths, np.full(parts, 1 / parts)])
    # The opening is compared with a round one that was sampled at the same points.
    plain_moments = _moments(DiscShape(), parts, (0.0, 0.0))
    moments = _moments(disc, parts, position_px)
    is_lit = moments[:, 0] > 0.0
    centers[is_lit] += (moments - plain_moments)[is_lit, 1:3]
    widths[is_lit] *= np.sqrt(moments[is_lit, 3] / plain_moments[is_lit, 3])
    shares = moments[:, 0] / plain_moments[:, 0]
    return np.column_stack([centers, widths, shares / shares.sum()])


@lru_cache(maxsize=PART_GRID_SIDE**2)
def _moments(disc: DiscShape, parts: int, position_px: Pair) -> Array:
    """Return light, center x and y, and variance (parts, 4) of the opening within each part.

    Lengths are radii of the lens. The light is a sum over samples, and the variance one over both
    axes. The opening is that which is seen from the position in the picture.
    """
    x, y, part_of_sample = _lens_samples(parts)
    across, down = disc.half_extents
    light = disc.coverage(x * across, -y * down, 1.0, 1 / _SIDE, position_px)
    total, *sums = (
        np.bincount(part_of_sample, light * values, parts) for values in (1.0, x, y, x**2 + y**2)
    )
    x_mean, y_mean, square = (values / np.maximum(total, 1e-9) for values in sums)
    variance = np.maximum(square - x_mean**2 - y_mean**2, 0.0)
    return np.column_stack([total, x_mean, y_mean, variance])


@lru_cache(maxsize=4)
def _lens_samples(parts: int) -> tuple[Array, Array, NDArray[np.intp]]:
    """Return the sample points x and y, -1 to 1, and for each the number of the nearest part."""
    along = (np.arange(_SIDE) + 0.5) * 2 / _SIDE - 1
    x, y = (axis.ravel() for axis in np.meshgrid(along, along))
    centers = part_centers(parts)
    distances = np.hypot(x[:, None] - centers[:, 0], y[:, None] - centers[:, 1])
    return x, y, distances.argmin(axis=1)


def part_centers(parts: int) -> Array:
    """Return the centers (n, 2) of parts of a round lens of radius 1, all of the same area.

    They are in rings of 1, 6, 12, ... parts. Their mean is 0, and with discs of the parts' area
    around them the variances are those of the lens: 1/4 along each axis.
    """
    rings = range(math.isqrt(parts // 3) + 1)
    points = np.concatenate([_ring(6 * k, 3 * k * k) for k in rings])
    # The variance of the centers must be that of the lens less that of a part, 1 / (4 parts).
    spread = 2 * np.mean(points**2)
    return points * math.sqrt((1 - 1 / parts) / 2 / spread) if parts > 1 else points


def _ring(count: int, middle: float) -> Array:
    """Return the centers of a ring of `count` parts; `middle` parts of area lie inside the ring."""
    angle = np.arange(max(count, 1)) * 2 * math.pi / max(count, 1) + 0.2 * count
    return math.sqrt(middle + 0.5 * bool(count)) * np.stack([np.cos(angle), np.sin(angle)], -1)
