"""Generate a scene whose blur is difficult to compute, for measuring the errors of the methods.

Glowing boards stand one behind the other, from a post by the camera to the sky, over a ground that
extends through all depths. Lamps are placed where bright discs cross silhouettes; one is behind the
post, where only a lens sees it.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.measure.bench.synthetic_plate import LENS
from heatlens.model.coc import coc_line, coc_px
from heatlens.model.lens import Lens
from heatlens.scene.scene import Color, Daylight, Instance, Material, Mesh, Scene

NEAREST_M = 1.0  # distance of the nearest board, which has the largest circle of confusion

_ASPECT = 9 / 16  # the boards are placed in a frame of this shape, and shares of it
_BLACK = (0.0, 0.0, 0.0)
_NIGHT = Daylight(sun=_BLACK, zenith=_BLACK, horizon=_BLACK, ground=_BLACK)

# Left, right (of the width), top, bottom (of the height), metres away, colour.
_BOARDS = (
    (-1.0, 2.0, -2.0, 3.0, 40.0, (0.35, 0.50, 0.80)),  # the sky
    (0.08, 0.34, 0.22, 0.60, 20.0, (0.60, 0.45, 0.35)),  # a house
    (0.60, 0.70, 0.12, 0.66, 8.0, (0.10, 0.26, 0.08)),  # a tree
    (0.38, 0.50, 0.25, 0.85, 3.0, (0.75, 0.25, 0.12)),  # what the lens is focused on
    (0.20, 0.21, -0.50, 1.50, 1.6, (0.03, 0.03, 0.04)),  # wires
    (0.27, 0.275, -0.50, 1.50, 1.6, (0.03, 0.03, 0.04)),
    (0.54, 0.546, -0.50, 1.50, 2.2, (0.05, 0.04, 0.03)),
    (0.80, 0.92, 0.12, 1.60, NEAREST_M, (0.12, 0.30, 0.50)),  # a post by the camera
)
_LAMPS = ((0.13, 0.30), (0.265, 0.34), (0.515, 0.20), (0.59, 0.30), (0.72, 0.22), (0.86, 0.30))
_LAMP_M = 12.0
_LAMP_SIDE = 0.01  # of the width
_LAMP_LIGHT = (50.0, 32.0, 12.0)  # scene-linear, hundreds of times the ground
_GROUND_LIGHT = (0.30, 0.26, 0.18)
_GROUND_M = (1.2, 40.0)  # from there to there, _EYE_M below the camera
_EYE_M = 0.5


def truth_scene() -> Scene:
    """Return the boards, the ground and the lamps, before a camera in the origin along -z."""
    boards = [(_board(*board[:5]), board[5], 0) for board in _BOARDS]
    lamps = [(_board(*_around(x, y), _LAMP_M), _LAMP_LIGHT, None) for x, y in _LAMPS]
    things = [*boards, (_ground(), _GROUND_LIGHT, 0), *lamps]
    return Scene(
        Path("synthetic"),
        tuple(replace(mesh, material=at) for at, (mesh, _, _) in enumerate(things)),
        tuple(Instance(f"{at}", at, np.eye(4)) for at in range(len(things))),
        tuple(_shining(light, picture) for _, light, picture in things),
        (_picture(),),
        daylight=_NIGHT,
    )


def truth_lens(largest_coc_px: float, width_px: int) -> Lens:
    """Return `LENS` with the f-stop at which the nearest board's |coc| is the one given.

    The coc is proportional to 1 / f-stop.
    """
    nearest = abs(float(coc_px(NEAREST_M, coc_line(LENS, width_px))))
    return replace(LENS, f_stop=LENS.f_stop * nearest / largest_coc_px)


def _shining(light: Color, picture: int | None) -> Material:
    return Material("light", _BLACK, emission=light, emission_map=picture)


def _around(x: float, y: float) -> tuple[float, float, float, float]:
    """Return left, right, top and bottom of a lamp whose centre is (x, y)."""
    half_x, half_y = _LAMP_SIDE / 2, _LAMP_SIDE / 2 / _ASPECT
    return x - half_x, x + half_x, y - half_y, y + half_y


def _board(left: float, right: float, top: float, bottom: float, away_m: float) -> Mesh:
    """Return a board upright across the view.

    Its texture is equally fine on screen at any distance.
    """
    u, v = np.array((left, right, right, left)), np.array((bottom, bottom, top, top))
    frame_m = away_m * LENS.sensor_width_mm / LENS.focal_length_mm
    x, y = frame_m * (u - 0.5), -frame_m * _ASPECT * (v - 0.5)
    positions = np.stack([x, y, np.full(4, -away_m)], axis=1)
    return _quad(positions, (0.0, 0.0, 1.0), 2.0 * np.stack([u, v * _ASPECT], axis=1))


def _ground() -> Mesh:
    near, far = _GROUND_M
    x, z = np.array((-far, far, far, -far)), np.array((-near, -near, -far, -far))
    positions = np.stack([x, np.full(4, -_EYE_M), z], axis=1)
    return _quad(positions, (0.0, 1.0, 0.0), 0.25 * np.stack([x, z], axis=1))


def _quad(corners: ArrayLike, normal: ArrayLike, uvs: ArrayLike) -> Mesh:
    return Mesh(
        np.asarray(corners, np.float32),
        np.tile(np.asarray(normal, np.float32), (4, 1)),
        np.asarray(uvs, np.float32),
        np.array(((0, 1, 2), (0, 2, 3)), np.uint32),
    )


def _picture(side: int = 128) -> NDArray[np.uint8]:
    """Return (side, side, 4) waves at several scales that repeat without a seam."""
    v, u = math.tau * np.mgrid[:side, :side] / side
    waves = sum(np.sin(n * u + n) * np.sin((n + 1) * v) for n in (1, 3, 8))
    grey = np.rint(255 * (0.7 + 0.1 * np.asarray(waves)))
    return np.stack([grey, grey, grey, np.full_like(grey, 255)], axis=-1).astype(np.uint8)
