"""Properties that all defocus methods share: gather, scatter, pyramid, heat and diffusion."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import run_all_steps
from heatlens.render.gpu.textures import download
from support.methods_of_plates import OF_PLATES, OTHERS, PIXEL_VARIANCE, render_with_method
from support.plates import (
    FAR_M,
    FOCUS_M,
    NEAR_M,
    coc_plate_of,
    lens_blurring,
    moments,
    plate_of,
    room,
)


@pytest.mark.parametrize("method", OF_PLATES)
@pytest.mark.parametrize("coc_px", [1.5, 40.0])
def test_blur_of_uniform_color_over_depths_is_uniform(ctx, renderer, method, coc_px):
    _, depth = room()
    tint = np.array([0.25, 0.75, 8.0], np.float32)
    plate = plate_of(np.broadcast_to(tint, (*depth.shape, 3)), depth)
    blurred = render_with_method(renderer, plate, method, lens_blurring(coc_px, 96))
    assert np.abs(blurred[..., :3] / tint - 1.0).max() < 2e-3
    assert np.array_equal(blurred[..., 3], np.ones(depth.shape))


@pytest.mark.parametrize("method", OF_PLATES)
def test_plate_in_focus_is_unchanged_bit_for_bit(ctx, renderer, rng, method):
    color = (rng.random((33, 47, 3)) * 10.0 ** rng.integers(-4, 4, (33, 47, 1))).astype(np.float32)
    plate = plate_of(color, np.full((33, 47), FOCUS_M, np.float32))
    assert np.array_equal(render_with_method(renderer, plate, method), plate.color)


@pytest.mark.parametrize("method", [Method.GATHER, Method.SCATTER, Method.PYRAMID, Method.HEAT])
def test_sharp_foreground_before_blurred_background_is_unchanged(ctx, renderer, rng, method):
    color = rng.random((48, 64, 3), np.float32)
    depth = np.full((48, 64), FAR_M, np.float32)
    depth[10:30, 20:40] = FOCUS_M
    blurred = render_with_method(renderer, plate_of(color, depth), method, lens_blurring(15.0, 64))
    assert np.array_equal(blurred[10:30, 20:40, :3], color[10:30, 20:40])
    assert not np.allclose(blurred[35:, :, :3], color[35:], atol=0.1)


@pytest.mark.parametrize("method", OF_PLATES)
@pytest.mark.parametrize("size", [(1, 1), (1, 7), (7, 1), (3, 5), (33, 47)])
@pytest.mark.parametrize("coc_px", [3.0, -30.0])
def test_blur_of_any_picture_size_stays_in_range_of_plate(ctx, renderer, rng, method, size, coc_px):
    """Check that every blurred pixel lies between the darkest and the brightest of the plate."""
    color = rng.random((*size, 3), np.float32) + 0.5
    blurred = render_with_method(
        renderer, coc_plate_of(color, np.full(size, coc_px, np.float32)), method
    )
    assert blurred.shape == (*size, 4)
    slack = 0.05 if method is Method.DIFFUSION else 2e-3
    assert blurred[..., :3].min() >= color.min() - slack
    assert blurred[..., :3].max() <= color.max() + slack


@pytest.mark.parametrize("method", OTHERS)
def test_blur_of_mirrored_plate_is_mirrored(ctx, renderer, method):
    """Use 2^n + 1 pixels: pyramid levels, which begin at the left, then end alike at the right."""
    color, depth = room(129, 65)
    plain = render_with_method(renderer, plate_of(color, depth), method, lens_blurring(12.0, 129))
    for flip in ((slice(None), slice(None, None, -1)), (slice(None, None, -1),)):
        mirrored = plate_of(color[flip].copy(), depth[flip].copy())
        blurred = render_with_method(renderer, mirrored, method, lens_blurring(12.0, 129))
        np.testing.assert_allclose(blurred[flip], plain, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("method", OTHERS)
def test_blur_does_not_depend_on_origin_of_data_window(ctx, renderer, method):
    color, depth = room()
    plate = plate_of(color, depth)
    here = render_with_method(renderer, plate, method, lens_blurring(12.0, 96))
    moved = replace(plate, data_window=Box(-500, 300, -404, 354))
    assert np.array_equal(
        render_with_method(renderer, moved, method, lens_blurring(12.0, 96)), here
    )


@pytest.mark.parametrize("method", OTHERS)
def test_coc_plate_is_blurred_like_depth_plate(ctx, renderer, method):
    color, _ = room()
    depth = np.where(np.arange(96) < 48, FAR_M, NEAR_M) * np.ones((54, 1))
    coc = np.where(depth == FAR_M, 9.0, -9.0)
    by_depth = render_with_method(renderer, plate_of(color, depth), method, lens_blurring(9.0, 96))
    by_coc = render_with_method(renderer, coc_plate_of(color, coc), method)
    np.testing.assert_allclose(by_coc, by_depth, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("method", OTHERS)
@pytest.mark.parametrize("proxy", [0.5, 0.25])
def test_blur_radius_scales_with_proxy(ctx, renderer, method, proxy):
    """Check the moments of a lamp of one proxy pixel: its disc has `proxy` times the coc."""
    color = np.zeros((256, 256, 3), np.float32)
    block = round(1 / proxy)
    color[128 : 128 + block, 128 : 128 + block] = 1.0
    plate = plate_of(color, np.full((256, 256), FAR_M, np.float32))
    blurred = render_with_method(renderer, plate, method, lens_blurring(40.0, 256), proxy)
    assert blurred.shape[:2] == (256 * proxy, 256 * proxy)
    light, *found = moments(blurred)
    assert light == pytest.approx(1.0, rel=1e-3)
    np.testing.assert_allclose(found, (proxy * 40.0) ** 2 / 16, rtol=0.01, atol=PIXEL_VARIANCE)


@pytest.mark.parametrize("method", OTHERS)
def test_alpha_is_blurred_like_a_color_channel(ctx, renderer, rng, method):
    """Check that alpha equal to red stays equal to red, and within 0..1."""
    color, depth = room()
    red = np.clip(color[..., :1], 0.0, 1.0)
    rgba = np.concatenate([np.repeat(red, 3, axis=2), red], axis=2)
    plate = plate_of(rgba, depth, has_alpha=True)
    blurred = render_with_method(renderer, plate, method, lens_blurring(12.0, 96))
    np.testing.assert_allclose(blurred[..., 3], blurred[..., 0], rtol=1e-6, atol=1e-7)
    assert 0.0 <= blurred[..., 3].min() < blurred[..., 3].max() <= 1.0


@pytest.mark.parametrize("method", OTHERS)
def test_steps_yield_one_method_pass_and_same_picture(ctx, renderer, method):
    renderer.load(plate_of(*room()))
    shot = Shot(lens_blurring(12.0, 96), DefocusSettings(method=method))
    whole = renderer.pixels(shot)
    names = list(renderer.steps(shot, slot=1))
    assert set(names) == {"coc", str(method), "limits"}
    assert np.array_equal(download(run_all_steps(renderer.steps(shot, slot=1))), whole)


@pytest.mark.parametrize("method", OTHERS)
def test_steps_closed_early_do_not_change_next_picture(ctx, renderer, method):
    renderer.load(plate_of(*room()))
    shot = Shot(lens_blurring(12.0, 96), DefocusSettings(method=method))
    expected = renderer.pixels(shot)
    for taken in (2, 3):
        left = renderer.steps(replace(shot, lens=lens_blurring(30.0, 96)))
        for _ in range(taken):
            next(left)
        left.close()
        assert np.array_equal(renderer.pixels(shot), expected)
