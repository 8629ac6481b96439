"""Laws of fragment lists (deep samples): splitting fragments, veils, and lamps behind veils."""

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


def plate_of_layers(layers: list[Layer]) -> Plate:
    """Return the plate of `layers`, near to far; each pixel lists all layers that cover it."""
    cover = np.stack([layer[1].ravel() for layer in layers], 1)
    color = np.stack([layer[0].reshape(-1, 3) for layer in layers], 1)
    depth_m = np.broadcast_to(np.float32([layer[2] for layer in layers]), cover.shape)
    is_covered = cover > 0
    rgba = np.concatenate([color, cover[..., None]], 2)
    lists = packed_lists(
        is_covered.sum(1),
        np.ones(len(cover), bool),
        rgba[is_covered],
        depth_m[is_covered],
        is_measured=True,
    )
    visible_share = (
        cover * np.cumprod(np.concatenate([np.ones((len(cover), 1)), 1 - cover], 1), 1)[:, :-1]
    )
    flat = (visible_share[..., None] * color).sum(1).reshape(HEIGHT, WIDTH, 3)
    nearest = depth_m[np.arange(len(cover)), is_covered.argmax(1)].reshape(HEIGHT, WIDTH)
    return replace(plate_of(flat.astype(np.float32), nearest), fragments=lists)


def render_through_lens(renderer, plate: Plate, coc_px: float, **settings: object) -> Image:
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
def test_splitting_an_opaque_fragment_keeps_picture(ctx, renderer, coc_px):
    wall = (tiles(), everywhere(1.0), FAR_M)
    whole = plate_of_layers([(grey(0.4), card(1.0), NEAR_M), wall])
    split = plate_of_layers([(grey(0.4), card(0.25), NEAR_M), (grey(0.4), card(1.0), NEAR_M), wall])
    pictures = [render_through_lens(renderer, plate, coc_px) for plate in (whole, split)]
    assert np.abs(pictures[0] - pictures[1]).max() < 1e-3


def test_wall_behind_veil_in_focus_is_blurred(ctx, renderer):
    """Compare with half of the veil plus half of the wall blurred alone."""
    veiled = plate_of_layers([(grey(0.8), card(0.5), FOCUS_M), (tiles(), everywhere(1.0), FAR_M)])
    wall = render_through_lens(renderer, plate_of(tiles(), everywhere(FAR_M)), 12.0)
    picture = render_through_lens(renderer, veiled, 12.0)
    inside, outside = np.s_[12:-12, 34:62], np.s_[12:-12, :30]
    assert np.abs(picture - 0.5 * (0.8 + wall))[inside].max() < 0.02
    assert np.abs(picture - wall)[outside].max() < 0.02


def test_wall_in_focus_behind_blurred_veil_is_sharp(ctx, renderer):
    veiled = plate_of_layers(
        [(grey(0.8), everywhere(0.3), NEAR_M), (tiles(), everywhere(1.0), FOCUS_M)]
    )
    picture = render_through_lens(renderer, veiled, 12.0)
    assert np.abs(picture - (0.3 * 0.8 + 0.7 * tiles())).max() < 0.01


def light_of_lamp(renderer, front_layers: list[Layer], column: int, coc_px: float) -> float:
    """Return the share of a lamp's light that the layers in `before` let through."""
    pictures = []
    for lamp in (0.1, 400.0):
        wall = grey(0.1)
        wall[HEIGHT // 2, column] = lamp
        layers = [*front_layers, (wall, everywhere(1.0), FAR_M)]
        pictures.append(render_through_lens(renderer, plate_of_layers(layers), coc_px))
    return float((pictures[1] - pictures[0]).sum() / (3 * 399.9))


@pytest.mark.parametrize(("veil_m", "coc_px"), [(NEAR_M, 6.0), (NEAR_M, 16.0), (3.9, 16.0)])
def test_veil_dims_lamp_by_its_coverage(ctx, renderer, veil_m, coc_px):
    """Check that the share of a lamp's light that passes a veil is 1 minus the veil's coverage."""
    parts = []
    for cover in (0.0, 0.25, 0.5):
        veil = [(grey(0.1), everywhere(cover), veil_m)] if cover else []
        parts.append(light_of_lamp(renderer, veil, WIDTH // 2, coc_px))
    np.testing.assert_allclose(parts, [1.0, 0.75, 0.5], rtol=0.03)


@pytest.mark.parametrize("card_m", [3.9, 3.4, 2.6])
@pytest.mark.parametrize("rim_px", [2, 6])
def test_lamp_hidden_by_wide_card_adds_no_light(ctx, renderer, card_m, rim_px):
    """Hide the lamp behind a wide card, which shows only beside the edge of a nearer card."""
    cards = [(grey(0.2), card(1.0), NEAR_M), (grey(0.1), everywhere(1.0), card_m)]
    assert abs(light_of_lamp(renderer, cards, CARD_END - rim_px, 16.0)) < 0.01


@pytest.mark.parametrize("card_m", [3.9, 3.4, 2.6])
def test_lamp_beside_card_keeps_its_light(ctx, renderer, card_m):
    front_layers = [(grey(0.1), card(1.0), card_m)]
    assert light_of_lamp(renderer, front_layers, CARD_END + 12, 16.0) == pytest.approx(
        1.0, abs=0.03
    )


def test_blurred_card_keeps_its_light(ctx, renderer):
    """Check the sum of the light of a blurred white card before black."""
    sums = [
        render_through_lens(
            renderer,
            plate_of_layers(
                [(grey(1.0), card(cover), NEAR_M), (grey(0.0), everywhere(1.0), FOCUS_M)]
            ),
            12.0,
        )[20:-20].sum()
        for cover in (1.0, 0.5)
    ]
    expected = 3 * (HEIGHT - 40) * 32
    np.testing.assert_allclose(sums, [expected, 0.5 * expected], rtol=0.01)


@pytest.mark.parametrize(("wall", "most"), [((0.6, 0.6, 0.6), 0.01), ((0.6, 1.0, 1.0), 0.02)])
def test_darker_clean_plate_is_matched_to_visible_wall(ctx, renderer, wall, most):
    """Compare with a clean plate a third darker than the wall: no step at the card's edge.

    Clean plates of another color than the wall change its mixed pixels a little.
    """
    color = np.where(card(1.0)[..., None] > 0, np.float32((0.05, *wall[1:])), np.float32(wall))
    depth_m = np.where(card(1.0) > 0, np.float32(NEAR_M), np.float32(FOCUS_M))
    flat = plate_of(color, depth_m)
    pictures = [
        render_through_lens(
            renderer, with_behind(flat, [plate_of(grey(light), everywhere(FOCUS_M))]), 16.0
        )
        for light in (0.6, 0.4)
    ]
    assert np.abs(pictures[0] - pictures[1]).max() < most
