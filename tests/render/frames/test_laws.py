"""The laws of a lens, on the renderer as it is used: layers, lamps and all."""

import math
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import LAYERS_MAX, Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from support.lamps import DIM, HALF_ROUNDING, KINDS, LAMP, SIZE, grey_for, point_plate, through
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
def test_one_colour_over_many_depths_stays_that_colour(ctx, renderer, bokeh, quality, layers):
    _stays(TINT, renderer, bokeh, quality, layers)


@pytest.mark.parametrize("times", [1.1, 1.5, 4.0])
def test_a_bright_surface_is_no_highlight(ctx, renderer, times):
    """Discs of its light would lack what is hidden, and what lies outside the frame."""
    _stays(times * TINT, renderer, Bokeh.DISC, Quality.FILM, None)


def _stays(tint, renderer, bokeh, quality, layers):
    _, depth = room()
    plate = plate_of(np.broadcast_to(tint, (*depth.shape, 3)), depth)
    for lens in (lens_blurring(1.5, 96), lens_blurring(40.0, 96)):
        picture = through(renderer, plate, lens, bokeh, quality, layers)
        deviation = np.abs(picture[..., :3] / tint - 1.0)
        assert deviation.max() < 4 * HALF_ROUNDING
        np.testing.assert_allclose(picture[..., 3], 1.0, atol=1e-5)


@pytest.mark.parametrize("bokeh", Bokeh)
def test_black_stays_black(ctx, renderer, bokeh):
    _, depth = room()
    plate = plate_of(np.zeros((*depth.shape, 3), np.float32), depth)
    assert not through(renderer, plate, lens_blurring(20.0, 96), bokeh)[..., :3].any()


# Light is kept


@pytest.mark.parametrize("depth_m", [NEAR_M, FAR_M], ids=["near", "far"])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_the_light_of_a_wall_is_kept(ctx, renderer, rng, bokeh, quality, depth_m):
    """Of the whole picture, since nothing flows over its borders."""
    color = rng.random((60, 80, 3), np.float32) + 0.5
    plate = plate_of(color, np.full((60, 80), depth_m, np.float32))
    picture = through(renderer, plate, lens_blurring(11.0, 80), bokeh, quality)
    kept = picture[..., :3].sum((0, 1), np.float64) / color.sum((0, 1), np.float64)
    np.testing.assert_allclose(kept, 1.0, atol=HALF_ROUNDING)


@pytest.mark.parametrize("coc_px", [3.0, 8.0, 13.0, 16.0, 21.0, 40.0])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_the_light_of_a_lamp_is_kept(ctx, renderer, bokeh, quality, coc_px):
    plate = point_plate(bokeh, LAMP)
    picture = through(renderer, plate, lens_blurring(coc_px, SIZE), bokeh, quality)
    mean, _, _ = moments(picture - np.float32(grey_for(bokeh)))
    assert mean / LAMP == pytest.approx(1.0, abs=0.005)


# What is in focus is not touched


@pytest.mark.parametrize("layers", [None, 1])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_a_plate_in_focus_comes_back_bit_for_bit(ctx, renderer, rng, bokeh, quality, layers):
    color = (rng.random((33, 47, 3)) * 10.0 ** rng.integers(-4, 4, (33, 47, 1))).astype(np.float32)
    plate = plate_of(color, np.full((33, 47), FOCUS_M, np.float32))
    for f_stop in (1e-2, 1.4, 64.0):
        lens = Lens(50.0, f_stop, FOCUS_M, 36.0)
        assert np.array_equal(through(renderer, plate, lens, bokeh, quality, layers), plate.color)


@pytest.mark.parametrize("bokeh", Bokeh)
def test_focus_at_infinity_keeps_the_sky_bit_for_bit(ctx, renderer, rng, bokeh):
    color = rng.random((33, 47, 3), np.float32)
    plate = plate_of(color, np.full((33, 47), np.inf, np.float32))
    lens = Lens(50.0, 1.4, math.inf, 36.0)
    assert np.array_equal(through(renderer, plate, lens, bokeh), plate.color)


@pytest.mark.parametrize("bokeh", Bokeh)
def test_a_pinhole_changes_nothing_to_see(ctx, renderer, bokeh):
    """f/100000: no circle of confusion reaches a thousandth of a pixel."""
    color, depth = room()
    picture = through(renderer, plate_of(color, depth), Lens(50.0, 1e5, FOCUS_M, 36.0), bokeh)
    np.testing.assert_allclose(picture[..., :3], color, rtol=1e-3, atol=1e-3)


# The amount of blur: a disc of diameter d has the variance d^2 / 16 along each axis

# A lamp is a pixel wide and its disc has a rim as soft as a pixel: 1/12 px^2 each.
PIXEL_VARIANCE = 2 / 12


def rising(picture: Image, bokeh: Bokeh, coc_px: float) -> Image:
    """What is brighter than the grey, so near the point that rounding elsewhere does not count."""
    centre, reach = picture.shape[0] // 2, int(2.5 * coc_px) + 2
    near = slice(max(0, centre - reach), centre + reach + 1)
    return picture[near, near, :3] - np.float32(grey_for(bokeh))


@pytest.mark.parametrize("depth_m", [NEAR_M, FAR_M], ids=["near", "far"])
@pytest.mark.parametrize("coc_px", [4.0, 12.0, 24.0])
@pytest.mark.parametrize("light", [DIM, LAMP])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_a_point_spreads_as_a_disc_does(ctx, renderer, bokeh, quality, light, coc_px, depth_m):
    plate = point_plate(bokeh, light, depth_m=depth_m)
    picture = through(renderer, plate, lens_blurring(coc_px, SIZE), bokeh, quality)
    _, *found = moments(rising(picture, bokeh, coc_px))
    pixel = PIXEL_VARIANCE if light == LAMP else 0.0
    np.testing.assert_allclose(found, coc_px**2 / 16, rtol=0.02, atol=pixel)


@pytest.mark.parametrize("light", [DIM, LAMP])
@pytest.mark.parametrize("proxy", [0.5, 0.25])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_blur_scales_with_the_proxy(ctx, renderer, bokeh, quality, proxy, light):
    size, coc_px = 256, 40.0
    plate = point_plate(bokeh, light / proxy**2, size)
    picture = through(renderer, plate, lens_blurring(coc_px, size), bokeh, quality, None, proxy)
    _, *found = moments(rising(picture, bokeh, proxy * coc_px))
    pixel = PIXEL_VARIANCE if light == LAMP else 0.0
    np.testing.assert_allclose(found, (proxy * coc_px) ** 2 / 16, rtol=0.05, atol=pixel)


@pytest.mark.parametrize("light", [DIM, LAMP])
@pytest.mark.parametrize(
    ("squeeze", "aspect"), [(2.0, 1.0), (1.33, 1.0), (1.0, 0.5), (1.0, 2.0), (2.0, 2.0)]
)
@pytest.mark.parametrize("bokeh", Bokeh)
def test_squeeze_narrows_the_disc_and_wide_pixels_lower_it(
    ctx, renderer, bokeh, squeeze, aspect, light
):
    """x / squeeze; y times the pixel's width over its height, as a length covers more of them."""
    coc_px = 14.0
    plate = replace(point_plate(bokeh, light), pixel_aspect_ratio=aspect)
    lens = lens_blurring(coc_px, SIZE, squeeze)
    _, x, y = moments(rising(through(renderer, plate, lens, bokeh), bokeh, coc_px * aspect))
    slender = max(
        squeeze * aspect, 1 / (squeeze * aspect)
    )  # a rim of a pixel adds more at its tips
    pixel = PIXEL_VARIANCE * slender * max(1.0, aspect) ** 2 if light == LAMP else 0.0
    assert x == pytest.approx((coc_px / squeeze) ** 2 / 16, rel=0.02, abs=pixel)
    assert y == pytest.approx((coc_px * aspect) ** 2 / 16, rel=0.02, abs=pixel)


@pytest.mark.parametrize("bokeh", Bokeh)
def test_half_the_f_stop_is_twice_the_blur(ctx, renderer, bokeh):
    plate, lens = point_plate(bokeh, DIM), lens_blurring(6.0, SIZE)
    wider = replace(lens, f_stop=lens.f_stop / 2)
    _, *narrow = moments(rising(through(renderer, plate, lens, bokeh), bokeh, 6.0))
    _, *wide = moments(rising(through(renderer, plate, wider, bokeh), bokeh, 12.0))
    np.testing.assert_allclose(np.divide(wide, narrow), 4.0, rtol=0.02)


# A mirrored picture


@pytest.mark.parametrize("flip", [(slice(None), slice(None, None, -1)), (slice(None, None, -1),)])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_a_mirrored_plate_gives_the_mirrored_picture(ctx, renderer, bokeh, quality, flip):
    color, depth = room(97, 55)
    plain = through(renderer, plate_of(color, depth), lens_blurring(12.0, 97), bokeh, quality)
    mirrored = plate_of(color[flip], depth[flip])
    picture = through(renderer, mirrored, lens_blurring(12.0, 97), bokeh, quality)
    difference = np.abs(np.clip(picture[flip], 0, 1) - np.clip(plain, 0, 1))
    assert difference.mean() < 2e-3


# A focus pull


@pytest.mark.parametrize(("from_m", "to_m"), [(0.8, 1.0), (1.5, 2.6)])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_a_focus_pull_does_not_pop(ctx, renderer, bokeh, quality, from_m, to_m):
    """Equal steps over dioptres are equal steps of blur, so no step changes much more than others.

    What is bright is clipped as on a screen: popping is what an eye sees.
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
def test_a_picture_does_not_depend_on_those_before_it(ctx, renderer, quality, size):
    """Textures are used again and lists are in another order each time: every bit stays."""
    renderer.load(plate_of(*room(*size)))
    shots = [Shot(lens_blurring(c, size[0]), DefocusSettings(quality=quality)) for c in (3, 12, 40)]
    first = [renderer.pixels(shot) for shot in shots]
    backwards = [renderer.pixels(shot) for shot in reversed(shots)]
    for one, other in zip(first, reversed(backwards), strict=True):
        assert np.array_equal(one, other)
