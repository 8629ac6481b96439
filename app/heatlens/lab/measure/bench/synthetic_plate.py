"""Generate plates in memory, always the same, with everything that costs render time."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.plate import CameraHeader, DepthReport, FloatImage, Plate, ReadPixels

# Wide open and focused between the objects: blur on both sides, in several layers in front.
LENS = Lens(focal_length_mm=50.0, f_stop=1.4, focus_distance_m=3.0, sensor_width_mm=36.0)

_HORIZON = 1 / 3  # share of the height, from the top
_CAMERA_HEIGHT_M = 0.5
_LAMP_LIGHT = (60.0, 40.0, 15.0)  # scene-linear, hundreds of times the ground

# Upright objects: left, right (of the width), top, bottom (of the height), meters away, color.
_POSTS = (
    (0.10, 0.30, 0.20, 0.55, 30.0, (0.45, 0.35, 0.30)),  # a house
    (0.70, 0.78, 0.15, 0.60, 12.0, (0.10, 0.22, 0.08)),  # a tree
    (0.40, 0.48, 0.25, 0.80, 3.0, (0.70, 0.25, 0.15)),  # what the lens is focused on
    (0.60, 0.605, 0.00, 0.90, 1.6, (0.05, 0.05, 0.06)),  # a wire
    (0.85, 0.95, 0.10, 1.00, 1.0, (0.15, 0.30, 0.50)),  # a post by the camera
)
_LAMPS = ((0.15, 0.28), (0.25, 0.28), (0.52, 0.30), (0.66, 0.12), (0.74, 0.22))


def scene_plate(size: tuple[int, int]) -> Plate:
    """Return a textured ground to the horizon, a sky, near and far objects and a few lamps."""
    color, depth_m = _scene(size)
    return _plate(color, depth_m=depth_m)


def scene_coc_px(size: tuple[int, int], lens: Lens = LENS) -> FloatImage:
    """Return the signed circle of confusion of the scene (H, W), diameters in pixels."""
    _, depth_m = _scene(size)
    return np.asarray(coc_px(depth_m, coc_line(lens, size[0])), np.float32)


def lens_with_largest_coc(largest_coc_px: float, size: tuple[int, int]) -> Lens:
    """Return `LENS` with the f-stop at which the scene's largest |coc| is `largest_coc_px`.

    The coc is proportional to 1 / f-stop.
    """
    largest = float(np.max(np.abs(scene_coc_px(size))))
    return replace(LENS, f_stop=LENS.f_stop * largest / largest_coc_px)


def uniform_coc_plate(size: tuple[int, int], diameter_px: float) -> Plate:
    """Return a plate with the same colors and a coc of `diameter_px` behind focus everywhere."""
    width, height = size
    coc = np.full((height, width), diameter_px, np.float32)
    return _plate(_scene(size)[0], coc=coc)


def _scene(size: tuple[int, int]) -> tuple[FloatImage, FloatImage]:
    """Return color (H, W, 3) and depth in meters (H, W)."""
    color, depth_m = _ground_and_sky(size)
    texture = _texture(size)
    width, height = size
    for left, right, top, bottom, away_m, rgb in _POSTS:
        rows, columns = _pixels(top, bottom, height), _pixels(left, right, width)
        depth_m[rows, columns] = away_m
        color[rows, columns] = texture[rows, columns, None] * np.array(rgb, np.float32)
    for x, y in _LAMPS:
        color[int(y * height), int(x * width)] = _LAMP_LIGHT
    return color, depth_m


def _pixels(start: float, stop: float, count: int) -> slice:
    """Return the slice from share to share of `count` pixels, at least one pixel long."""
    return slice(int(start * count), max(int(stop * count), int(start * count) + 1))


def _ground_and_sky(size: tuple[int, int]) -> tuple[FloatImage, FloatImage]:
    """Return color (H, W, 3) and meters (H, W) of a plane `_CAMERA_HEIGHT_M` below the eye."""
    width, height = size
    focal_px = LENS.focal_length_mm / LENS.sensor_width_mm * width
    below_px = np.arange(height, dtype=np.float32)[:, None] + 0.5 - _HORIZON * height
    is_ground = np.broadcast_to(below_px > 0.0, (height, width))
    depth_m = np.where(is_ground, _CAMERA_HEIGHT_M * focal_px / np.maximum(below_px, 0.5), np.inf)
    ground = _texture(size)[..., None] * np.array((0.35, 0.30, 0.22), np.float32)
    color = np.where(is_ground[..., None], ground, np.array((0.45, 0.60, 0.90), np.float32))
    return color.astype(np.float32), depth_m.astype(np.float32)


def _texture(size: tuple[int, int]) -> FloatImage:
    """Return detail at every scale, 0.2 to 1.8, (H, W): waves without a common period."""
    y, x = np.mgrid[: size[1], : size[0]].astype(np.float32)
    waves: NDArray[np.float32] = np.zeros_like(x)
    for k in range(4):
        length_px = np.float32(2.6 * 3.1**k)
        waves += np.sin(x / length_px + k) * np.sin(y / length_px * np.float32(1.3) + 2 * k)
    return np.asarray(1.0 + 0.2 * waves, np.float32)


def _plate(
    color: FloatImage, depth_m: FloatImage | None = None, coc: FloatImage | None = None
) -> Plate:
    """Return a plate of color (H, W, 3) with depth in meters or coc in pixels, (H, W)."""
    height, width = color.shape[:2]
    window = Box(0, 0, width, height)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = color
    convention = DepthConvention.COC if depth_m is None else DepthConvention.DISTANCE
    return Plate(
        path=Path("synthetic"),
        pixels=ReadPixels(color=rgba, depth_m=depth_m, coc_px=coc),
        has_alpha=False,
        data_window=window,
        display_window=window,
        pixel_aspect_ratio=1.0,
        camera=CameraHeader(),
        depth=DepthReport(
            channel="Z",
            convention=convention,
            kind=DepthKind.PLANAR,
            why="synthetic",
            near_m=math.nan,
            far_m=math.nan,
            infinite_count=0,
            repaired_count=0,
        ),
        aovs=("R", "G", "B", "Z"),
        attributes={},
        notes=(),
    )
