"""Plates of a patterned card that moves in front of a patterned wall, drawn pixel by pixel.

The card is flat and faces the camera, so that its distance and its place are known exactly.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from heatlens.media.plate.plate import Plate
from support.exr_files import write_file
from support.plates import plate_of

WIDTH, HEIGHT, FOCAL_PX = 320, 180, 300.0
WALL_M, POST_M, HALF_M = 8.0, 1.5, 0.5


def _pattern(x, y, seed):
    """Return smooth stripes (..., 4) in three colors, which do not repeat in the picture."""
    waves = np.random.default_rng(seed).normal(0, 9, (3, 6, 3))
    channels = [sum(np.sin(a * x + b * y + c) for a, b, c in wave) for wave in waves]
    return np.stack([*(0.4 + 0.05 * it for it in channels), np.ones_like(x)], -1).clip(0.02, 4)


def _pixels():
    return np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)


def _rays():
    column, row = _pixels()
    return (column - WIDTH / 2) / FOCAL_PX, (row - HEIGHT / 2) / FOCAL_PX


@cache
def _wall():
    x, y = _rays()
    return _pattern(x * WALL_M, y * WALL_M, 1)


@dataclass(frozen=True)
class Walk:
    """A card that goes from `start` to `end` (x, y, distance in m) over the frames.

    `post` holds the left and right edge of a near post in pixels, and is (0, 0) without one.
    """

    frames: int = 24
    start: tuple[float, float, float] = (-0.5, 0.0, 3.0)
    end: tuple[float, float, float] = (0.8, 0.1, 4.0)
    post: tuple[float, float] = (0.0, 0.0)
    grain: float = 0.0
    is_plain: bool = False

    def at(self, frame):
        fraction = (frame - 1) / (self.frames - 1)
        return np.array(self.start) * (1 - fraction) + np.array(self.end) * fraction

    def pixel(self, frame):
        x, y, distance_m = self.at(frame)
        return FOCAL_PX * x / distance_m + WIDTH / 2, FOCAL_PX * y / distance_m + HEIGHT / 2

    def is_hidden(self, frame):
        """Return True where the middle of the card is behind the post or out of the picture."""
        x, y = self.pixel(frame)
        return self.post[0] <= x <= self.post[1] or not (0 <= x < WIDTH and 0 <= y < HEIGHT)

    def plate(self, frame) -> Plate:
        (column, _), (ray_x, ray_y) = _pixels(), _rays()
        x, y, distance_m = self.at(frame)
        color, depth = _wall().copy(), np.full((HEIGHT, WIDTH), WALL_M)
        u, v = ray_x * distance_m - x, ray_y * distance_m - y
        is_card = (np.abs(u) < HALF_M) & (np.abs(v) < HALF_M)
        color[is_card] = 0.5 if self.is_plain else _pattern(u[is_card], v[is_card], 2)
        depth[is_card] = distance_m
        is_post = (column > self.post[0]) & (column < self.post[1])
        color[is_post], depth[is_post] = (0.2, 0.15, 0.1, 1.0), POST_M
        grain = np.random.default_rng(frame).normal(0, self.grain, (*color.shape[:2], 3))
        color[..., :3] += grain
        return plate_of(color.astype(np.float32), depth.astype(np.float32))

    def write(self, path, frame, **header):
        plate = self.plate(frame)
        channels = dict(zip("RGB", np.moveaxis(plate.color, -1, 0), strict=False))
        return write_file(
            path, {**{n: c.copy() for n, c in channels.items()}, "Z": plate.depth_m}, **header
        )
