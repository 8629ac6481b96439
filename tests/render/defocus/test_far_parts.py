"""Parts of the lens behind the focus: one plane, what hides what, and the opening's shape."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.settings import LAYERS_MAX, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.layer_cuts import FAR_FROM_PX, layer_cuts, with_far_cut
from heatlens.render.defocus.quality import unused_behind_notes
from heatlens.render.defocus.view_tiles import list_tiles, tiles_near
from heatlens.render.gpu.shader_constants import FAR_BLOCK, TILE
from support.lamps import HALF_ROUNDING
from support.layers import ladder_of, membership
from support.opening_images import image_of
from support.plates import FAR_M, FOCUS_M, Image, lens_blurring, plate_of, room

HEIGHT, WIDTH = 48, 192
EDGE = 96  # the first column beside the card
NEARER_M = FOCUS_M / 0.85  # 0.3 of the blur at FAR_M
COC_PX = 30.0


def render_plate(
    renderer,
    plate: Plate,
    coc_px: float = COC_PX,
    opening: OpeningImage | None = None,
    **settings: object,
) -> Image:
    renderer.load(plate)
    lens = replace(lens_blurring(coc_px, WIDTH), aperture_image=opening)
    shot = Shot(lens, DefocusSettings(**settings))
    return renderer.pixels(shot)[..., :3].copy()


def wall(row: Image, depth_m: float) -> Plate:
    color = np.broadcast_to(row[None, :, None], (HEIGHT, WIDTH, 3))
    return plate_of(
        np.ascontiguousarray(color, np.float32), np.full((HEIGHT, WIDTH), depth_m, np.float32)
    )


def hidden_stripe() -> Image:
    """Return a row of a dark wall with a stripe of light, which the card hides from the middle."""
    row = np.full(WIDTH, 0.1, np.float32)
    row[EDGE - 8 : EDGE] = 0.9
    return row


def card_before_wall(row: Image, card_m: float = NEARER_M) -> Plate:
    """Return a card on the left, little behind the focus, and the known wall far behind it."""
    front = np.where(np.arange(WIDTH) < EDGE, np.float32(0.4), row)
    seen = wall(front, card_m)
    depth_m = np.full((HEIGHT, WIDTH), FAR_M, np.float32)
    depth_m[:, :EDGE] = card_m
    return with_behind(plate_of(seen.color[..., :3], depth_m), [wall(row, FAR_M)])


def expected_row(row: Image, sides: tuple[int, ...] = (-1, 1)) -> Image:
    """Return the exact row through halves of a round lens: the weighted mean over lens columns."""
    u = (np.arange(401) + 0.5) / 401 * 2 - 1
    x = np.arange(WIDTH)[:, None] + 0.5
    on_card = x - 0.3 * COC_PX * u / 2
    on_wall = np.clip(np.floor(x - COC_PX * u / 2), 0, WIDTH - 1).astype(int)
    seen = np.where(on_card < EDGE, 0.4, row[on_wall])
    return np.asarray(
        np.average(seen, axis=1, weights=np.sqrt(1 - u**2) * np.isin(np.sign(u), sides)), np.float32
    )


@pytest.mark.parametrize("parts", [0, 2, 8, 38])
def test_defocus_settings_reject_unsupported_number_of_parts(parts):
    with pytest.raises(InputError, match=f"got {parts}"):
        DefocusSettings(parts=parts)


@pytest.mark.parametrize("layers", [2, 4, LAYERS_MAX])
@pytest.mark.parametrize(
    "ends", [(-40.0, 3.2), (0.0, 5.0), (-90.0, 40.0), (6.0, 90.0), (24.0, 30.0)]
)
def test_with_far_cut_starts_new_layers_behind_focus(layers, ends):
    found = with_far_cut(ladder_of(np.linspace(*ends, 512), layers), 1.0)
    assert len(found) <= max(LAYERS_MAX, layers + 1)
    for farther, nearer in pairwise(found):
        assert farther.near == nearer.far and nearer.near.at_px < nearer.far.at_px
    assert FAR_FROM_PX in [layer.near.at_px for layer in found]


@given(
    st.lists(st.floats(-300, 300), max_size=30),
    st.floats(2.001 * FAR_FROM_PX, 300),
    st.lists(st.floats(-300, -1.6), max_size=8).map(sorted),
    st.integers(1, LAYERS_MAX),
)
@example([-90.0, -50.0, -30.0, -20.0, -5.0, 0.0], 4.0, [-80.0, -40.0, -25.0, -10.0], LAYERS_MAX)
def test_with_far_cut_adds_cut_to_any_layers(cocs, farthest, gaps, layers):
    """The cut is added even if one layer holds the far field and the near side uses the others."""
    coc = np.sort(np.array([*cocs, farthest]))
    ends = np.array(gaps)[:, None] + np.array([-0.05, 0.05])
    found = with_far_cut(layer_cuts(coc, ends, layers), 1.0)
    assert len(found) <= LAYERS_MAX
    assert FAR_FROM_PX in [layer.near.at_px for layer in found]
    assert found[0].is_farthest and found[-1].near.at_px <= min(coc[0], FAR_FROM_PX)
    share = sum(membership(layer, coc) for layer in found)
    np.testing.assert_allclose(share, 1.0, atol=0.05)  # cuts at 1.3 and 1.5 px overlap a little


def test_parts_show_surface_that_only_one_side_of_lens_sees(ctx, renderer):
    row = hidden_stripe()
    plate, expected = card_before_wall(row), expected_row(row)
    near_edge = np.s_[EDGE - 20 : EDGE + 20]
    errors = {
        parts: np.abs(
            render_plate(renderer, plate, parts=parts)[HEIGHT // 2, near_edge, 0]
            - expected[near_edge]
        )
        for parts in (1, 7, 19)
    }
    assert errors[7].mean() < 0.5 * errors[1].mean()
    assert errors[19].mean() < 0.35 * errors[1].mean()


def half_opening(side: int) -> OpeningImage:
    """Return the right half of a round opening for 1, the left half for -1."""
    y, x = (np.mgrid[:64, :64] + 0.5) / 32 - 1
    return image_of(((side * x > 0) & (np.hypot(x, y) < 1)).astype(np.float32), f"half {side}")


@pytest.mark.parametrize("side", [-1, 1])
def test_half_opening_sees_past_edge_of_card_from_its_own_side(ctx, renderer, side):
    row = hidden_stripe()
    plate, expected = card_before_wall(row), expected_row(row, (side,))
    near_edge = np.s_[EDGE - 20 : EDGE + 20]
    errors = {
        parts: np.abs(
            render_plate(renderer, plate, opening=half_opening(side), parts=parts)[
                HEIGHT // 2, near_edge, 0
            ]
            - expected[near_edge]
        ).mean()
        for parts in (1, 7, 19)
    }
    assert errors[7] < 0.5 * errors[1] and errors[19] < 0.35 * errors[1], errors


@pytest.mark.parametrize("parts", [7, 19])
def test_parts_keep_constant_color(ctx, renderer, parts):
    _, depth_m = room()
    tint = np.array([0.25, 0.75, 1.0], np.float32)
    light = np.broadcast_to(tint, (*depth_m.shape, 3))
    behind = [plate_of(light, np.full(depth_m.shape, z, np.float32)) for z in (3.0, 9.0)]
    picture = render_plate(
        renderer, with_behind(plate_of(light, depth_m), behind), 20.0, parts=parts
    )
    assert np.abs(picture / tint - 1).max() < 4 * HALF_ROUNDING


def test_parts_change_nothing_without_overlapping_surfaces_behind_focus(ctx, renderer):
    """Plates of one plane, in focus, or without known surfaces behind render as without parts."""
    row = hidden_stripe()
    flat = plate_of(*room())
    for plate in (wall(row, FAR_M), wall(row, FOCUS_M), flat):
        assert np.array_equal(render_plate(renderer, plate, parts=7), render_plate(renderer, plate))
    in_focus = with_behind(wall(row, FOCUS_M), [wall(1 - row, FAR_M)])
    sharp = render_plate(renderer, in_focus, parts=7)
    assert np.array_equal(sharp[HEIGHT // 2, :, 0], row)


def test_quality_final_uses_19_parts_unless_parts_are_set(ctx, renderer):
    final, plate = Quality.FINAL, card_before_wall(hidden_stripe())
    most, few = (render_plate(renderer, plate, parts=parts) for parts in (19, 7))
    assert np.array_equal(render_plate(renderer, plate, quality=final), most)
    assert np.array_equal(render_plate(renderer, plate, quality=final, parts=7), few)
    assert not np.array_equal(most, few)
    flat = plate_of(*room())
    assert np.array_equal(render_plate(renderer, flat, quality=final), render_plate(renderer, flat))
    assert unused_behind_notes(flat, DefocusSettings(quality=final)) == ()


def test_surfaces_of_similar_blur_need_more_parts(ctx, renderer):
    """With a card of 0.8 of the wall's blur 7 parts change nothing and 19 parts do."""
    plate = card_before_wall(hidden_stripe(), FOCUS_M / 0.6)
    whole, few, many = (render_plate(renderer, plate, parts=parts) for parts in (1, 7, 19))
    assert np.array_equal(few, whole)
    assert np.abs(many - whole).max() > 0.01


def test_parts_give_identical_picture_twice(ctx, renderer):
    """The order in which surfaces arrive at a pixel does not matter."""
    plate = card_before_wall(hidden_stripe())
    first = render_plate(renderer, plate, parts=7)
    assert np.array_equal(first, render_plate(renderer, plate, parts=7))


def test_parts_keep_card_as_bright_as_wall_invisible(ctx, renderer):
    """A card as bright as the wall behind it cannot be seen, whichever surface hides the other."""
    plate = card_before_wall(np.full(WIDTH, 0.4, np.float32))
    np.testing.assert_allclose(render_plate(renderer, plate, parts=7), 0.4, rtol=4 * HALF_ROUNDING)


def test_parts_keep_width_of_card(ctx, renderer):
    """The light of a wall that a card covers is that of the exact picture, to 0.04 pixels."""
    wall_row = np.full(WIDTH, 0.9, np.float32)
    near_edge = np.s_[EDGE - 24 : EDGE + 24]
    picture = render_plate(renderer, card_before_wall(wall_row), parts=19)[HEIGHT // 2, :, 0]
    light = (picture - expected_row(wall_row))[near_edge].sum()
    assert abs(light) / (0.9 - 0.4) < 0.04


def test_back_of_thin_card_does_not_change_picture(ctx, renderer):
    """A dark surface just behind the card, which covers it, adds nothing to the picture."""
    row = hidden_stripe()
    front = card_before_wall(row)
    on_card = np.arange(WIDTH) < EDGE
    visible_color = wall(np.where(on_card, np.float32(0.4), row), FAR_M).color[..., :3].copy()
    depth_m = np.where(on_card, NEARER_M, FAR_M)
    back_m = np.where(on_card, 1.01 * NEARER_M, FAR_M)
    whole, back = (np.tile(z.astype(np.float32), (HEIGHT, 1)) for z in (depth_m, back_m))
    dark = wall(np.where(on_card, np.float32(0.0), row), FAR_M).color[..., :3].copy()
    plate = with_behind(plate_of(visible_color, whole), [plate_of(dark, back), wall(row, FAR_M)])
    with_back, expected = (render_plate(renderer, each, parts=7) for each in (plate, front))
    np.testing.assert_allclose(with_back, expected, rtol=4 * HALF_ROUNDING)


def test_unused_behind_notes_name_parts_without_effect():
    color, depth = np.ones((4, 4, 3), np.float32), np.ones((4, 4), np.float32)
    alone = plate_of(color, depth)
    known = with_behind(alone, [plate_of(color, 2 * depth)])
    assert known.fragments is not None
    for plate, parts in ((alone, 1), (alone, 7), (known, 7)):
        assert unused_behind_notes(plate, DefocusSettings(parts=parts)) == ()
    (note,) = unused_behind_notes(replace(known, has_alpha=True), DefocusSettings(parts=19))
    assert note.startswith("19 parts") and "alpha" in note


def test_tiles_near_blocks_are_those_within_margin():
    """Compared with the distance of every block to every tile."""
    rng = np.random.default_rng(2)
    side = TILE // FAR_BLOCK
    for height, width, margin_px in ((9, 14, 0.0), (17, 30, 8.0), (30, 21, 33.0)):
        blocks = rng.random((height, width)) < 0.01
        blocks[height // 2, 3] = True
        rows, columns = np.nonzero(blocks)
        near = tiles_near(blocks, margin_px)
        assert near.shape == (-(-height // side), -(-width // side))
        for row, column in np.ndindex(*near.shape):
            off = [
                np.maximum(first * side - at, at - (first + 1) * side + 1)
                for first, at in ((row, rows), (column, columns))
            ]
            is_near = np.maximum(*off) <= -(-margin_px // FAR_BLOCK)
            assert near[row, column] == is_near.any()


def test_views_of_near_tiles_give_same_light_as_whole_views(ctx, renderer, monkeypatch):
    """Without the choice of tiles, every view is a view of the whole picture."""
    plate = card_before_wall(hidden_stripe())
    near = render_plate(renderer, plate, parts=7)

    def whole(blocks: NDArray[np.bool_], margin_px: float) -> NDArray[np.bool_]:
        return np.ones_like(tiles_near(blocks, margin_px))

    monkeypatch.setattr("heatlens.render.defocus.overlap_zones.tiles_near", whole)
    np.testing.assert_allclose(render_plate(renderer, plate, parts=7), near, atol=1e-3)


def test_surfaces_of_unlisted_tiles_do_not_change_picture(ctx, renderer, monkeypatch):
    """Moving the surfaces of all tiles adds none to the views."""
    plate = card_before_wall(hidden_stripe())
    listed = render_plate(renderer, plate, parts=7)
    monkeypatch.setattr(
        "heatlens.render.defocus.overlap_zones.list_tiles",
        lambda needed, moved_px, name, scratch: list_tiles(needed, 1e6, name, scratch),
    )
    assert np.array_equal(render_plate(renderer, plate, parts=7), listed)
