"""Known surfaces behind a picture: they follow the laws of the lens and beat a guessed fill."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import convolve

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.media.plate.fragments import FragmentLists
from heatlens.media.plate.plate import Plate
from support.fragment_lists import packed_lists
from support.lamps import HALF_ROUNDING
from support.plates import FAR_M, FOCUS_M, NEAR_M, Image, lens_blurring, plate_of, room

KINDS = [(bokeh, quality) for bokeh in Bokeh for quality in Quality]
WIDTH, HEIGHT = 160, 96


def render_through_lens(renderer, plate: Plate, coc_px: float, *settings: object) -> Image:
    renderer.load(plate)
    lens = lens_blurring(coc_px, plate.display_window.width)
    return renderer.pixels(Shot(lens, DefocusSettings(*settings)))


def wall(light: Image | float, depth_m: float, shape: tuple[int, int]) -> Plate:
    color = np.broadcast_to(np.asarray(light, np.float32), (*shape, 3))
    return plate_of(color, np.full(shape, depth_m, np.float32))


def stripes(height: int = HEIGHT, width: int = WIDTH) -> Image:
    """Return upright stripes of two colours, 4 pixels wide."""
    is_light = (np.arange(width) // 4 % 2).astype(np.float32)
    tint = np.array([0.9, 0.6, 0.2], np.float32)
    return np.broadcast_to((0.1 + 0.7 * is_light)[None, :, None] * tint, (height, width, 3))


def card_before(back: Image, back_m: float) -> tuple[Plate, Plate]:
    """Return a plate with a grey card 40 px wide in front of `back`, and `back` alone."""
    is_card = np.zeros((HEIGHT, WIDTH), bool)
    is_card[:, 60:100] = True
    color = np.where(is_card[..., None], np.float32(0.4), back)
    depth_m = np.where(is_card, np.float32(NEAR_M), np.float32(back_m))
    return plate_of(color, depth_m), plate_of(back, np.full(is_card.shape, back_m, np.float32))


def disc(diameter: float, samples: int = 16) -> Image:
    """Return the disc as pixels see it, light 1."""
    side = 2 * int(diameter / 2 + 1) + 1
    at = (np.arange(side * samples) + 0.5) / samples - side / 2
    inside = at[:, None] ** 2 + at**2 <= diameter**2 / 4
    parts = inside.reshape(side, samples, side, samples).mean((1, 3))
    return np.asarray(parts / parts.sum(), np.float32)


@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_hidden_surfaces_do_not_change_plate_in_focus(ctx, renderer, bokeh, quality):
    color, _ = room()
    flat = plate_of(color, np.full(color.shape[:2], FOCUS_M, np.float32))
    plate = with_behind(flat, [wall(5.0, FAR_M, color.shape[:2])])
    assert plate.fragments is not None
    for coc_px in (0.5, 12.0):
        expected = render_through_lens(renderer, flat, coc_px, bokeh, quality)
        assert np.array_equal(
            render_through_lens(renderer, plate, coc_px, bokeh, quality), expected
        )


@pytest.mark.parametrize("coc_px", [3.0, 12.0, 40.0])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_uniform_color_with_hidden_surfaces_stays_uniform(ctx, renderer, bokeh, quality, coc_px):
    _, depth_m = room()
    tint = np.array([0.25, 0.75, 1.0], np.float32)
    flat = plate_of(np.broadcast_to(tint, (*depth_m.shape, 3)), depth_m)
    behind = [wall(tint, 3.0, depth_m.shape), wall(tint, 9.0, depth_m.shape)]
    picture = render_through_lens(renderer, with_behind(flat, behind), coc_px, bokeh, quality)
    assert np.abs(picture[..., :3] / tint - 1).max() < 4 * HALF_ROUNDING


def test_hidden_copy_of_the_plate_changes_nothing(ctx, renderer):
    color, depth_m = room()
    flat = plate_of(color, depth_m)
    expected = render_through_lens(renderer, flat, 12.0)
    assert np.array_equal(render_through_lens(renderer, with_behind(flat, [flat]), 12.0), expected)


def test_order_of_hidden_surfaces_does_not_matter(ctx, renderer):
    color, depth_m = room()
    flat = plate_of(color, depth_m)
    behind = [wall(0.2, 3.5, depth_m.shape), wall(0.7, 9.0, depth_m.shape)]
    pictures = [
        render_through_lens(renderer, with_behind(flat, order), 12.0)
        for order in (behind, behind[::-1])
    ]
    assert np.array_equal(*pictures)


def test_known_wall_behind_blurred_card_is_nearer_to_truth(ctx, renderer):
    """Compare guessed and known fill with the card's blurred coverage over the sharp wall."""
    back, coc_px = stripes(), 24.0
    flat, clean = card_before(back, FOCUS_M)
    is_card = (flat.depth_m == NEAR_M).astype(np.float32)
    cover = convolve(is_card, disc(coc_px), mode="nearest")[..., None]
    truth = cover * 0.4 + (1 - cover) * back
    guessed = render_through_lens(renderer, flat, coc_px)[..., :3]
    known = render_through_lens(renderer, with_behind(flat, [clean]), coc_px)[..., :3]
    inside = np.s_[20:-20, 62:98]  # of the card, where the wall is uncovered
    errors = [np.abs(picture - truth)[inside].mean() for picture in (guessed, known)]
    assert errors[1] < 0.35 * errors[0]
    assert errors[1] < 0.02
    outside = np.s_[20:-20, :45]
    assert np.abs(known - truth)[outside].max() < 0.01


def test_highlight_hidden_by_middle_of_card_adds_no_light(ctx, renderer):
    """Hide a lamp behind the middle of the card, where no part of the lens sees it."""
    back = np.full((HEIGHT, WIDTH, 3), 0.1, np.float32)
    flat, _ = card_before(back, FAR_M)
    lit = back.copy()
    lit[HEIGHT // 2, 80] = 500.0
    dark, bright = (
        with_behind(flat, [wall(light, FAR_M, (HEIGHT, WIDTH))]) for light in (back, lit)
    )
    pictures = [render_through_lens(renderer, plate, 12.0)[..., :3] for plate in (dark, bright)]
    assert np.abs(pictures[1] - pictures[0]).max() < 0.01


def test_highlight_hidden_at_edge_of_card_shows_half_its_disc(ctx, renderer):
    back = np.full((HEIGHT, WIDTH, 3), 0.1, np.float32)
    flat, _ = card_before(back, FAR_M)
    lit = back.copy()
    lit[HEIGHT // 2, 60] = 500.0  # behind the card's first column
    lit_plate = with_behind(flat, [wall(lit, FAR_M, (HEIGHT, WIDTH))])
    dark_plate = with_behind(flat, [wall(back, FAR_M, (HEIGHT, WIDTH))])
    light = (
        render_through_lens(renderer, lit_plate, 16.0)[..., 0]
        - render_through_lens(renderer, dark_plate, 16.0)[..., 0]
    )
    assert 0.3 * 500 < light.sum() < 0.7 * 500
    assert light[:, :60].sum() > 10 * light[:, 62:].sum()


def half_covered(is_measured: bool) -> Plate:
    """Return a plate whose pixels show half of a near and half of a far surface."""
    near, far = np.float32([0.8, 0.2, 0.1]), np.float32([0.1, 0.3, 0.6])
    shape, count = (HEIGHT, WIDTH), HEIGHT * WIDTH
    rgba = np.ones((count, 2, 4), np.float32)
    rgba[:, 0, :3], rgba[:, 0, 3], rgba[:, 1, :3] = near, 0.5, far
    depth_m = np.broadcast_to(np.float32([NEAR_M, FAR_M]), (count, 2))
    lists: FragmentLists = packed_lists(
        np.full(count, 2), np.ones(count, bool), rgba.reshape(-1, 4), depth_m.ravel(), is_measured
    )
    color = np.broadcast_to(0.5 * near + 0.5 * far, (*shape, 3))
    plate = plate_of(color, np.full(shape, NEAR_M, np.float32))
    return replace(plate, fragments=lists)


@pytest.mark.parametrize("is_measured", [False, True])
@pytest.mark.parametrize("coc_px", [0.5, 9.0, 30.0])
def test_even_half_veil_gives_mean_of_both_surfaces(ctx, renderer, coc_px, is_measured):
    plate = half_covered(is_measured)
    picture = render_through_lens(renderer, plate, coc_px)
    assert np.abs(picture[..., :3] - plate.color[..., :3]).max() < 2e-3


def test_proxy_with_lists_is_near_mean_of_whole_picture(ctx, renderer):
    back = stripes()
    flat, clean = card_before(back, FOCUS_M)
    plate = with_behind(flat, [clean])
    whole = render_through_lens(renderer, plate, 24.0)[..., :3]
    renderer.load(plate)
    lens = lens_blurring(24.0, WIDTH)
    half = renderer.pixels(Shot(lens, DefocusSettings(proxy=0.5)))[..., :3]
    mean = whole.reshape(HEIGHT // 2, 2, WIDTH // 2, 2, 3).mean((1, 3))
    inside = np.s_[10:-10, 31:49]
    assert np.abs(half - mean)[inside].mean() < 0.03
