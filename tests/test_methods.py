"""The field's other methods through the same renderer: what each promises, and what all do."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from command_line import CAMERA, channels, picture
from command_line import render as render_file
from exr_files import write_file
from heatlens.commands.main import main
from heatlens.defocus import gather_pass, scatter_pass
from heatlens.defocus.gather_pass import gather_steps
from heatlens.defocus.kernels import named_kernel
from heatlens.defocus.pyramid_pass import level_places, level_variance, pyramid_size
from heatlens.defocus.quality import kernel_for
from heatlens.defocus.scatter_pass import BINS, bin_coc_px, bin_places, disc_sums
from heatlens.gpu.textures import download
from heatlens.image.shot_file import write_shot
from heatlens.model.boxes import Box
from heatlens.model.lens import Lens
from heatlens.model.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer, drained
from plates import (
    FAR_M,
    FOCUS_M,
    NEAR_M,
    Image,
    coc_plate_of,
    lens_blurring,
    moments,
    plate_of,
    room,
)
from test_disc import analytic_disc, radius_at_half_height, size_for

OF_PLATES = [method for method in Method if not method.needs_scene]
OTHERS = [Method.GATHER, Method.SCATTER, Method.PYRAMID]
DISCS = [Method.GATHER, Method.SCATTER]
ANY_LENS = Lens(50.0, 2.0, FOCUS_M, 36.0)
# A disc's rim is a ramp one pixel wide, and the disc is of a pixel: 1/12 px^2 each.
PIXEL_VARIANCE = 2 / 12


def through(
    renderer: FrameRenderer, plate, method: Method, lens: Lens = ANY_LENS, proxy: float = 1.0
) -> Image:
    renderer.load(plate)
    return renderer.pixels(Shot(lens, DefocusSettings(method=method, proxy=proxy)))


def point_blurred(renderer: FrameRenderer, method: Method, coc_px: float, side: int) -> Image:
    """One white pixel on black, the same signed coc everywhere."""
    color = np.zeros((side, side, 3), np.float32)
    color[side // 2, side // 2] = 1.0
    plate = coc_plate_of(color, np.full((side, side), coc_px, np.float32))
    return through(renderer, plate, method)


# What all do


@pytest.mark.parametrize("method", OF_PLATES)
@pytest.mark.parametrize("coc_px", [1.5, 40.0])
def test_one_colour_over_many_depths_stays_that_colour(ctx, renderer, method, coc_px):
    _, depth = room()
    tint = np.array([0.25, 0.75, 8.0], np.float32)
    plate = plate_of(np.broadcast_to(tint, (*depth.shape, 3)), depth)
    blurred = through(renderer, plate, method, lens_blurring(coc_px, 96))
    assert np.abs(blurred[..., :3] / tint - 1.0).max() < 2e-3
    assert np.array_equal(blurred[..., 3], np.ones(depth.shape))


@pytest.mark.parametrize("method", OF_PLATES)
def test_a_plate_in_focus_comes_back_bit_for_bit(ctx, renderer, rng, method):
    color = (rng.random((33, 47, 3)) * 10.0 ** rng.integers(-4, 4, (33, 47, 1))).astype(np.float32)
    plate = plate_of(color, np.full((33, 47), FOCUS_M, np.float32))
    assert np.array_equal(through(renderer, plate, method), plate.color)


@pytest.mark.parametrize("method", [Method.GATHER, Method.SCATTER, Method.PYRAMID, Method.HEAT])
def test_sharp_pixels_before_a_blurred_background_are_not_touched(ctx, renderer, rng, method):
    color = rng.random((48, 64, 3), np.float32)
    depth = np.full((48, 64), FAR_M, np.float32)
    depth[10:30, 20:40] = FOCUS_M
    blurred = through(renderer, plate_of(color, depth), method, lens_blurring(15.0, 64))
    assert np.array_equal(blurred[10:30, 20:40, :3], color[10:30, 20:40])
    assert not np.allclose(blurred[35:, :, :3], color[35:], atol=0.1)


@pytest.mark.parametrize("method", OF_PLATES)
@pytest.mark.parametrize("size", [(1, 1), (1, 7), (7, 1), (3, 5), (33, 47)])
@pytest.mark.parametrize("coc_px", [3.0, -30.0])
def test_pictures_of_any_size_are_blurred(ctx, renderer, rng, method, size, coc_px):
    """The mean of a picture lies between its darkest and its brightest, and so does every pixel."""
    color = rng.random((*size, 3), np.float32) + 0.5
    blurred = through(renderer, coc_plate_of(color, np.full(size, coc_px, np.float32)), method)
    assert blurred.shape == (*size, 4)
    slack = 0.05 if method is Method.DIFFUSION else 2e-3
    assert blurred[..., :3].min() >= color.min() - slack
    assert blurred[..., :3].max() <= color.max() + slack


@pytest.mark.parametrize("method", OTHERS)
def test_a_mirrored_plate_gives_the_mirrored_picture(ctx, renderer, method):
    """The pyramid's levels begin at the left: with 2^n + 1 pixels they end alike."""
    color, depth = room(129, 65)
    plain = through(renderer, plate_of(color, depth), method, lens_blurring(12.0, 129))
    for flip in ((slice(None), slice(None, None, -1)), (slice(None, None, -1),)):
        mirrored = plate_of(color[flip].copy(), depth[flip].copy())
        blurred = through(renderer, mirrored, method, lens_blurring(12.0, 129))
        np.testing.assert_allclose(blurred[flip], plain, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("method", OTHERS)
def test_pixels_far_from_the_origin_of_their_window_are_blurred_alike(ctx, renderer, method):
    color, depth = room()
    plate = plate_of(color, depth)
    here = through(renderer, plate, method, lens_blurring(12.0, 96))
    moved = replace(plate, data_window=Box(-500, 300, -404, 354))
    assert np.array_equal(through(renderer, moved, method, lens_blurring(12.0, 96)), here)


@pytest.mark.parametrize("method", OTHERS)
def test_a_coc_plate_is_blurred_as_its_depth_would_be(ctx, renderer, method):
    color, _ = room()
    depth = np.where(np.arange(96) < 48, FAR_M, NEAR_M) * np.ones((54, 1))
    coc = np.where(depth == FAR_M, 9.0, -9.0)
    by_depth = through(renderer, plate_of(color, depth), method, lens_blurring(9.0, 96))
    by_coc = through(renderer, coc_plate_of(color, coc), method)
    np.testing.assert_allclose(by_coc, by_depth, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("method", OTHERS)
@pytest.mark.parametrize("proxy", [0.5, 0.25])
def test_blur_scales_with_the_proxy(ctx, renderer, method, proxy):
    """The lamp is one pixel of the proxy, its disc as wide as the smaller picture makes it."""
    color = np.zeros((256, 256, 3), np.float32)
    block = round(1 / proxy)
    color[128 : 128 + block, 128 : 128 + block] = 1.0
    plate = plate_of(color, np.full((256, 256), FAR_M, np.float32))
    blurred = through(renderer, plate, method, lens_blurring(40.0, 256), proxy)
    assert blurred.shape[:2] == (256 * proxy, 256 * proxy)
    light, *found = moments(blurred)
    assert light == pytest.approx(1.0, rel=1e-3)
    np.testing.assert_allclose(found, (proxy * 40.0) ** 2 / 16, rtol=0.01, atol=PIXEL_VARIANCE)


@pytest.mark.parametrize("method", OTHERS)
def test_alpha_is_blurred_as_a_fourth_colour(ctx, renderer, rng, method):
    """A plate whose alpha is its red has it afterwards; opaque and clear are the ends."""
    color, depth = room()
    red = np.clip(color[..., :1], 0.0, 1.0)
    rgba = np.concatenate([np.repeat(red, 3, axis=2), red], axis=2)
    plate = plate_of(rgba, depth, has_alpha=True)
    blurred = through(renderer, plate, method, lens_blurring(12.0, 96))
    np.testing.assert_allclose(blurred[..., 3], blurred[..., 0], rtol=1e-6, atol=1e-7)
    assert 0.0 <= blurred[..., 3].min() < blurred[..., 3].max() <= 1.0


@pytest.mark.parametrize("method", OTHERS)
def test_steps_make_the_picture_and_are_of_one_pass(ctx, renderer, method):
    renderer.load(plate_of(*room()))
    shot = Shot(lens_blurring(12.0, 96), DefocusSettings(method=method))
    whole = renderer.pixels(shot)
    names = list(renderer.steps(shot, slot=1))
    assert set(names) == {"coc", str(method), "limits"}
    assert np.array_equal(download(drained(renderer.steps(shot, slot=1))), whole)


@pytest.mark.parametrize("method", OTHERS)
def test_steps_left_early_leave_nothing_behind(ctx, renderer, method):
    renderer.load(plate_of(*room()))
    shot = Shot(lens_blurring(12.0, 96), DefocusSettings(method=method))
    expected = renderer.pixels(shot)
    for taken in (2, 3):
        left = renderer.steps(replace(shot, lens=lens_blurring(30.0, 96)))
        for _ in range(taken):
            next(left)
        left.close()
        assert np.array_equal(renderer.pixels(shot), expected)


# The amount of blur: a disc of diameter d has the variance d^2 / 16 along each axis


@pytest.mark.parametrize("method", OTHERS)
@pytest.mark.parametrize("coc_px", [3.0, -6.0, 13.0, 16.1, 40.0])
def test_a_point_keeps_its_light_and_spreads_as_a_disc(ctx, renderer, method, coc_px):
    side = 2 * int(3 * abs(coc_px)) + 33
    light, *variances = moments(point_blurred(renderer, method, coc_px, side))
    assert light == pytest.approx(1.0, rel=1e-3)
    pixel = 0.0 if method is Method.PYRAMID else 1.2 * PIXEL_VARIANCE
    np.testing.assert_allclose(variances, coc_px**2 / 16, rtol=0.005, atol=pixel)


@pytest.mark.parametrize("method", DISCS)
@pytest.mark.parametrize("diameter", [4.0, 5.0, 8.0, 16.0, 30.0, 75.0])
def test_a_point_becomes_the_disc_itself(ctx, renderer, method, diameter):
    disc = analytic_disc(diameter)
    blurred = point_blurred(renderer, method, diameter, size_for(diameter))[..., 0]
    expected = radius_at_half_height(disc, diameter)
    found = radius_at_half_height(blurred.astype(np.float64), diameter)
    assert found == pytest.approx(expected, rel=0.03)
    assert np.linalg.norm(blurred - disc) < 0.1 * np.linalg.norm(disc)


@pytest.mark.parametrize("method", OTHERS)
@pytest.mark.parametrize(("squeeze", "aspect"), [(2.0, 1.0), (1.0, 2.0), (1.0, 0.5), (2.0, 2.0)])
def test_squeeze_narrows_the_disc_and_wide_pixels_lower_it(ctx, renderer, method, squeeze, aspect):
    color = np.zeros((129, 129, 3), np.float32)
    color[64, 64] = 1.0
    plate = replace(
        plate_of(color, np.full((129, 129), FAR_M, np.float32)), pixel_aspect_ratio=aspect
    )
    blurred = through(renderer, plate, method, lens_blurring(14.0, 129, squeeze))
    light, x, y = moments(blurred)
    assert light == pytest.approx(1.0, rel=2e-3)
    slack = 2 * PIXEL_VARIANCE * max(1.0, squeeze * aspect, 1 / (squeeze * aspect))
    assert x == pytest.approx((14.0 / squeeze) ** 2 / 16, rel=0.02, abs=slack)
    assert y == pytest.approx((14.0 * aspect) ** 2 / 16, rel=0.02, abs=slack)


@pytest.mark.parametrize("method", OTHERS)
def test_the_light_of_a_wall_is_kept_away_from_its_borders(ctx, renderer, rng, method):
    color = np.zeros((96, 96, 3), np.float32)
    color[32:64, 32:64] = rng.random((32, 32, 3))
    plate = coc_plate_of(color, np.full((96, 96), -11.0, np.float32))
    light = through(renderer, plate, method)[..., :3].sum((0, 1), np.float64)
    np.testing.assert_allclose(light / color.sum((0, 1), np.float64), 1.0, atol=1e-3)


# Occlusion


def two_halves(left_coc: float, right_coc: float) -> Image:
    """White on the left of black, each with its coc."""
    color = np.zeros((64, 96, 3), np.float32)
    color[:, :48] = 1.0
    coc = np.full((64, 96), right_coc, np.float32)
    coc[:, :48] = left_coc
    return coc_plate_of(color, coc)


@pytest.mark.parametrize("method", DISCS)
def test_a_blurred_background_does_not_cover_what_is_sharp_before_it(ctx, renderer, method):
    row = through(renderer, two_halves(20.0, 0.0), method)[32, :, 0]
    assert not row[48:].any()
    np.testing.assert_allclose(row[:48], 1.0, atol=1e-5)  # nor does the sharp black smear into it


def test_a_scattered_foreground_spills_over_what_is_sharp_behind_it(ctx, renderer):
    """By the part of the disc that lies over the edge, 1 - F(x) for a disc's distribution F."""
    row = through(renderer, two_halves(-20.0, 0.0), Method.SCATTER)[32, :, 0]
    x = (np.arange(48, 58) + 0.5 - 48) / 10.0
    covered = (np.arccos(x) - x * np.sqrt(1 - x**2)) / math.pi
    np.testing.assert_allclose(row[48:58], covered, atol=0.01)
    assert not row[60:].any()


def test_a_gathered_foreground_ends_where_it_is_sharp_beyond(ctx, renderer):
    """The known weakness of gathering with a pixel's own disc: no spill."""
    assert not through(renderer, two_halves(-20.0, 0.0), Method.GATHER)[32, 48:, 0].any()


def test_a_pyramid_knows_no_depth(ctx, renderer):
    """The known weakness of levels: what is sharp flows into the blurred beside it."""
    row = through(renderer, two_halves(20.0, 0.0), Method.PYRAMID)[32, :, 0]
    assert 0.4 < row[47] < 0.9 and not row[48:].any()


def test_scattered_discs_hide_those_behind_in_any_order_of_the_picture(ctx, renderer):
    """Three depths, mirrored: who comes first in memory does not matter, who is nearer does."""
    plate = two_halves(-20.0, 30.0)
    row = through(renderer, plate, Method.SCATTER)[32, :, 0]
    flipped = coc_plate_of(plate.color[:, ::-1, :3].copy(), plate.coc_px[:, ::-1].copy())
    mirrored = through(renderer, flipped, Method.SCATTER)[32, ::-1, 0]
    np.testing.assert_allclose(row, mirrored, atol=1e-5)
    assert (np.diff(row) <= 1e-6).all()


# In parts


def test_a_disc_in_parts_is_the_disc(ctx, renderer, rng, monkeypatch):
    color, coc = rng.random((40, 50, 3), np.float32), np.linspace(-25, 25, 50) * np.ones((40, 1))
    plate = coc_plate_of(color, coc.astype(np.float32))
    whole = {method: through(renderer, plate, method) for method in DISCS}
    monkeypatch.setattr(gather_pass, "_SAMPLES_PER_STEP", 3000)
    monkeypatch.setattr(scatter_pass, "_FRAGMENTS_PER_STEP", 3000)
    for method in DISCS:
        np.testing.assert_allclose(through(renderer, plate, method), whole[method], rtol=1e-5)


@pytest.mark.parametrize("size", [(1920, 1080), (1, 1), (7, 4000), (4000, 7)])
@pytest.mark.parametrize("reach", [(1, 1), (101, 101), (60, 240), (50_000, 50_000)])
def test_gather_steps_cover_disc_and_picture_once_and_are_short(size, reach):
    steps = gather_steps(size, reach)
    rows = sum(s.disc_last - s.disc_first + 1 for s in steps if s.band_start == 0)
    assert rows == 2 * min(reach[1], size[1] - 1) + 1
    bands = sorted({(s.band_start, s.band_rows) for s in steps})
    assert sum(rows for _, rows in bands) >= size[1]
    assert all(a + rows == b for (a, rows), (b, _) in pairwise(bands))
    across = 2 * min(reach[0], size[0] - 1) + 1
    assert all((s.disc_last - s.disc_first + 1) * (across + 1) < 65_535 for s in steps)


def test_bins_lie_far_to_near_in_the_pixels_own_order():
    counts = np.zeros((2, BINS), np.uint32)
    counts[:, 5], counts[:, 40] = (2, 3), (1, 4)
    places = bin_places(counts)
    assert (places[0, 40], places[1, 40]) == (0, 1)
    assert (places[0, 5], places[1, 5]) == (5, 7)


def test_bins_hold_a_quarter_more_each():
    assert bin_coc_px(32, 100.0) == 1.0
    assert bin_coc_px(35, 100.0) == bin_coc_px(29, 100.0) == pytest.approx(1.25**3)
    assert bin_coc_px(63, 2e4) == bin_coc_px(0, 2e4) == 2e4


def test_sums_of_small_discs_come_close_to_their_area():
    sums = disc_sums((1.0, 1.0))
    assert sums[128] == pytest.approx(math.pi * (64 + 1 / 12), rel=0.005)
    assert disc_sums((0.5, 1.0))[128] == pytest.approx(sums[128] / 2, rel=0.01)


def test_levels_lie_apart_and_inside():
    for size in ((1, 1), (2, 3), (1920, 1080), (5, 4000)):
        places = level_places(size, math.inf)
        covered = np.zeros(pyramid_size(places)[::-1], int)
        for x, y, width, height in places:
            covered[y : y + height, x : x + width] += 1
        assert covered.max() == 1
        assert covered.shape[0] <= size[1] + 16 and covered.shape[1] <= size[0] + 16


def test_as_many_levels_as_the_widest_disc_asks_for():
    assert level_places((640, 480), 0.0) == []
    for widest in (1.0, 20.0, 200.0):
        levels = len(level_places((4096, 4096), widest))
        assert level_variance(levels) >= widest**2 / 16 > level_variance(levels - 1)


# Settings


def test_heat_is_one_layer_of_heat(ctx, renderer):
    plate, lens = plate_of(*room()), lens_blurring(12.0, 96)
    renderer.load(plate)
    basic = renderer.pixels(Shot(lens, DefocusSettings(Bokeh.HEAT, layers=1)))
    for settings in (DefocusSettings(method=Method.HEAT), DefocusSettings(Bokeh.DISC, layers=5)):
        heat = renderer.pixels(Shot(lens, replace(settings, method=Method.HEAT)))
        assert np.array_equal(heat, basic)
    assert kernel_for(DefocusSettings(method=Method.HEAT)) == named_kernel("heat")


def test_bokeh_quality_and_layers_are_of_diffusion_alone(ctx, renderer):
    renderer.load(plate_of(*room()))
    lens = lens_blurring(12.0, 96)
    for method in OTHERS:
        plain = renderer.pixels(Shot(lens, DefocusSettings(method=method)))
        other = DefocusSettings(Bokeh.GAUSSIAN, Quality.DRAFT, 3, 1.0, method)
        assert np.array_equal(renderer.pixels(Shot(lens, other)), plain)


@pytest.mark.usefixtures("command_context")
@pytest.mark.parametrize("method", OF_PLATES)
def test_render_takes_every_method(capsys, tmp_path, method):
    plate, out = tmp_path / "plate.exr", tmp_path / "out.exr"
    write_file(plate, channels(), **CAMERA)
    render_file(capsys, plate, out, "--method", method, "--f-stop", 0.2)
    _, pixels = picture(out)
    color = np.stack([channels()[name] for name in "RGB"], axis=2)
    assert np.isfinite(pixels).all() and np.abs(pixels[..., :3] - color).max() > 0.01


@pytest.mark.usefixtures("command_context")
def test_an_exported_frame_is_of_the_shots_method_or_the_one_that_is_given(capsys, tmp_path):
    plate = write_file(tmp_path / "plate.exr", channels(), **CAMERA)
    shot_file = tmp_path / "s.heatlens.json"
    lens = Lens(50.0, 0.2, 2.24, 36.0)
    write_shot(shot_file, Shot(lens, DefocusSettings(method=Method.SCATTER), source=str(plate)))
    for words, method in (((), Method.SCATTER), (("--method", "gather"), Method.GATHER)):
        exported, rendered = tmp_path / f"{method}.exr", tmp_path / f"r_{method}.exr"
        assert main(["export", str(shot_file), "-o", str(exported), *words]) == 0
        capsys.readouterr()
        render_file(capsys, plate, rendered, "--method", method, "--f-stop", 0.2)
        assert np.array_equal(picture(exported)[1], picture(rendered)[1])
    assert not np.array_equal(picture(exported)[1], picture(tmp_path / "scatter.exr")[1])
