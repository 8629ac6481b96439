"""Cutouts: what a matte excludes from the blur stays as in the plate; the rest blurs without it."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.mattes.cutout import cut_out, extend_cutout
from support.plates import FAR_M, FOCUS_M, NEAR_M, coc_plate_of, lens_blurring, plate_of

WIDTH, HEIGHT, COC_PX = 160, 90, 10.0
FINER = 4
TITLE = np.array([0.95, 0.9, 0.2], np.float32)
DIFFUSION = DefocusSettings()


def disc(x_px, y_px, radius_px):
    """Return the share of each pixel inside a circle."""
    y, x = (np.mgrid[: FINER * HEIGHT, : FINER * WIDTH] + 0.5) / FINER
    inside = np.hypot(x - x_px, y - y_px) < radius_px
    return inside.reshape(HEIGHT, FINER, WIDTH, FINER).mean(axis=(1, 3)).astype(np.float32)


def wall():
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    grey = 0.4 + 0.2 * np.sin(x / 5) * np.cos(y / 4)
    return np.stack([grey, 0.8 * grey, 0.5 + 0 * grey], axis=-1)


def over(share, color, behind):
    return (share[..., None] * color + (1 - share[..., None]) * behind).astype(np.float32)


MATTE = disc(100, 45, 20.3)
RING = MATTE - disc(100, 45, 12.6)


def title_plate(title_m=NEAR_M, share=RING):
    """Return a plate of a title before a wall; a pixel's depth is that at its middle."""
    depth = np.where(share >= 0.5, title_m, 3 * FAR_M)
    return plate_of(over(share, TITLE, wall()), depth.astype(np.float32))


def with_cutout(plate, share, **fields):
    return replace(plate, cutout=cut_out(plate.pixels, share, **fields))


def render_pixels(renderer, plate, settings=DIFFUSION):
    renderer.load(plate)
    return renderer.pixels(Shot(lens_blurring(COC_PX, WIDTH), settings))


@pytest.mark.parametrize("title_m", [NEAR_M, FOCUS_M, FAR_M])
def test_cutout_keeps_title_and_blends_its_edge_over_blurred_wall(ctx, renderer, title_m):
    plate = title_plate(title_m)
    picture = render_pixels(renderer, with_cutout(plate, RING))[..., :3]
    np.testing.assert_array_equal(picture[RING == 1], plate.color[RING == 1, :3])
    far = np.full((HEIGHT, WIDTH), 3 * FAR_M, np.float32)
    truth = over(RING, TITLE, render_pixels(renderer, plate_of(wall(), far))[..., :3])
    edge = (RING > 0) & (RING < 1)
    assert np.abs(picture - truth)[edge].mean() < 0.02  # the wall behind is guessed
    assert np.abs(picture - truth)[edge].max() < 0.15
    assert np.abs(picture - truth).mean() < 0.004
    assert picture.sum() == pytest.approx(truth.sum(), rel=2e-3)  # no light is lost


def test_cutout_changes_nothing_far_from_title(ctx, renderer):
    plate = title_plate()
    without, picture = (
        render_pixels(renderer, plate),
        render_pixels(renderer, with_cutout(plate, RING)),
    )
    change = np.abs(picture - without).max(axis=2)
    assert change[:, : 80 - 5 * int(COC_PX)].max() < 1e-4
    empty = np.zeros_like(RING)
    empty[0, 0] = 1  # a single pixel in a corner
    change = np.abs(render_pixels(renderer, with_cutout(plate, empty)) - without).max(axis=2)
    assert change[45:, 80:].max() == 0


def test_nearer_object_blurs_over_cutout_title(ctx, renderer):
    plate = title_plate(FAR_M, MATTE)
    depth = plate.depth_m.copy()
    depth[:, 90:110], plate.color[:, 90:110, :3] = NEAR_M, (0.1, 0.2, 0.7)
    share = MATTE.copy()
    share[:, 90:110] = 0
    plate = plate_of(plate.color, depth)
    picture = render_pixels(renderer, with_cutout(plate, share))
    assert picture[45, 111, 2] > 0.3  # blue spills over the title,
    np.testing.assert_allclose(picture[45, 117, :3], TITLE, atol=0.02)  # as far as it is blurred
    assert picture[45, 107, 0] > 0.15  # and the title goes on behind the soft edge


@pytest.mark.parametrize("method", [Method.GATHER, Method.SCATTER, Method.PYRAMID, Method.HEAT])
def test_every_method_keeps_cutout_title(ctx, renderer, method):
    plate = title_plate()
    picture = render_pixels(renderer, with_cutout(plate, RING), DefocusSettings(method=method))
    np.testing.assert_array_equal(picture[RING == 1], plate.color[RING == 1])


def test_cutout_keeps_title_in_proxy_and_in_coc_plate(ctx, renderer):
    plate = title_plate()
    small = render_pixels(renderer, with_cutout(plate, RING), DefocusSettings(proxy=0.5))
    whole = plate.color.reshape(HEIGHT // 2, 2, WIDTH // 2, 2, 4).mean(axis=(1, 3))
    is_title = RING.reshape(HEIGHT // 2, 2, WIDTH // 2, 2).min(axis=(1, 3)) == 1
    np.testing.assert_allclose(small[is_title], whole[is_title], atol=1e-6)
    coc = coc_plate_of(plate.color, np.where(RING >= 0.5, -COC_PX, COC_PX))
    picture = render_pixels(renderer, with_cutout(coc, RING))
    np.testing.assert_array_equal(picture[RING == 1], plate.color[RING == 1])


@pytest.mark.parametrize("is_only", [False, True])
def test_cutout_keeps_colors_of_title_with_axial_color(ctx, renderer, is_only):
    plate = title_plate(FAR_M, MATTE)
    share = 1 - MATTE if is_only else MATTE
    lens = replace(lens_blurring(COC_PX, WIDTH), axial_colour_mm=0.4)
    renderer.load(with_cutout(plate, share, blurs_only_surroundings=is_only))
    picture = renderer.pixels(Shot(lens))
    is_kept = share == 1
    if is_only:  # what blurs over it ends with the reach of the blur
        is_kept &= np.hypot(*(np.mgrid[:HEIGHT, :WIDTH] - np.array([45, 100])[:, None, None])) > 60
    np.testing.assert_allclose(picture[is_kept], plate.color[is_kept], atol=2e-3)
    assert np.abs(picture - plate.color)[MATTE.astype(bool) == is_only].max() > 0.05


def test_cutout_keeps_alpha_of_title(ctx, renderer):
    share = RING[..., None]
    color = np.concatenate([share * TITLE, share], axis=-1) * np.float32(0.5)
    color[:, :40] = 1.0
    depth = np.where(RING >= 0.5, NEAR_M, np.where(color[..., 3] > 0, FAR_M, np.inf))
    plate = plate_of(color, depth.astype(np.float32), has_alpha=True)
    picture = render_pixels(renderer, with_cutout(plate, RING))
    np.testing.assert_array_equal(picture[RING == 1], color[RING == 1])


def test_lamp_behind_cutout_title_is_visible_beside_it_only(ctx, renderer):
    plate = title_plate(NEAR_M, MATTE)
    plate.color[45, 123, :3] = 300.0
    picture = render_pixels(renderer, with_cutout(plate, MATTE))
    np.testing.assert_array_equal(picture[MATTE == 1], plate.color[MATTE == 1])
    assert picture[45, 126, 0] > 1.5


@pytest.mark.parametrize("thing_m", [NEAR_M, FAR_M])
def test_cutout_with_is_only_blurs_only_the_thing(ctx, renderer, thing_m):
    plate = title_plate(thing_m, MATTE)
    depth = plate.depth_m.copy()
    depth[:, 112:], plate.color[:, 112:, :3] = NEAR_M / 2, (0.1, 0.2, 0.7)  # in front of it
    share = 1 - MATTE
    share[:, 112:] = 1
    plate = plate_of(plate.color, depth)
    picture = render_pixels(renderer, with_cutout(plate, share, blurs_only_surroundings=True))
    np.testing.assert_array_equal(picture[:, 113:], plate.color[:, 113:])
    np.testing.assert_allclose(picture[:, :40], plate.color[:, :40], atol=2e-3)
    thing = disc(100, 45, 20.3)
    spread = picture[45, 70:100, 0] - over(thing, TITLE, wall())[45, 70:100, 0]
    assert spread[:9].max() > 0.1 and spread[10:18].min() < -0.05  # out of it, and into it
    assert np.abs(picture[45, 92:104, :3] - TITLE).max() < 0.05
    assert (picture[..., 3] == 1).all()


def test_extended_cutout_keeps_title_with_border_of_other_frames(ctx, renderer):
    plate = title_plate()
    plate = with_cutout(plate, RING)
    wide = plate_of(
        np.pad(plate.color, ((8, 8), (8, 8), (0, 0)), "edge"), np.pad(plate.depth_m, 8, "edge")
    )
    window = replace(plate.data_window, x0=-8, y0=-8, x1=WIDTH + 8, y1=HEIGHT + 8)
    wide = replace(wide, data_window=window, display_window=plate.display_window)
    whole = replace(plate, with_border=extend_cutout(plate, wide))
    picture = render_pixels(renderer, whole)
    np.testing.assert_array_equal(picture[RING == 1], plate.color[RING == 1])
    assert np.abs(picture - render_pixels(renderer, plate))[20:70, 60:140].max() < 0.02
