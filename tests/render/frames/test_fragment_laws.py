"""Laws of fragment lists: what splitting, veils and lamps behind them may change, and what not."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.media.plate.plate import Plate
from support.fragment_lists import packed_lists
from support.plates import FAR_M, FOCUS_M, NEAR_M, Image, lens_blurring, plate_of

HEIGHT, WIDTH = 72, 96
CARD_END = 64  # the first column beside the card
CARD = np.s_[:, 32:CARD_END]
Layer = tuple[Image, Image, float]  # colour (H, W, 3), coverage (H, W), metres


def grey(light: float) -> Image:
    return np.full((HEIGHT, WIDTH, 3), light, np.float32)


def everywhere(cover: float) -> Image:
    return np.full((HEIGHT, WIDTH), cover, np.float32)


def listed(layers: list[Layer]) -> Plate:
    """Return the plate of `layers`, near to far, of which every pixel's list has all it is in."""
    cover = np.stack([layer[1].ravel() for layer in layers], 1)
    color = np.stack([layer[0].reshape(-1, 3) for layer in layers], 1)
    depth_m = np.broadcast_to(np.float32([layer[2] for layer in layers]), cover.shape)
    there = cover > 0
    rgba = np.concatenate([color, cover[..., None]], 2)
    lists = packed_lists(
        there.sum(1), np.ones(len(cover), bool), rgba[there], depth_m[there], is_measured=True
    )
    seen = cover * np.cumprod(np.concatenate([np.ones((len(cover), 1)), 1 - cover], 1), 1)[:, :-1]
    flat = (seen[..., None] * color).sum(1).reshape(HEIGHT, WIDTH, 3)
    nearest = depth_m[np.arange(len(cover)), there.argmax(1)].reshape(HEIGHT, WIDTH)
    return replace(plate_of(flat.astype(np.float32), nearest), fragments=lists)


def through(renderer, plate: Plate, coc_px: float, **settings: object) -> Image:
    renderer.load(plate)
    shot = Shot(lens_blurring(coc_px, WIDTH), DefocusSettings(**settings))
    return renderer.pixels(shot)[..., :3].copy()


def card(cover: float) -> Image:
    out = everywhere(0.0)
    out[CARD] = cover
    return out


def tiles() -> Image:
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    light = np.where((x // 6 + y // 6) % 2, 0.6, 0.2).astype(np.float32)
    return light[..., None] * np.float32([1.0, 0.8, 0.5])


@pytest.mark.parametrize("coc_px", [0.3, 6.0, 30.0])
def test_an_opaque_fragment_split_in_two_changes_nothing(ctx, renderer, coc_px):
    wall = (tiles(), everywhere(1.0), FAR_M)
    whole = listed([(grey(0.4), card(1.0), NEAR_M), wall])
    split = listed([(grey(0.4), card(0.25), NEAR_M), (grey(0.4), card(1.0), NEAR_M), wall])
    pictures = [through(renderer, plate, coc_px) for plate in (whole, split)]
    assert np.abs(pictures[0] - pictures[1]).max() < 1e-3


def test_a_veil_in_focus_leaves_the_blur_behind_it(ctx, renderer):
    """The truth: a half of the veil, and a half of the wall blurred by itself."""
    veiled = listed([(grey(0.8), card(0.5), FOCUS_M), (tiles(), everywhere(1.0), FAR_M)])
    wall = through(renderer, plate_of(tiles(), everywhere(FAR_M)), 12.0)
    picture = through(renderer, veiled, 12.0)
    inside, outside = np.s_[12:-12, 34:62], np.s_[12:-12, :30]
    assert np.abs(picture - 0.5 * (0.8 + wall))[inside].max() < 0.02
    assert np.abs(picture - wall)[outside].max() < 0.02


def test_a_blurred_veil_leaves_what_is_in_focus_behind_it(ctx, renderer):
    veiled = listed([(grey(0.8), everywhere(0.3), NEAR_M), (tiles(), everywhere(1.0), FOCUS_M)])
    picture = through(renderer, veiled, 12.0)
    assert np.abs(picture - (0.3 * 0.8 + 0.7 * tiles())).max() < 0.01


def light_of_lamp(renderer, before: list[Layer], column: int, coc_px: float) -> float:
    """Return the part of a lamp's light that comes past what stands before it."""
    pictures = []
    for lamp in (0.1, 400.0):
        wall = grey(0.1)
        wall[HEIGHT // 2, column] = lamp
        layers = [*before, (wall, everywhere(1.0), FAR_M)]
        pictures.append(through(renderer, listed(layers), coc_px))
    return float((pictures[1] - pictures[0]).sum() / (3 * 399.9))


@pytest.mark.parametrize(("veil_m", "coc_px"), [(NEAR_M, 6.0), (NEAR_M, 16.0), (3.9, 16.0)])
def test_a_veil_takes_its_part_of_a_lamp(ctx, renderer, veil_m, coc_px):
    """Light is kept: what of a lamp comes past a veil is the part that it does not cover."""
    parts = []
    for cover in (0.0, 0.25, 0.5):
        veil = [(grey(0.1), everywhere(cover), veil_m)] if cover else []
        parts.append(light_of_lamp(renderer, veil, WIDTH // 2, coc_px))
    np.testing.assert_allclose(parts, [1.0, 0.75, 0.5], rtol=0.03)


@pytest.mark.parametrize("card_m", [3.9, 3.4, 2.6])
@pytest.mark.parametrize("rim_px", [2, 6])
def test_a_lamp_behind_a_wide_card_gives_no_light(ctx, renderer, card_m, rim_px):
    """The picture shows something nearer there, and the wide card only beside its rim."""
    cards = [(grey(0.2), card(1.0), NEAR_M), (grey(0.1), everywhere(1.0), card_m)]
    assert abs(light_of_lamp(renderer, cards, CARD_END - rim_px, 16.0)) < 0.01


@pytest.mark.parametrize("card_m", [3.9, 3.4, 2.6])
def test_a_lamp_well_beside_a_card_keeps_its_light(ctx, renderer, card_m):
    beside = [(grey(0.1), card(1.0), card_m)]
    assert light_of_lamp(renderer, beside, CARD_END + 12, 16.0) == pytest.approx(1.0, abs=0.03)


def test_light_of_a_card_is_kept(ctx, renderer):
    """A card of light before black spreads its light and loses none."""
    sums = [
        through(
            renderer,
            listed([(grey(1.0), card(cover), NEAR_M), (grey(0.0), everywhere(1.0), FOCUS_M)]),
            12.0,
        )[20:-20].sum()
        for cover in (1.0, 0.5)
    ]
    expected = 3 * (HEIGHT - 40) * 32
    np.testing.assert_allclose(sums, [expected, 0.5 * expected], rtol=0.01)


def test_what_a_plate_behind_lacks_of_light_is_matched_to_what_is_seen(ctx, renderer):
    """A clean plate a third darker than the wall around the card shows no step at the rim."""
    color = np.where(card(1.0)[..., None] > 0, np.float32(0.05), np.float32(0.6))
    depth_m = np.where(card(1.0) > 0, np.float32(NEAR_M), np.float32(FOCUS_M))
    flat = plate_of(color, depth_m)
    pictures = [
        through(renderer, with_behind(flat, [plate_of(grey(light), everywhere(FOCUS_M))]), 16.0)
        for light in (0.6, 0.4)
    ]
    assert np.abs(pictures[0] - pictures[1]).max() < 0.01
