"""Cards in front of a wall, seen by a moving pinhole camera; the hidden wall is known exactly."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from heatlens.media.plate.neighbours.view import View
from heatlens.media.plate.of_arrays import plate_of_arrays

SIZE = (48, 72)  # height, width
FOCAL_PX = 80.0
WALL_M = 10.0


@dataclass(frozen=True)
class Card:
    """A rectangle that faces the camera: distance `z`, extents in metres, and its light."""

    z: float
    x: tuple[float, float]
    y: tuple[float, float] = (-9.0, 9.0)
    light: float = 0.9


POST = Card(2.0, (-0.2, 0.2))


def wall_light(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the light (..., 3) of the wall, linear in x and y, so that pixel means are exact."""
    return np.stack([0.5 + 0.03 * x, 0.5 + 0.05 * y, 0.4 - 0.02 * x + 0.01 * y], -1)


def wall_picture(camera_x: float, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Return the picture (H, W, 3) of the wall alone."""
    x, y = _rays(size)
    return wall_light(camera_x + WALL_M * x, WALL_M * y)


def view_of_cards(
    camera_x: float, cards: Sequence[Card] = (POST,), frame: int = 0, size=SIZE
) -> View:
    """Return the frame of a camera at (camera_x, 0, 0) that looks along -z."""
    x, y = _rays(size)
    color, depth = wall_picture(camera_x, size), np.full(size, WALL_M)
    for card in sorted(cards, key=lambda it: -it.z):
        world_x, world_y = camera_x + card.z * x, card.z * y
        is_hit = (card.x[0] <= world_x) & (world_x < card.x[1])
        is_hit &= (card.y[0] <= world_y) & (world_y < card.y[1])
        color[is_hit], depth[is_hit] = card.light, card.z
    plate = plate_of_arrays(color.astype(np.float32), depth.astype(np.float32))
    world_to_camera = np.eye(4)
    world_to_camera[0, 3] = -camera_x
    return View(frame, plate, world_to_camera, (FOCAL_PX, FOCAL_PX), (size[1] / 2, size[0] / 2))


def _rays(size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y (up) of the ray of each pixel, 1 m before the camera."""
    rows, columns = np.mgrid[: size[0], : size[1]] + 0.5
    return (columns - size[1] / 2) / FOCAL_PX, -(rows - size[0] / 2) / FOCAL_PX
