"""A focus for each colour: every colour of a picture is that of a lens with this focus for all."""

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


def seen(
    renderer: FrameRenderer, plate: Plate, lens: Lens, settings: DefocusSettings = PREVIEW
) -> FloatArray:
    renderer.load(plate)
    return renderer.pixels(Shot(lens, settings))


@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.PYRAMID])
def test_each_colour_is_that_of_a_lens_with_its_focus(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator, method: Method
) -> None:
    """Green bit for bit; the others up to the rounding of their focus."""
    room_plate, settings = plate(rng), replace(PREVIEW, method=method)
    picture = seen(renderer, room_plate, LENS, settings)
    assert abs(axial_px(LENS, 96)) > 1.0
    for channel in range(3):
        dioptres = 1 / LENS.focus_distance_m + (channel - 1) * axial_dioptres(LENS)
        alone = replace(LENS, axial_colour_mm=0.0, focus_distance_m=1 / dioptres)
        expected = seen(renderer, room_plate, alone, settings)[..., channel]
        if channel == 1:
            assert np.array_equal(picture[..., channel], expected)
        else:
            np.testing.assert_allclose(picture[..., channel], expected, atol=2e-3)
            assert np.abs(picture[..., channel] - picture[..., 1]).max() > 0.05


def test_one_layer_agrees_with_float64(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator
) -> None:
    """Also where the plate brings its circle of confusion, which each colour shifts."""
    color = rng.random((20, 30, 3), np.float32)
    coc = (12 * rng.random((20, 30), np.float32) - 4).astype(np.float32)
    lens, settings = replace(LENS, axial_colour_mm=1.0), replace(PREVIEW, layers=1)
    picture = seen(renderer, coc_plate_of(color, coc), lens, settings)
    kernel = rim_kernel("disc_3", 0.0)
    for channel in range(3):
        shifted = coc.astype(np.float64) + (channel - 1) * axial_px(lens, 30)
        one = color[..., channel : channel + 1].astype(np.float64)
        expected = np.maximum(oracle.blur(one, shifted, kernel)[..., 0], 0.0)
        np.testing.assert_allclose(picture[..., channel], expected, atol=2e-3)


def test_one_colour_stays_and_a_wall_keeps_its_light(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator
) -> None:
    _, depth = room()
    tint = np.array([0.25, 0.75, 8.0], np.float32)
    even = seen(renderer, plate_of(np.broadcast_to(tint, (*depth.shape, 3)), depth), LENS)
    np.testing.assert_allclose(even[..., :3] / tint, 1.0, atol=2e-3)
    wall = rng.random((40, 60, 3), np.float32) + 0.5
    blurred = seen(renderer, plate_of(wall, np.full((40, 60), 2.0, np.float32)), LENS)
    kept = blurred[..., :3].sum((0, 1), np.float64) / wall.sum((0, 1), np.float64)
    np.testing.assert_allclose(kept, 1.0, atol=1e-3)


def test_what_is_in_focus_in_a_colour_keeps_it_bit_for_bit(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator
) -> None:
    color = rng.random((24, 32, 3), np.float32)
    lens = replace(LENS, axial_colour_mm=1.5)
    for channel in range(3):
        coc = np.full((24, 32), (1 - channel) * axial_px(lens, 32), np.float32)
        picture = seen(renderer, coc_plate_of(color, coc), lens)
        assert np.array_equal(picture[..., channel], color[..., channel])
        assert not np.array_equal(picture[..., (channel + 1) % 3], color[..., (channel + 1) % 3])


def test_alpha_goes_with_green(ctx: Device, renderer: FrameRenderer) -> None:
    covered = plate_of(*covered_room(), has_alpha=True)
    plain = seen(renderer, covered, replace(LENS, axial_colour_mm=0.0))
    assert np.array_equal(seen(renderer, covered, LENS)[..., 3], plain[..., 3])
    assert np.ptp(plain[..., 3]) > 0.1


def test_layers_are_counted_over_all_colours(
    ctx: Device, renderer: FrameRenderer, rng: np.random.Generator
) -> None:
    told: list[tuple[int, int]] = []
    renderer.listen(lambda done, layers: told.append((done, layers)))
    seen(renderer, plate(rng), LENS)
    renderer.listen(None)
    shares = [done / layers for done, layers in told]
    assert shares == sorted(shares) and shares[0] == 0.0 and shares[-1] < 1.0
