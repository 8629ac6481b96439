"""Hair before a window with dark bars in focus: bars stay dark, also with neighboring frames."""

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.neighbours.found import with_neighbours
from heatlens.media.plate.neighbours.view import View
from heatlens.media.plate.plate import Plate
from support.plates import Image, plate_of

HEIGHT, WIDTH, SAMPLES = 48, 128, 8  # SAMPLES across and down in each pixel
FOCAL_PX = 300.0
HAIR_M, WALL_M = 1.6, 4.2
COC_PX = 24.0  # of the hair, with the focus on the wall
BAR, WINDOW = 0.03, 1.4
STEP_M = 0.03  # of the camera, sideways, from frame to frame
INSIDE = np.s_[6:-6, 16:-16]  # beyond it the border matters
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def wall_light(x_m: Image) -> Image:
    return np.where(abs(x_m / WALL_M * FOCAL_PX % 40 - 20) < 6, BAR, WINDOW)


def hair_light(x_m: Image, y_m: Image) -> Image:
    """Return the light (H, W) of strands of .4 to 1.5 pixels; nan beside them."""
    rng, light = np.random.default_rng(4), np.full(x_m.shape, np.nan)
    for _ in range(24):
        at_px, slope, width_px = rng.uniform(-50, 50), rng.uniform(-0.3, 0.3), rng.uniform(0.4, 1.5)
        middle_m = at_px / FOCAL_PX * HAIR_M + slope * y_m
        light[abs(x_m - middle_m) < width_px / 2 / FOCAL_PX * HAIR_M] = rng.uniform(0.02, 0.08)
    return light


def view_through(camera_m: float, samples: int, hair_shift_px: tuple[float, float] = (0.0, 0.0)):
    """Return the light and depth (H, W) at `samples` x `samples` points of each pixel."""
    y_px, x_px = (np.mgrid[: HEIGHT * samples, : WIDTH * samples] + 0.5) / samples
    x_ray, y_ray = (x_px - WIDTH / 2) / FOCAL_PX, (y_px - HEIGHT / 2) / FOCAL_PX
    x_shift, y_shift = np.array(hair_shift_px) / FOCAL_PX
    hair = hair_light((x_ray + x_shift) * HAIR_M + camera_m, (y_ray + y_shift) * HAIR_M)
    is_hair = ~np.isnan(hair)
    light = np.where(is_hair, hair, wall_light(x_ray * WALL_M + camera_m))
    return light, np.where(is_hair, HAIR_M, WALL_M)


def pixel_means(light: Image) -> Image:
    return light.reshape(HEIGHT, SAMPLES, WIDTH, SAMPLES).mean((1, 3))


def frame_of(number: int) -> View:
    camera_m = STEP_M * number
    light, world_to_camera = pixel_means(view_through(camera_m, SAMPLES)[0]), np.eye(4)
    world_to_camera[0, 3] = -camera_m
    depth_m = view_through(camera_m, 1)[1].astype(np.float32)
    plate = plate_of(np.repeat(light[..., None], 3, -1).astype(np.float32), depth_m)
    return View(number, plate, world_to_camera, (FOCAL_PX, FOCAL_PX), (WIDTH / 2, HEIGHT / 2))


def true_picture() -> Image:
    """Return the mean light (H, W) that points of the lens see."""
    along = (np.arange(8) + 0.5) / 4 - 1
    points = [(x, y) for y in along for x in along if x * x + y * y <= 1]
    views = [view_through(0.0, 2, (x * COC_PX / 2, y * COC_PX / 2))[0] for x, y in points]
    return np.mean(views, axis=0).reshape(HEIGHT, 2, WIDTH, 2).mean((1, 3))


def lens_on_wall() -> Lens:
    focal_mm, sensor_mm = 50.0, 36.0
    wide_mm = focal_mm**2 / (WALL_M * 1e3 - focal_mm) * (WALL_M / HAIR_M - 1)
    return Lens(focal_mm, wide_mm * WIDTH / sensor_mm / COC_PX, WALL_M, sensor_mm)


@pytest.mark.parametrize(("neighbors", "most"), [(0, 1.4), (4, 1.28)])
def test_dark_bars_behind_hair_are_little_lighter_than_truth(renderer, neighbors, most):
    """With four frames on either side it was 1.33 where the outline gave the coverage of hair."""
    frames = {number: frame_of(number) for number in range(-neighbors, neighbors + 1)}
    plate: Plate = frames[0].plate
    if neighbors:
        plate = with_neighbours(frames.pop(0), list(frames.values())).plate
        assert plate.fragments is not None
    renderer.load(plate)
    light = renderer.pixels(Shot(lens_on_wall()))[..., :3] @ LUMINANCE
    x_m = (np.arange(WIDTH) + 0.5 - WIDTH / 2) / FOCAL_PX * WALL_M
    on_bar = np.broadcast_to(wall_light(x_m) == BAR, light.shape)[INSIDE]
    truth = true_picture()
    assert light[INSIDE][on_bar].mean() <= most * truth[INSIDE][on_bar].mean()
    beside_ratio = light[INSIDE][~on_bar].mean() / truth[INSIDE][~on_bar].mean()
    assert beside_ratio == pytest.approx(1.0, abs=0.05)
