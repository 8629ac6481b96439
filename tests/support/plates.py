"""Plates made in memory, and lenses of a known blur, for tests of the renderer."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.plate import CameraHeader, DepthReport, Plate, ReadPixels

Image = npt.NDArray[np.float32]

FOCUS_M = 2.0
FAR_M = 4.0  # where `lens_blurring` puts its circle of confusion; NEAR_M has the same, in front
NEAR_M = 4.0 / 3.0


def plate_of(color: Image, depth_m: Image, **changes: object) -> Plate:
    """Make a plate of `color` (H, W, 3 or 4) at `depth_m` (H, W), whole and opaque."""
    height, width = depth_m.shape
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., : color.shape[2]] = color
    window = Box(0, 0, width, height)
    plate = Plate(
        path=Path("made.exr"),
        pixels=ReadPixels(rgba, depth_m.astype(np.float32)),
        has_alpha=False,
        data_window=window,
        display_window=window,
        pixel_aspect_ratio=1.0,
        camera=CameraHeader(),
        depth=report_of(depth_m),
        aovs=("R", "G", "B", "Z"),
        attributes={},
        notes=(),
    )
    return replace(plate, **changes)  # type: ignore[arg-type]


def report_of(depth_m: Image) -> DepthReport:
    """Return the range of `depth_m` as the reader would report it."""
    finite = depth_m[np.isfinite(depth_m)]
    near_m, far_m = (float(finite.min()), float(finite.max())) if finite.size else (math.inf,) * 2
    infinite = int(np.count_nonzero(np.isinf(depth_m)))
    return DepthReport(
        "Z", DepthConvention.DISTANCE, DepthKind.PLANAR, "made", near_m, far_m, infinite, 0
    )


def coc_plate_of(color: Image, coc_px: Image) -> Plate:
    """Make a plate of `color` with its signed circle of confusion (H, W) in pixels."""
    report = DepthReport(
        "coc", DepthConvention.COC, DepthKind.PLANAR, "made", math.nan, math.nan, 0, 0
    )
    plate = plate_of(color, np.ones(coc_px.shape, np.float32))
    pixels = ReadPixels(plate.color, coc_px=coc_px.astype(np.float32))
    return replace(plate, pixels=pixels, depth=report)


def lens_blurring(coc_px: float, display_width_px: int, squeeze: float = 1.0) -> Lens:
    """Return a lens whose disc is `coc_px` across at FAR_M and -`coc_px` at NEAR_M.

    From coc = f^2 / (N (S - f)) * (1 - S / z) * W / w, solved for N: 1 - S / z is a half at FAR_M.
    """
    focal_mm, sensor_mm = 50.0, 36.0
    wide_open_mm = focal_mm**2 / (FOCUS_M * 1e3 - focal_mm) * (1 - FOCUS_M / FAR_M)
    f_stop = wide_open_mm * display_width_px / sensor_mm / coc_px
    return Lens(focal_mm, f_stop, FOCUS_M, sensor_mm, squeeze=squeeze)


def room(width: int = 96, height: int = 54) -> tuple[Image, Image]:
    """Return colour (H, W, 3) and depth (H, W) of a room with a ball, a post and two lamps.

    A tiled ground runs to a bright sky. Silhouettes are not anti-aliased. Everything a layer is cut
    for is there: near and thin, far, infinitely far, and a surface through all of it.
    """
    y, x = np.mgrid[:height, :width].astype(np.float32)
    horizon = height // 3
    below = np.maximum(y - horizon, 0.0)
    depth = np.where(y >= horizon, 12.0 / (1.0 + below * 13.0 / height), np.inf)
    tiles = (x // 4 + y // 4) % 2
    color = np.where(y[..., None] < horizon, (0.5, 0.6, 0.8), (0.3 + 0.2 * tiles)[..., None])
    ball = (x - 0.62 * width) ** 2 + (y - 0.5 * height) ** 2 < (0.2 * height) ** 2
    post = abs(x - 0.23 * width) < 0.045 * width
    color[ball], depth[ball] = (0.7, 0.2, 0.1), 2.0
    color[ball & (x % 4 < 2)] = (0.5, 0.3, 0.1)
    color[post], depth[post] = (0.1, 0.4, 0.2), 0.9
    color[height // 10, int(0.42 * width)] = 40.0
    color[height // 5, int(0.83 * width)] = (20.0, 12.0, 4.0)
    return color.astype(np.float32), depth.astype(np.float32)


def wires_and_lamps(width: int = 96, height: int = 54) -> tuple[Image, Image]:
    """Return colour (H, W, 3) and depth (H, W) of wires in front of a dark street with lamps.

    The wires are anti-aliased in colour and one sample in depth, as a renderer writes them: two
    thin ones and a cable, at three distances. Behind them is a wall, and lamps at two distances,
    some of them behind a wire.
    """
    finer = 4
    y, x = (np.mgrid[: finer * height, : finer * width] + 0.5).astype(np.float32) / finer
    color = np.stack([0.02 + 0.05 * y / height, 0.03 + 0.04 * x / width, 0.06 + 0.0 * x], -1)
    depth = np.full(x.shape, 9.0, np.float32)
    bricks = (y // 6 % 2 + x // 9) % 2 < 1
    color[bricks] *= 1.6
    lamps = [(0.2, 0.3, 60.0), (0.52, 0.22, 90.0), (0.78, 0.6, 40.0), (0.4, 0.75, 25.0)]
    for number, (across, down, light) in enumerate(lamps):
        lamp = (x - across * width) ** 2 + (y - down * height) ** 2 < 1.5**2
        color[lamp] = light * np.float32([1.0, 0.8, 0.5] if number % 2 else [0.6, 0.8, 1.0])
        depth[lamp] = 9.0 if number % 2 else 5.0
    wires = [(0.1, 0.7, 0.9, 1.0, 2.4), (0.9, -0.5, 0.8, 1.6, 1.2), (0.3, 0.05, 0.6, 2.6, 1.2)]
    for start, slope, grey, depth_m, thick_px in wires:
        wire = abs(y - start * height - slope * (x - width / 2)) < thick_px / 2
        color[wire], depth[wire] = 0.25 * grey, depth_m
    color = color.reshape(height, finer, width, finer, 3).mean(axis=(1, 3))
    middle = finer // 2
    return color.astype(np.float32), depth[middle::finer, middle::finer]


def moments(picture: Image) -> tuple[float, float, float]:
    """Return sum, and variances in x and y about the centroid in pixels^2, of the mean of RGB."""
    light = picture[..., :3].mean(axis=2, dtype=np.float64)
    y, x = np.mgrid[: light.shape[0], : light.shape[1]]
    total = light.sum()
    return float(total), _variance(light, x, total), _variance(light, y, total)


def _variance(
    light: npt.NDArray[np.float64], coordinates: npt.NDArray[np.int64], total: float
) -> float:
    centre = (light * coordinates).sum() / total
    return float((light * (coordinates - centre) ** 2).sum() / total)
