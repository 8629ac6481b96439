"""Parts of the lens around wide surfaces in front of the focus: what they hide and uncover."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.media.plate.plate import Plate
from support.lamps import HALF_ROUNDING
from support.opening_images import image_of
from support.plates import FAR_M, FOCUS_M, Image, lens_blurring, plate_of, room

HEIGHT, WIDTH = 48, 192
EDGE = 96  # the first column beside the card
CARD_M, STRIPE_M = FOCUS_M / 1.5, FOCUS_M / 1.25  # a coc of -COC_PX, and of half of it
COC_PX = 30.0
CARD, STRIPE, WALL = 0.4, 0.9, 0.1  # light of each surface
STRIPE_COLUMNS = np.s_[EDGE - 12 : EDGE]
BESIDE_EDGE = np.s_[EDGE - 20 : EDGE + 20]


def render_plate(
    renderer, plate: Plate, opening: OpeningImage | None = None, **settings: object
) -> Image:
    renderer.load(plate)
    lens = replace(lens_blurring(COC_PX, WIDTH), aperture_image=opening)
    return renderer.pixels(Shot(lens, DefocusSettings(**settings)))[..., :3].copy()


def rows_plate(color_row: Image, depth_row_m: Image) -> Plate:
    """Return a plate whose rows are all the same."""
    color = np.broadcast_to(color_row[None, :, None], (HEIGHT, WIDTH, 3))
    depth_m = np.broadcast_to(depth_row_m[None], (HEIGHT, WIDTH))
    return plate_of(
        np.ascontiguousarray(color, np.float32), np.ascontiguousarray(depth_m, np.float32)
    )


def card_before_stripe(card_columns: slice = np.s_[:EDGE], beside_edge: float = WALL) -> Plate:
    """Return a near card that hides a stripe, before a wall in focus; all of them are known.

    `beside_edge` is the light of the first column of pixels beside the card.
    """
    on_card, on_stripe = np.zeros(WIDTH, bool), np.zeros(WIDTH, bool)
    on_card[card_columns], on_stripe[STRIPE_COLUMNS] = True, True
    second = np.where(on_stripe, STRIPE, WALL), np.where(on_stripe, STRIPE_M, FOCUS_M)
    first = np.where(on_card, CARD, second[0]), np.where(on_card, CARD_M, second[1])
    first[0][EDGE] = beside_edge if not on_card[EDGE] else CARD
    whole_wall = np.full(WIDTH, WALL), np.full(WIDTH, FOCUS_M)
    return with_behind(rows_plate(*first), [rows_plate(*second), rows_plate(*whole_wall)])


def expected_row(card_columns: slice = np.s_[:EDGE], sides: tuple[int, ...] = (-1, 1)) -> Image:
    """Return the exact row: the mean over columns of a round lens, each with its own view."""
    u = (np.arange(401) + 0.5) / 401 * 2 - 1
    x = np.arange(WIDTH)[:, None] + 0.5

    def is_seen(columns: slice, coc_px: float) -> Image:
        at = np.clip(np.floor(x - coc_px * u / 2), 0, WIDTH - 1).astype(int)
        return np.isin(at, np.arange(WIDTH)[columns])

    card, stripe = is_seen(card_columns, -COC_PX), is_seen(STRIPE_COLUMNS, -COC_PX / 2)
    light = np.where(card, CARD, np.where(stripe, STRIPE, WALL))
    weights = np.sqrt(1 - u**2) * np.isin(np.sign(u), sides)
    return np.asarray(np.average(light, axis=1, weights=weights), np.float32)


def mean_error(picture: Image, expected: Image) -> float:
    row = picture[HEIGHT // 2, :, 0]
    return float(np.abs(row - expected)[BESIDE_EDGE].mean())


def test_parts_show_what_part_of_the_lens_sees_behind_near_card(ctx, renderer):
    plate, expected = card_before_stripe(), expected_row()
    errors = {
        parts: mean_error(render_plate(renderer, plate, parts=parts), expected)
        for parts in (1, 7, 19)
    }
    assert errors[7] < 0.5 * errors[1] and errors[19] < 0.35 * errors[1], errors


@pytest.mark.parametrize("side", [-1, 1])
def test_half_opening_sees_behind_near_card_from_its_own_side(ctx, renderer, side):
    y, x = (np.mgrid[:64, :64] + 0.5) / 32 - 1
    is_open = (side * x > 0) & (np.hypot(x, y) < 1)
    opening = image_of(is_open.astype(np.float32), f"half {side}")
    plate, expected = card_before_stripe(), expected_row(sides=(side,))
    errors = {
        parts: mean_error(render_plate(renderer, plate, opening, parts=parts), expected)
        for parts in (1, 19)
    }
    assert errors[19] < 0.5 * errors[1], errors


def test_parts_before_focus_keep_constant_color(ctx, renderer):
    _, depth_m = room()
    tint = np.array([0.25, 0.75, 1.0], np.float32)
    light = np.broadcast_to(tint, (*depth_m.shape, 3))
    depth_m = np.where(np.arange(depth_m.shape[1]) < 60, np.float32(CARD_M), np.float32(FOCUS_M))
    depth_m = np.broadcast_to(depth_m, light.shape[:2]).copy()
    behind = [plate_of(light, np.full(depth_m.shape, z, np.float32)) for z in (STRIPE_M, FOCUS_M)]
    picture = render_plate(renderer, with_behind(plate_of(light, depth_m), behind), parts=7)
    assert np.abs(picture / tint - 1).max() < 4 * HALF_ROUNDING


def test_parts_leave_pixels_in_focus_beyond_reach_of_near_card_unchanged(ctx, renderer):
    plate = card_before_stripe()
    layers, parts = (render_plate(renderer, plate, parts=count) for count in (1, 19))
    assert not np.array_equal(layers, parts)
    beyond = np.s_[:, EDGE + 40 :]
    assert np.array_equal(layers[beyond], parts[beyond])


def test_thin_near_bar_stays_in_layers(ctx, renderer):
    """A bar of a tenth of its coc would show as a pattern of separate bars."""
    plate = card_before_stripe(np.s_[EDGE - 2 : EDGE + 1])
    layers, parts = (render_plate(renderer, plate, parts=count) for count in (1, 19))
    away_from_stripe = np.s_[: EDGE - 40]
    assert np.array_equal(layers[:, away_from_stripe], parts[:, away_from_stripe])


def test_parts_before_focus_give_identical_picture_twice(ctx, renderer):
    first, second = (render_plate(renderer, card_before_stripe(), parts=7) for _ in range(2))
    assert np.array_equal(first, second)


def test_near_card_alone_renders_as_without_parts(ctx, renderer):
    """Nothing is known behind it, so that no part of the lens has a view of its own."""
    on_card = np.arange(WIDTH) < EDGE
    plate = rows_plate(np.where(on_card, CARD, WALL), np.where(on_card, CARD_M, FOCUS_M))
    film, final = (
        render_plate(renderer, plate, quality=it) for it in (Quality.FILM, Quality.FINAL)
    )
    assert np.array_equal(film, final)


def test_picture_changes_little_while_near_card_leaves_focus(ctx, renderer):
    """Zones grow from nothing: no step of the focus changes the picture suddenly."""
    plate = card_before_stripe()
    renderer.load(plate)
    lens = lens_blurring(COC_PX, WIDTH)
    focuses_m = np.linspace(CARD_M, 1.15 * CARD_M, 40)
    rows = []
    for parts in (1, 19):
        shots = (
            Shot(replace(lens, focus_distance_m=z), DefocusSettings(parts=parts)) for z in focuses_m
        )
        rows.append(np.array([renderer.pixels(shot)[HEIGHT // 2, :, 0].copy() for shot in shots]))
    layers, views = (np.abs(np.diff(row, axis=0)).max() for row in rows)
    assert views < 1.5 * layers, (views, layers)


def test_dark_sky_behind_known_wall_does_not_show_where_wall_is_unknown(ctx, renderer):
    """Three near surfaces hide the wall from some lists; the lists beside them have the sky."""
    column = np.arange(WIDTH)
    on_card, is_unknown = column < EDGE, (column >= EDGE - 10) & (column < EDGE)
    light, dark = np.full(WIDTH, 0.9), np.zeros(WIDTH)
    first = light, np.where(on_card, CARD_M, FOCUS_M)
    second_m = np.where(is_unknown, STRIPE_M, np.where(on_card, FOCUS_M, FAR_M))
    second = np.where(on_card, light, dark), second_m
    third = np.where(is_unknown, light, dark), np.where(is_unknown, 1.1 * STRIPE_M, FAR_M)
    plate = with_behind(rows_plate(*first), [rows_plate(*second), rows_plate(*third)])
    layers, parts = (render_plate(renderer, plate, parts=count) for count in (1, 19))
    assert layers.min() > 0.89  # the wall hides the sky
    assert parts.min() > 0.89


def test_mixed_pixels_of_near_edge_leave_no_line_on_wall_in_focus(ctx, renderer):
    """A pixel at the edge has half of the card's light and the depth of the wall."""
    plates = card_before_stripe(), card_before_stripe(beside_edge=(CARD + WALL) / 2)
    sharp, soft = (render_plate(renderer, it, parts=19)[HEIGHT // 2, :, 0] for it in plates)
    line = np.abs(np.diff(soft - sharp))[EDGE - 4 : EDGE + 5]
    assert line.max() < 0.1 * (CARD - WALL) / 2, line


def test_known_wall_shows_between_near_cards_far_behind_them(ctx, renderer):
    """Two cards meet in the picture, a lens sees between them; what it sees there is known."""
    column, cards_end = np.arange(WIDTH), EDGE + 20
    on_cards, wall = column < cards_end, np.where(column < cards_end - 4, STRIPE, WALL)
    depth_m = np.where(column < EDGE, CARD_M, np.where(on_cards, STRIPE_M, FOCUS_M))
    first = rows_plate(np.where(on_cards, CARD, wall), depth_m)
    plate = with_behind(first, [rows_plate(wall, np.full(WIDTH, FOCUS_M))])
    row = render_plate(renderer, plate, quality=Quality.FILM)[HEIGHT // 2, :, 0]
    u = (np.arange(401) + 0.5) / 401 * 2 - 1
    from_edge = column[:, None] + 0.5 - EDGE
    is_wall = (from_edge >= COC_PX * u / 2) & (from_edge < COC_PX * u / 4)
    wall_share = np.average(is_wall, axis=1, weights=np.sqrt(1 - u**2))
    on_near_card = np.s_[EDGE - 16 : EDGE]
    error = row - (CARD + (STRIPE - CARD) * wall_share)
    assert np.abs(error)[on_near_card].mean() < 0.04  # 0.08 with a guess in place of the wall
