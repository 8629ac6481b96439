"""The guess of what a surface behind the focus hides, for renders in sub-apertures."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.far_guess import GUESSED_FROM_PX, cuts_behind
from heatlens.render.defocus.optics import Optics
from support.lamps import HALF_ROUNDING
from support.plates import FAR_M, FOCUS_M, Image, lens_blurring, plate_of

HEIGHT, WIDTH = 48, 192
EDGE = 96  # the first column beside the card
CARD_M = FOCUS_M / 0.85  # 0.3 of the blur at FAR_M
COC_PX = 60.0  # of the wall; 18 of the card


def wall(light: float) -> Plate:
    return plate_of(
        np.full((HEIGHT, WIDTH, 3), light, np.float32), np.full((HEIGHT, WIDTH), FAR_M, np.float32)
    )


def card_before_wall(light: float, card: float = 0.4, card_m: float = CARD_M) -> Plate:
    """Return a card on the left, behind the focus, and a wall of even light far behind it."""
    on_card = np.broadcast_to(np.arange(WIDTH) < EDGE, (HEIGHT, WIDTH))
    color = np.where(on_card[..., None], np.float32(card), np.float32(light))
    depth_m = np.where(on_card, np.float32(card_m), np.float32(FAR_M))
    return plate_of(np.repeat(color, 3, -1), depth_m)


def render_plate(renderer, plate: Plate, coc_px: float = COC_PX, **settings: object) -> Image:
    renderer.load(plate)
    shot = Shot(lens_blurring(coc_px, WIDTH), DefocusSettings(**settings))
    return renderer.pixels(shot)[..., :3].copy()


def test_far_guess_fades_in_while_aperture_opens(ctx, renderer):
    """The blur of the card grows past the least blur for a guess; the picture changes gradually."""
    plate = card_before_wall(0.9)
    cocs_px = np.linspace(0.95, 1.25, 31) * COC_PX * GUESSED_FROM_PX / 18
    changes = np.array([_change_of_columns(renderer, plate, float(coc_px)) for coc_px in cocs_px])
    assert changes[0].max() == 0.0
    assert changes[-1].max() > 0.02
    assert np.abs(np.diff(changes, axis=0)).max() < 0.4 * changes[-1].max()


def _change_of_columns(renderer, plate: Plate, coc_px: float) -> Image:
    """Return the mean change of each column's light by the guess."""
    with_guess, without = (render_plate(renderer, plate, coc_px, parts=parts) for parts in (7, 1))
    return np.abs(with_guess - without).mean(axis=(0, 2))


@pytest.mark.parametrize("light", [0.05, 0.9])
def test_far_guess_of_wall_behind_card_matches_known_wall(ctx, renderer, light):
    plate = card_before_wall(light)
    guessed = render_plate(renderer, plate, parts=7)
    known = render_plate(renderer, with_behind(plate, [wall(light)]), parts=7)
    assert np.abs(guessed - known).max() < 0.01 * abs(light - 0.4)
    assert np.abs(guessed - render_plate(renderer, plate)).max() > 0.05 * abs(light - 0.4)


def test_far_guess_keeps_card_as_bright_as_wall_invisible(ctx, renderer):
    picture = render_plate(renderer, card_before_wall(0.4), parts=7)
    np.testing.assert_allclose(picture, 0.4, rtol=4 * HALF_ROUNDING)


def test_quality_final_uses_seven_parts_for_a_guess(ctx, renderer):
    plate = card_before_wall(0.9)
    final = render_plate(renderer, plate, quality=Quality.FINAL)
    assert np.array_equal(final, render_plate(renderer, plate, parts=7))
    assert not np.array_equal(final, render_plate(renderer, plate, parts=19))


def test_far_guess_is_skipped_where_layers_are_better(ctx, renderer):
    """A card near the focus, a hair, a picture with alpha, and a lens that blurs little."""
    card = card_before_wall(0.9)
    near_focus = card_before_wall(0.9, card_m=FOCUS_M / 0.96)
    is_hair = np.tile(np.arange(WIDTH) // 2 == EDGE // 2, (HEIGHT, 1))
    depth_m = np.where(is_hair, FOCUS_M / 0.88, FAR_M).astype(np.float32)
    hair = plate_of(card.color[..., :3], depth_m)
    for plate in (near_focus, hair, replace(card, has_alpha=True)):
        assert np.array_equal(render_plate(renderer, plate, parts=7), render_plate(renderer, plate))
    least_coc_px = COC_PX * GUESSED_FROM_PX / 18  # of the wall, from which on the card is guessed
    layers, guess = (
        render_plate(renderer, card, 0.9 * least_coc_px, parts=parts) for parts in (1, 7)
    )
    assert np.array_equal(guess, layers)


def test_cuts_behind_are_the_gaps_behind_the_focus():
    gaps = np.array([(-20.0, -18.0), (0.5, 1.5), (10.0, 12.0), (30.0, 31.0), (60.0, 64.0)])
    optics = Optics(None, np.linspace(-30.0, 50.0, 9), gaps_px=gaps)
    assert cuts_behind(optics, 1.5) == [11.0, 30.5]
