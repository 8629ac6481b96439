"""Laws of a lens, tested on the whole renderer with its layers and highlights."""

import math
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import LAYERS_MAX, Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import run_all_steps
from heatlens.render.gpu.textures import FloatArray, download
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
from support.plates import FAR_M, FOCUS_M, NEAR_M, Image, lens_blurring, moments, plate_of, room

# A constant stays constant

TINT = np.array([0.25, 0.75, 8.0], np.float32)  # its mean is below the limit of highlights


@pytest.mark.parametrize(
    ("bokeh", "quality", "layers"),
    [
        (bokeh, quality, layers)
        for bokeh, quality in KINDS
        for layers in ([1] if bokeh is Bokeh.DISC else [None, *range(1, LAYERS_MAX + 1)])
    ],
)
def test_blur_of_uniform_color_over_depths_is_uniform(ctx, renderer, bokeh, quality, layers):
    _check_tint_stays(TINT, renderer, bokeh, quality, layers)


@pytest.mark.parametrize("times", [1.1, 1.5, 4.0])
def test_blur_of_bright_uniform_color_is_uniform(ctx, renderer, times):
    """Check that a bright uniform surface stays uniform: it must not be drawn as highlight discs.

    Discs of its light would lack what is hidden, and what lies outside the frame.
    """
    _check_tint_stays(times * TINT, renderer, Bokeh.DISC, Quality.FILM, None)


def _check_tint_stays(tint, renderer, bokeh, quality, layers):
    _, depth = room()
    plate = plate_of(np.broadcast_to(tint, (*depth.shape, 3)), depth)
    for lens in (lens_blurring(1.5, 96), lens_blurring(40.0, 96)):
        picture = render_plate_with_lens(renderer, plate, lens, bokeh, quality, layers)
        deviation = np.abs(picture[..., :3] / tint - 1.0)
        assert deviation.max() < 4 * HALF_ROUNDING
        np.testing.assert_allclose(picture[..., 3], 1.0, atol=1e-5)


@pytest.mark.parametrize("bokeh", Bokeh)
def test_blur_of_black_plate_is_black(ctx, renderer, bokeh):
    _, depth = room()
    plate = plate_of(np.zeros((*depth.shape, 3), np.float32), depth)
    assert not render_plate_with_lens(renderer, plate, lens_blurring(20.0, 96), bokeh)[
        ..., :3
    ].any()


# Light is kept


@pytest.mark.parametrize("depth_m", [NEAR_M, FAR_M], ids=["near", "far"])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_blur_keeps_light_of_wall(ctx, renderer, rng, bokeh, quality, depth_m):
    """Check the sum of the whole picture; no light flows over its borders."""
    color = rng.random((60, 80, 3), np.float32) + 0.5
    plate = plate_of(color, np.full((60, 80), depth_m, np.float32))
    picture = render_plate_with_lens(renderer, plate, lens_blurring(11.0, 80), bokeh, quality)
    light_ratio = picture[..., :3].sum((0, 1), np.float64) / color.sum((0, 1), np.float64)
    np.testing.assert_allclose(light_ratio, 1.0, atol=HALF_ROUNDING)


@pytest.mark.parametrize("coc_px", [3.0, 8.0, 13.0, 16.0, 21.0, 40.0])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_blur_keeps_light_of_lamp(ctx, renderer, bokeh, quality, coc_px):
    plate = point_plate(bokeh, LAMP)
    picture = render_plate_with_lens(renderer, plate, lens_blurring(coc_px, SIZE), bokeh, quality)
    mean, _, _ = moments(picture - np.float32(grey_for(bokeh)))
    assert mean / LAMP == pytest.approx(1.0, abs=0.005)


# What is in focus is not touched


@pytest.mark.parametrize("layers", [None, 1])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_plate_in_focus_is_unchanged_bit_for_bit(ctx, renderer, rng, bokeh, quality, layers):
    color = (rng.random((33, 47, 3)) * 10.0 ** rng.integers(-4, 4, (33, 47, 1))).astype(np.float32)
    plate = plate_of(color, np.full((33, 47), FOCUS_M, np.float32))
    for f_stop in (1e-2, 1.4, 64.0):
        lens = Lens(50.0, f_stop, FOCUS_M, 36.0)
        assert np.array_equal(
            render_plate_with_lens(renderer, plate, lens, bokeh, quality, layers), plate.color
        )


@pytest.mark.parametrize("bokeh", Bokeh)
def test_sky_with_focus_at_infinity_is_unchanged_bit_for_bit(ctx, renderer, rng, bokeh):
    color = rng.random((33, 47, 3), np.float32)
    plate = plate_of(color, np.full((33, 47), np.inf, np.float32))
    lens = Lens(50.0, 1.4, math.inf, 36.0)
    assert np.array_equal(render_plate_with_lens(renderer, plate, lens, bokeh), plate.color)


@pytest.mark.parametrize("bokeh", Bokeh)
def test_pinhole_lens_leaves_plate_nearly_unchanged(ctx, renderer, bokeh):
    """Render at f/100000, where no circle of confusion reaches a thousandth of a pixel."""
    color, depth = room()
    picture = render_plate_with_lens(
        renderer, plate_of(color, depth), Lens(50.0, 1e5, FOCUS_M, 36.0), bokeh
    )
    np.testing.assert_allclose(picture[..., :3], color, rtol=1e-3, atol=1e-3)


# The amount of blur: a disc of diameter d has the variance d^2 / 16 along each axis

# A lamp is a pixel wide and its disc has a rim as soft as a pixel: 1/12 px^2 each.
PIXEL_VARIANCE = 2 / 12


def light_above_grey(picture: Image, bokeh: Bokeh, coc_px: float) -> Image:
    """Return the light above the grey, cropped around the point to exclude rounding elsewhere."""
    centre, reach = picture.shape[0] // 2, int(2.5 * coc_px) + 2
    near = slice(max(0, centre - reach), centre + reach + 1)
    return picture[near, near, :3] - np.float32(grey_for(bokeh))


@pytest.mark.parametrize("depth_m", [NEAR_M, FAR_M], ids=["near", "far"])
@pytest.mark.parametrize("coc_px", [4.0, 12.0, 24.0])
@pytest.mark.parametrize("light", [DIM, LAMP])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_blurred_point_has_variance_of_disc(ctx, renderer, bokeh, quality, light, coc_px, depth_m):
    plate = point_plate(bokeh, light, depth_m=depth_m)
    picture = render_plate_with_lens(renderer, plate, lens_blurring(coc_px, SIZE), bokeh, quality)
    _, *variances = moments(light_above_grey(picture, bokeh, coc_px))
    pixel = PIXEL_VARIANCE if light == LAMP else 0.0
    np.testing.assert_allclose(variances, coc_px**2 / 16, rtol=0.02, atol=pixel)


def test_enlarged_preview_has_round_lamps_with_their_light(ctx, renderer):
    """On the screen, a lamp of the enlarged preview differs from the whole disc by half as much."""
    coc_px, proxy, size, half = 24.0, 0.125, 384, 40
    lens = lens_blurring(coc_px, size)
    renderer.load(point_plate(Bokeh.DISC, 3e4, size))
    whole, small = (
        Shot(lens, DefocusSettings(quality=Quality.DRAFT, proxy=share)) for share in (1.0, proxy)
    )
    plain = download(renderer.render(small)).copy()
    enlarged = download(run_all_steps(renderer.steps(small, enlarges=True))).copy()
    assert enlarged.shape[0] == 3 * plain.shape[0]
    light, expected_light = enlarged[..., 1].sum() / 9.0, plain[..., 1].sum()
    assert light == pytest.approx(expected_light, rel=0.02)
    middle = slice(size // 2 - half, size // 2 + half)
    at_rest = shown_pixels(download(renderer.render(whole)), size)[middle, middle]
    plain_error, error = (
        np.abs(shown_pixels(picture, size)[middle, middle] - at_rest).mean()
        for picture in (plain, enlarged)
    )
    assert error < 0.5 * plain_error


def test_edge_before_lamp_of_enlarged_preview_is_smooth(renderer):
    """Its light falls by degrees behind an edge in focus, not at once between two small pixels."""
    size, lamp, edge = 384, 180, 196
    color = np.full((size, size, 3), 0.02, np.float32)
    color[lamp, size // 2] = 3e5
    depth_m = np.full((size, size), FAR_M, np.float32)
    color[edge:], depth_m[edge:] = 0.2, FOCUS_M
    renderer.load(plate_of(color, depth_m))
    small = Shot(lens_blurring(128.0, size), DefocusSettings(quality=Quality.DRAFT, proxy=0.125))
    picture = download(run_all_steps(renderer.steps(small, enlarges=True)))
    middle = picture.shape[0] // 2
    light = picture[middle - 6 :, middle - 6 : middle + 6, 1].mean(axis=1)
    falls = -np.diff(light)
    assert falls.min() > -1e-3 * light[0] and falls.max() < 0.4 * falls.sum()


def shown_pixels(picture: Image, size: int) -> FloatArray:
    """Return the green of a picture as a screen shows it: clipped at white, and enlarged."""
    nearest = ((np.arange(size) + 0.5) * picture.shape[0] / size).astype(int)
    return np.minimum(picture[..., 1], 1.0)[np.ix_(nearest, nearest)]


@pytest.mark.parametrize("light", [DIM, LAMP])
@pytest.mark.parametrize("proxy", [0.5, 0.25])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_blur_radius_scales_with_proxy(ctx, renderer, bokeh, quality, proxy, light):
    size, coc_px = 256, 40.0
    plate = point_plate(bokeh, light / proxy**2, size)
    picture = render_plate_with_lens(
        renderer, plate, lens_blurring(coc_px, size), bokeh, quality, None, proxy
    )
    _, *variances = moments(light_above_grey(picture, bokeh, proxy * coc_px))
    pixel = PIXEL_VARIANCE if light == LAMP else 0.0
    np.testing.assert_allclose(variances, (proxy * coc_px) ** 2 / 16, rtol=0.05, atol=pixel)


@pytest.mark.parametrize("light", [DIM, LAMP])
@pytest.mark.parametrize(
    ("squeeze", "aspect"), [(2.0, 1.0), (1.33, 1.0), (1.0, 0.5), (1.0, 2.0), (2.0, 2.0)]
)
@pytest.mark.parametrize("bokeh", Bokeh)
def test_squeeze_narrows_disc_and_pixel_aspect_changes_its_height(
    ctx, renderer, bokeh, squeeze, aspect, light
):
    """Check the variances: coc / squeeze along x, coc times the pixel aspect ratio along y."""
    coc_px = 14.0
    plate = replace(point_plate(bokeh, light), pixel_aspect_ratio=aspect)
    lens = lens_blurring(coc_px, SIZE, squeeze)
    _, x, y = moments(
        light_above_grey(
            render_plate_with_lens(renderer, plate, lens, bokeh), bokeh, coc_px * aspect
        )
    )
    slender = max(
        squeeze * aspect, 1 / (squeeze * aspect)
    )  # a rim of a pixel adds more at its tips
    pixel = PIXEL_VARIANCE * slender * max(1.0, aspect) ** 2 if light == LAMP else 0.0
    assert x == pytest.approx((coc_px / squeeze) ** 2 / 16, rel=0.02, abs=pixel)
    assert y == pytest.approx((coc_px * aspect) ** 2 / 16, rel=0.02, abs=pixel)


@pytest.mark.parametrize("bokeh", Bokeh)
def test_half_f_stop_doubles_coc(ctx, renderer, bokeh):
    plate, lens = point_plate(bokeh, DIM), lens_blurring(6.0, SIZE)
    wider = replace(lens, f_stop=lens.f_stop / 2)
    _, *narrow = moments(
        light_above_grey(render_plate_with_lens(renderer, plate, lens, bokeh), bokeh, 6.0)
    )
    _, *wide = moments(
        light_above_grey(render_plate_with_lens(renderer, plate, wider, bokeh), bokeh, 12.0)
    )
    np.testing.assert_allclose(np.divide(wide, narrow), 4.0, rtol=0.02)


# A mirrored picture


@pytest.mark.parametrize("flip", [(slice(None), slice(None, None, -1)), (slice(None, None, -1),)])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_blur_of_mirrored_plate_is_mirrored(ctx, renderer, bokeh, quality, flip):
    color, depth = room(97, 55)
    plain = render_plate_with_lens(
        renderer, plate_of(color, depth), lens_blurring(12.0, 97), bokeh, quality
    )
    mirrored = plate_of(color[flip], depth[flip])
    picture = render_plate_with_lens(renderer, mirrored, lens_blurring(12.0, 97), bokeh, quality)
    difference = np.abs(np.clip(picture[flip], 0, 1) - np.clip(plain, 0, 1))
    assert difference.mean() < 2e-3


# A focus pull


@pytest.mark.parametrize(("from_m", "to_m"), [(0.8, 1.0), (1.5, 2.6)])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_focus_pull_changes_picture_evenly(ctx, renderer, bokeh, quality, from_m, to_m):
    """Check that no step of a pull, even in dioptres and so in blur, changes much more than others.

    Frames are clipped to 0..1 as on a screen, because popping is what an eye sees.
    """
    renderer.load(plate_of(*room()))
    frames = [
        np.clip(renderer.pixels(Shot(lens, DefocusSettings(bokeh, quality))), 0, 1)
        for lens in (
            Lens(50.0, 1.4, 1 / dioptres, 36.0)
            for dioptres in np.linspace(1 / from_m, 1 / to_m, 24).tolist()
        )
    ]
    steps = np.abs(np.diff(frames, axis=0)).mean(axis=(1, 2, 3))
    assert 0.0 < steps.min() and steps.max() < 2.0 * steps.mean()


# Nothing of the pictures before


@pytest.mark.parametrize("size", [(32, 18), (96, 54), (131, 77)])
@pytest.mark.parametrize("quality", Quality)
def test_picture_does_not_depend_on_earlier_pictures(ctx, renderer, quality, size):
    """Render in reverse order, with reused textures and other list orders: all bits are equal."""
    renderer.load(plate_of(*room(*size)))
    shots = [Shot(lens_blurring(c, size[0]), DefocusSettings(quality=quality)) for c in (3, 12, 40)]
    first = [renderer.pixels(shot) for shot in shots]
    backwards = [renderer.pixels(shot) for shot in reversed(shots)]
    for picture, picture_again in zip(first, reversed(backwards), strict=True):
        assert np.array_equal(picture, picture_again)
