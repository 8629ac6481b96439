"""Laws of the layered picture: uniform color, light of lamps, smooth focus changes."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.focus.coc import coc_px as disc_px
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import LAYERS_MAX, Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from support.alpha_plates import covered_room
from support.alpha_plates import render_alpha_plate as through_alpha
from support.lamps import (
    DIM,
    HALF_ROUNDING,
    KINDS,
    LAMP,
    SIZE,
    grey_for,
    point_plate,
    render_plate_with_lens,
)
from support.methods_of_plates import OF_PLATES
from support.plates import FAR_M, coc_plate_of, lens_blurring, moments, plate_of, room


@pytest.mark.parametrize("layers", [None, *range(2, LAYERS_MAX + 1)])
@pytest.mark.parametrize("quality", Quality)
def test_disc_blur_of_uniform_color_is_uniform_in_all_layer_counts(ctx, renderer, quality, layers):
    _, depth = room()
    tint = np.array([0.25, 0.75, 8.0], np.float32)
    plate = plate_of(np.broadcast_to(tint, (*depth.shape, 3)), depth)
    for lens in (lens_blurring(1.5, 96), lens_blurring(40.0, 96)):
        picture = render_plate_with_lens(renderer, plate, lens, Bokeh.DISC, quality, layers)
        assert np.abs(picture[..., :3] / tint - 1.0).max() < 4 * HALF_ROUNDING


@pytest.mark.parametrize("method", OF_PLATES)
def test_huge_coc_gives_finite_picture(ctx, renderer, rng, method):
    """Render a narrow sensor, a long lens and a surface close to it: a coc of 4e10 pixels."""
    depth = rng.uniform(0.5, 5.0, (12, 20)).astype(np.float32)
    depth[:4, :7] = 1e-6
    renderer.load(plate_of(rng.random((12, 20, 3), np.float32), depth))
    lens = Lens(focal_length_mm=800, f_stop=2, focus_distance_m=0.9, sensor_width_mm=1)
    assert abs(disc_px(1e-6, coc_line(lens, 20))) > 1e10
    picture = renderer.pixels(Shot(lens, DefocusSettings(method=method)))
    assert np.isfinite(picture).all()


@pytest.mark.parametrize("coc_px", [2.0, 4.0, 8.0, 10.0, 12.0, 16.0, 20.0])
@pytest.mark.parametrize(("squeeze", "aspect"), [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (2.0, 4.0)])
def test_anamorphic_blur_keeps_light_of_lamp(ctx, renderer, coc_px, squeeze, aspect):
    plate = replace(point_plate(Bokeh.DISC, LAMP), pixel_aspect_ratio=aspect)
    picture = render_plate_with_lens(renderer, plate, lens_blurring(coc_px, SIZE, squeeze))
    mean, _, _ = moments(picture - np.float32(grey_for(Bokeh.DISC)))
    assert mean / LAMP == pytest.approx(1.0, abs=0.005)


@pytest.mark.parametrize("quality", Quality)
@pytest.mark.parametrize("light", [DIM, LAMP])
def test_blur_in_one_layer_is_not_negative(ctx, renderer, quality, light):
    color = np.zeros((SIZE, SIZE, 3), np.float32)
    color[64, 64] = light
    plate = plate_of(color, np.full((SIZE, SIZE), FAR_M, np.float32))
    assert (
        render_plate_with_lens(
            renderer, plate, lens_blurring(12.0, SIZE), Bokeh.DISC, quality, 1
        ).min()
        >= 0.0
    )


@pytest.mark.parametrize("bokeh", Bokeh)
def test_lamp_does_not_jump_where_it_becomes_a_drawn_disc(ctx, renderer, bokeh):
    plate = point_plate(bokeh, 40.0, 33)
    renderer.load(plate)
    frames = [
        renderer.pixels(Shot(lens_blurring(float(d), 33), DefocusSettings(bokeh)))[16, 16, 0] / 40.0
        for d in np.arange(0.40, 0.60, 0.01)
    ]
    assert np.abs(np.diff(frames)).max() < 0.01


@pytest.mark.parametrize("coc_px", [1.5, 12.0, 60.0])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_alpha_in_one_layer_stays_within_zero_and_one(ctx, renderer, bokeh, quality, coc_px):
    alpha = through_alpha(renderer, *covered_room(), coc_px, bokeh, quality, 1)[..., 3]
    assert alpha.min() >= 0.0 and alpha.max() <= 1.0


@pytest.mark.parametrize("bokeh", Bokeh)
def test_smaller_focus_steps_change_picture_less(ctx, renderer, bokeh):
    """Pull focus so that an object passes a cut between layers: finer steps change less."""
    renderer.load(plate_of(*room()))

    def largest_step(count: int) -> float:
        focus_m = 1 / np.linspace(1 / 4.4, 1 / 5.2, count)
        lenses = [Lens(50.0, 1.4, float(focus), 36.0) for focus in focus_m]
        frames = [renderer.pixels(Shot(lens, DefocusSettings(bokeh))) for lens in lenses]
        return float(np.abs(np.diff(np.clip(frames, 0, 1), axis=0)).mean(axis=(1, 2, 3)).max())

    assert largest_step(65) < 0.5 * largest_step(9)


def test_blurred_corner_of_near_square_is_round(ctx, renderer):
    """Check the blurred corner of a near square: 0.25 at the corner, even and symmetric around."""
    color, coc = np.zeros((96, 96, 3), np.float32), np.zeros((96, 96), np.float32)
    color[32:64, 32:64], coc[32:64, 32:64] = 1.0, -16.0
    picture = render_plate_with_lens(
        renderer, coc_plate_of(color, coc), Lens(50.0, 2.0, 4.0, 36.0)
    )[..., 0]
    around = picture[22:42, 22:42]
    assert picture[31:33, 31:33].mean() == pytest.approx(0.25, abs=0.05)
    assert np.abs(np.diff(around, axis=0)).max() < 0.15
    assert np.abs(np.diff(around, axis=1)).max() < 0.15
    np.testing.assert_allclose(around, around.T, atol=0.05)
