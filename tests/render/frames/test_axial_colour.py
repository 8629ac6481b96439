"""Axial color: each color channel equals that of a lens focused at the channel's own distance."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.focus.coc import axial_dioptres, axial_px
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.kernels import rim_kernel
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray
from support import oracle
from support.alpha_plates import covered_room
from support.plates import coc_plate_of, lens_blurring, plate_of, room

PREVIEW = DefocusSettings(quality=Quality.PREVIEW)
LENS = replace(lens_blurring(14.0, 96), model=LensModel.RENDERER, axial_colour_mm=0.4)


def plate(rng: np.random.Generator) -> Plate:
    """Return a room with noise on its walls."""
    color, depth = room()
    return plate_of(color + rng.random(color.shape, np.float32), depth)


def render_plate(
    renderer: FrameRenderer, plate: Plate, lens: Lens, settings: DefocusSettings = PREVIEW
) -> FloatArray:
    renderer.load(plate)
    return renderer.pixels(Shot(lens, settings))


@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.PYRAMID])
def test_axial_color_channel_equals_lens_with_its_focus(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator, method: Method
) -> None:
    """Compare green bit for bit, red and blue up to the rounding of their focus distance."""
    room_plate, settings = plate(rng), replace(PREVIEW, method=method)
    picture = render_plate(renderer, room_plate, LENS, settings)
    assert abs(axial_px(LENS, 96)) > 1.0
    for channel in range(3):
        dioptres = 1 / LENS.focus_distance_m + (channel - 1) * axial_dioptres(LENS)
        alone = replace(LENS, axial_colour_mm=0.0, focus_distance_m=1 / dioptres)
        expected = render_plate(renderer, room_plate, alone, settings)[..., channel]
        if channel == 1:
            assert np.array_equal(picture[..., channel], expected)
        else:
            np.testing.assert_allclose(picture[..., channel], expected, atol=2e-3)
            assert np.abs(picture[..., channel] - picture[..., 1]).max() > 0.05


def test_axial_color_in_one_layer_agrees_with_float64(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator
) -> None:
    """Compare a coc plate in one layer with the float64 oracle, its coc shifted by channel."""
    color = rng.random((20, 30, 3), np.float32)
    coc = (12 * rng.random((20, 30), np.float32) - 4).astype(np.float32)
    lens, settings = replace(LENS, axial_colour_mm=1.0), replace(PREVIEW, layers=1)
    picture = render_plate(renderer, coc_plate_of(color, coc), lens, settings)
    kernel = rim_kernel("disc_3", 0.0)
    for channel in range(3):
        shifted = coc.astype(np.float64) + (channel - 1) * axial_px(lens, 30)
        one = color[..., channel : channel + 1].astype(np.float64)
        expected = np.maximum(oracle.blur(one, shifted, kernel)[..., 0], 0.0)
        np.testing.assert_allclose(picture[..., channel], expected, atol=2e-3)


def test_axial_color_keeps_uniform_color_and_light_of_wall(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator
) -> None:
    _, depth = room()
    tint = np.array([0.25, 0.75, 8.0], np.float32)
    even = render_plate(renderer, plate_of(np.broadcast_to(tint, (*depth.shape, 3)), depth), LENS)
    np.testing.assert_allclose(even[..., :3] / tint, 1.0, atol=2e-3)
    wall = rng.random((40, 60, 3), np.float32) + 0.5
    blurred = render_plate(renderer, plate_of(wall, np.full((40, 60), 2.0, np.float32)), LENS)
    light_ratio = blurred[..., :3].sum((0, 1), np.float64) / wall.sum((0, 1), np.float64)
    np.testing.assert_allclose(light_ratio, 1.0, atol=1e-3)


def test_axial_color_keeps_channel_that_is_in_focus(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator
) -> None:
    color = rng.random((24, 32, 3), np.float32)
    lens = replace(LENS, axial_colour_mm=1.5)
    for channel in range(3):
        coc = np.full((24, 32), (1 - channel) * axial_px(lens, 32), np.float32)
        picture = render_plate(renderer, coc_plate_of(color, coc), lens)
        assert np.array_equal(picture[..., channel], color[..., channel])
        assert not np.array_equal(picture[..., (channel + 1) % 3], color[..., (channel + 1) % 3])


def test_axial_color_leaves_alpha_unchanged(ctx: Device, renderer: FrameRenderer) -> None:
    covered = plate_of(*covered_room(), has_alpha=True)
    plain = render_plate(renderer, covered, replace(LENS, axial_colour_mm=0.0))
    assert np.array_equal(render_plate(renderer, covered, LENS)[..., 3], plain[..., 3])
    assert np.ptp(plain[..., 3]) > 0.1


def test_progress_with_axial_color_increases_over_all_colors(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator
) -> None:
    reports: list[tuple[int, int]] = []
    renderer.set_layer_callback(lambda done, layers: reports.append((done, layers)))
    render_plate(renderer, plate(rng), LENS)
    renderer.set_layer_callback(None)
    shares = [done / layers for done, layers in reports]
    assert shares == sorted(shares) and shares[0] == 0.0 and shares[-1] < 1.0
