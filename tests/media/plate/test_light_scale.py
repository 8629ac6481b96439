"""Test that a plate in any unit of light gives the same image, in that unit."""

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.render.source.plate_on_gpu import light_scale
from support.plates import lens_blurring, plate_of, room

UNIT = 16.0**2  # an exact factor


@pytest.mark.parametrize("bright", [0.0, 0.01, 1.0, 3.9, 4.1, 100.0, 1e6])
def test_light_scale_brings_bright_plate_into_range_by_power_of_16(bright):
    color = np.full((300, 200, 4), bright, np.float32)
    scale = light_scale(color)
    assert scale == 1.0 if bright <= 4.0 else 0.25 <= scale * bright <= 4.0
    assert np.log2(scale) % 4 == 0


def test_light_scale_ignores_few_bright_lamps():
    color = np.full((300, 200, 4), 0.1, np.float32)
    color[:20, :200] = 1e5
    assert light_scale(color) == 1.0


@pytest.mark.parametrize("has_lists", [False, True])
@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.GATHER])
def test_rendered_image_is_same_in_any_unit_of_light(renderer, rng, method, has_lists):
    color, depth = room()
    color = np.asarray(color + rng.random(color.shape) ** 8, np.float32)
    color[20:23, 30:33] = 60.0  # a lamp
    settings = DefocusSettings(method=method, quality=Quality.DRAFT)
    shot = Shot(lens_blurring(12.0, depth.shape[1]), settings)

    def picture(unit):
        plate = plate_of(unit * color, depth)
        if has_lists:
            plate = with_behind(plate, [plate_of(0.5 * unit * color, depth + 4.0)])
        assert light_scale(plate.color) == 1.0 / unit
        renderer.load(plate)
        return renderer.pixels(shot)

    expected = picture(1.0)
    np.testing.assert_array_equal(picture(UNIT) / (UNIT, UNIT, UNIT, 1.0), expected)
