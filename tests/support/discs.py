"""The disc of a lens in closed form, and the size of one that was rendered."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

TAILS_PX = 30.0
Picture = NDArray[np.float64]


def size_for(diameter: float) -> int:
    """Return an odd picture width that includes the tails of a blurred disc of `diameter` px."""
    return int((3 if diameter <= TAILS_PX else 1.5) * diameter) // 2 * 2 + 31


def analytic_disc(diameter: float, samples: int = 16) -> Picture:
    """Return an antialiased disc (S, S): its share of each pixel's area, with sum 1."""
    side = size_for(diameter)
    positions = (np.arange(side * samples) + 0.5) / samples - 0.5 - side // 2
    rows = [
        (y[:, None] ** 2 + positions**2 <= diameter**2 / 4)
        .reshape(samples, side, samples)
        .mean((0, 2))
        for y in positions.reshape(side, samples)
    ]
    return np.array(rows) / np.sum(rows)


def radius_at_half_height(picture: Picture, diameter: float) -> float:
    """Return the mean radius over 32 directions where the disc falls to half its inner mean."""
    side = len(picture)
    y, x = np.mgrid[:side, :side] - side // 2
    plateau = picture[np.hypot(x, y) <= diameter / 4].mean()
    ray_radii = np.arange(0, side / 2 - 1, 0.02)
    radii = []
    for angle in np.linspace(0, np.pi / 2, 32, endpoint=False):
        ray = [side // 2 + ray_radii * np.sin(angle), side // 2 + ray_radii * np.cos(angle)]
        radii.append(
            ray_radii[np.flatnonzero(map_coordinates(picture, ray, order=1) > plateau / 2)[-1]]
        )
    return float(np.mean(radii))
