"""TilePass: layers are computed only in tiles where they are visible, without visible change."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus import tile_pass
from heatlens.render.defocus.layer_passes import CompositePass
from heatlens.render.defocus.layer_plan import layer_plans
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import Slices
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.tile_mask import (
    TileMask,
    VisiblePass,
    VisiblePixels,
    tile_count,
    visibility_words,
)
from heatlens.render.defocus.tile_pass import LayerTiles, TilePass
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.program import groups_for
from heatlens.render.gpu.shader_constants import HIDDEN_DIRECTIONS, TILE
from heatlens.render.gpu.textures import download, new_texture, upload
from support.fragment_lists import packed_lists
from support.layers import ladder_of
from support.plates import lens_blurring, plate_of, room

# Tiles (down, across) of `room_behind_wall`, 480 px wide.
IN_WINDOW, FAR_LEFT, FAR_RIGHT = np.s_[4:8, 14:16], np.s_[:9], np.s_[20:]
NO_WORD = 0xFFFF  # in place of the number of a word of visible pixels (lib/hidden.lib.glsl)


def active_tiles(ctx, coc: np.ndarray) -> list[tuple[np.ndarray, tuple[float, float], int]]:
    """Return the mask (tiles down, across), coc range in px and reduction of each layer."""
    size = coc.shape[::-1]
    picture = UnmixedPicture(
        *(new_texture(ctx, size, channels) for channels in (4, 1)),
        *(new_texture(ctx, size, channels, "f2") for channels in (1, 4, 4)),
    )
    upload(picture.coc, coc.astype(np.float32))
    picture.kind.write(np.zeros(coc.shape, np.float16))
    optics = Optics(None, np.unique(coc).astype(np.float64))
    plans = layer_plans(ladder_of(optics.occupied_px), optics, size)
    tiles_of, pool = TilePass(ctx), Scratch(ctx)
    found = tiles_of.find_content(picture, plans, pool)
    masks = []
    for plan, tiles in zip(plans, tiles_of.find_active(found, plans, optics, pool), strict=True):
        mask, listed = tiles.mask, tiles.tile_list
        across, down = tile_count(plan.size(size))
        words = np.frombuffer(mask.words.read()[: 4 * across * down], np.uint32).reshape(
            down, across
        )
        head = np.frombuffer(listed.words.read()[:28], np.uint32).astype(int)
        assert head[3] == head[6] == np.count_nonzero(words)
        assert head[0] == -(-head[6] // Slices(ctx).count(size))
        assert tuple(head[4:6]) == (plan.reduction, plan.reduction)
        masks.append((words != 0, plan.coc_range_px, plan.reduction))
    return masks


def test_active_tiles_contain_every_pixel_of_layer(ctx, rng):
    coc = rng.choice([-90.0, -30.0, -6.0, 0.0, 2.0, 25.0], (200, 331), p=[0.01] * 5 + [0.95])
    for mask, (low, high), reduction in active_tiles(ctx, coc):
        rows, columns = np.nonzero((coc > low) & (coc < high))
        side = TILE * reduction
        assert len(rows) and mask[rows // side, columns // side].all()


def test_active_tiles_are_the_same_on_gpu_and_software(ctx, rng, monkeypatch):
    coc = np.repeat(np.repeat(rng.choice([-90.0, -6.0, 0.0, 25.0], (13, 21)), 16, 0), 16, 1)
    software_layers = active_tiles(ctx, coc[:200, :331])
    monkeypatch.setattr("heatlens.render.defocus.tile_pass.is_software", lambda _: False)
    gpu_layers = active_tiles(ctx, coc[:200, :331])
    for (mask, *plan), (gpu_mask, *gpu_plan) in zip(software_layers, gpu_layers, strict=True):
        np.testing.assert_array_equal(mask, gpu_mask)
        assert plan == gpu_plan


def test_active_tiles_leave_out_tiles_far_from_layer(ctx):
    coc = np.zeros((320, 640))
    coc[:, :20] = -8.0
    masks = active_tiles(ctx, coc)
    assert len(masks) == 2
    focus_mask, near_mask = (mask for mask, *_ in masks)
    assert near_mask[:, :2].all() and not near_mask[:, 4:].any()
    assert focus_mask[:, 1:].all()


def test_active_tiles_of_blurred_point_are_within_its_reach(ctx):
    """Check a point in the middle: tiles within its coc are active, none beyond twice its coc."""
    coc = np.zeros((512, 512))
    coc[256, 256] = -20.0
    (near,) = (mask for mask, (_, high), _ in active_tiles(ctx, coc) if high < 0)
    assert near[15:18, 15:18].all()
    tiles_between = [np.maximum(np.abs(tiles - 16) - 1, 0) for tiles in np.nonzero(near)]
    assert (TILE * np.hypot(*tiles_between)).max() <= 2 * 20.0


@pytest.mark.parametrize(
    ("coc_px", "quality"),
    [(6.0, Quality.FILM), (25.0, Quality.DRAFT), (70.0, Quality.PREVIEW), (70.0, Quality.FILM)],
)
def test_active_tiles_only_give_same_picture_as_all_tiles(
    ctx, renderer, monkeypatch, coc_px, quality
):
    color, depth = room(400, 230)
    renderer.load(plate_of(color, depth))
    shot = Shot(lens_blurring(coc_px, 400), DefocusSettings(quality=quality))
    active_only = renderer.pixels(shot)
    monkeypatch.setattr("heatlens.render.defocus.tile_pass.SPREAD", 1e4)
    everywhere = renderer.pixels(shot)
    difference = np.abs(np.clip(active_only, 0, 1) - np.clip(everywhere, 0, 1))
    assert difference.max() < 4 / 255 and difference.mean() < 1e-4


def record_active_tiles(monkeypatch) -> list[list[LayerTiles]]:
    """Return a list to which every call of `TilePass.find_active` adds its result."""
    results, find = [], TilePass.find_active

    def find_and_record(*arguments):
        results.append(find(*arguments))
        return results[-1]

    monkeypatch.setattr(TilePass, "find_active", find_and_record)
    return results


def farthest_mask(layers: list[LayerTiles]) -> np.ndarray:
    """Return which tiles (down, across) of the farthest layer are active."""
    across, down = layers[0].mask.tiles
    words = np.frombuffer(layers[0].mask.words.read()[: 4 * across * down], np.uint32)
    return (words != 0).reshape(down, across)


def test_hidden_surface_is_active_only_where_uncovered(ctx, renderer, monkeypatch):
    """Put a known wall behind a near one, which covers all of it but a gap at the right."""
    width, height = 480, 200
    color, depth = room(width, height)
    depth[:], depth[:, 420:] = 1.0, 8.0
    behind = np.full((height, width, 4), 1.0, np.float32)
    behind[..., :3] = room(width, height)[0][::-1]
    one = np.ones(width * height, int)
    lists = packed_lists(
        one, 0 * one == 1, behind.reshape(-1, 4), np.full(one.shape, 8.0, np.float32)
    )
    renderer.load(replace(plate_of(color, depth), fragments=lists))
    recorded, columns, pictures = record_active_tiles(monkeypatch), [], []
    for spread in (1.0, 1e4):  # with 1e4 every tile is within reach
        for module in ("tile_pass", "layer_plan"):
            monkeypatch.setattr(f"heatlens.render.defocus.{module}.SPREAD", spread)
        pictures.append(renderer.pixels(Shot(Lens(50.0, 1.4, 2.0, 36.0), DefocusSettings())))
        columns.append(farthest_mask(recorded[-1]).any(axis=0))
    assert columns[1].all() and not columns[0][: columns[0].size // 2].any()
    difference = np.abs(np.clip(pictures[0], 0, 1) - np.clip(pictures[1], 0, 1))
    assert difference.max() < 4 / 255 and difference.mean() < 1e-4


def room_behind_wall(width: int, height: int, has_window: bool) -> Plate:
    """Return a plate of a near thing at the left and a wall, behind which a room is known.

    The wall continues behind the near thing and may have a window there, hidden by its edge.
    """
    near_m, wall_m, room_m = 1.0, 2.5, 100.0
    y, x = np.mgrid[:height, :width]
    is_near, is_window = x < 260, (x >= 226) & (x < 240) & (y >= 60) & (y < 140) & has_window
    surfaces = np.array([[[0.4, 0.3, 0.2, 1.0], [0.9, 0.2, 0.6, 1.0]]] * (width * height))
    known = np.stack([is_near & ~is_window, np.ones_like(is_near)], axis=-1).reshape(-1, 2)
    depth_m = np.broadcast_to(np.float32([wall_m, room_m]), known.shape)[known]
    counts = known.sum(axis=1)
    lists = packed_lists(counts, counts == 0, surfaces[known].astype(np.float32), depth_m)
    color, depth = room(width, height)[0], np.where(is_near, near_m, wall_m).astype(np.float32)
    return replace(plate_of(color, depth), fragments=lists)


@pytest.mark.parametrize("has_window", [False, True])
def test_room_behind_known_wall_is_active_only_at_window(ctx, renderer, monkeypatch, has_window):
    """Check that the near thing's blurred edge uncovers the room only at a window of the wall."""
    renderer.load(room_behind_wall(480, 200, has_window))
    shot = Shot(Lens(50.0, 0.7, 2.0, 36.0), DefocusSettings())
    recorded, cuts_px = record_active_tiles(monkeypatch), tile_pass._cuts_px
    picture = renderer.pixels(shot)
    room_tiles = farthest_mask(recorded[-1])
    assert room_tiles.any() == has_window
    assert not room_tiles[:, FAR_RIGHT].any() and not room_tiles[:, FAR_LEFT].any()
    assert room_tiles[IN_WINDOW].all() == has_window

    def cuts_without_cover(layers):  # no surface covers a layer in full
        return tuple((first, -1e30, third, last) for first, _, third, last in cuts_px(layers))

    monkeypatch.setattr(tile_pass, "_cuts_px", cuts_without_cover)
    assert np.abs(renderer.pixels(shot) - picture).max() < 1e-3
    assert farthest_mask(recorded[-1]).all()


def test_plate_in_focus_is_unchanged_bit_for_bit(ctx, renderer):
    color, depth = room(131, 77)
    renderer.load(plate_of(color, np.where(depth < 1.0, 2.0, 2.0).astype(np.float32)))
    picture = renderer.pixels(Shot(Lens(50.0, 2.0, 2.0, 36.0), DefocusSettings()))
    assert np.array_equal(picture[..., :3], color)


def visible_pixels(bits: np.ndarray, direction: int, size: tuple[int, int]) -> np.ndarray:
    """Return which pixels (H, W) are visible: rows, columns or diagonals of bits in words."""
    width, height = size
    words = visibility_words(size)
    words_per_line = groups_for(width if direction == 0 else height, 32)
    y, x = np.mgrid[:height, :width]
    line, position = ((y, x), (x, y), (x - y + height, y), (x + y, y))[direction]
    word = bits[sum(words[:direction]) + line * words_per_line + position // 32]
    return (word >> (position % 32) & 1).astype(bool)


def next_words(bits: np.ndarray, per_line: int) -> np.ndarray:
    """Return the next words with any bit and the previous ones, as they are packed."""
    any_bit = bits.reshape(-1, per_line) != 0
    number = np.arange(per_line)
    after = np.where(any_bit, number, NO_WORD)[:, ::-1]
    following = np.minimum.accumulate(after, axis=1)[:, ::-1]
    before = np.maximum.accumulate(np.where(any_bit, number, -1), axis=1)
    none = np.full((len(any_bit), 1), NO_WORD)
    ahead, back = np.hstack([following[:, 1:], none]), np.hstack([none, before[:, :-1]])
    return ahead << 16 | np.where(back < 0, NO_WORD, back)


@pytest.mark.parametrize("size", [(331, 77), (45, 150), (16, 16)])
def test_visible_bits_mark_pixels_in_every_direction(ctx, rng, size):
    active, is_whole = (rng.random(tile_count(size)[::-1]) < share for share in (0.5, 0.4))
    words = ctx.buffer((active * np.where(is_whole, 1, 2)).astype(np.uint32).tobytes())
    mask = TileMask(words, tile_count(size), words, words)
    whole_pixels = np.kron(is_whole, np.ones((TILE, TILE)))[: size[1], : size[0]] != 0
    alpha = np.where((rng.random(size[::-1]) < 0.02) | whole_pixels, 0.5, -1.5)
    color = new_texture(ctx, size, 4)
    upload(color, np.repeat(alpha[..., None], 4, axis=-1).astype(np.float32))
    out = VisiblePixels(*(ctx.buffer(b"\xa5" * VisiblePixels.bytes_for(size)) for _ in "bw"))
    VisiblePass(ctx).mark(color, size, mask, out)
    expected = (np.kron(active, np.ones((TILE, TILE)))[: size[1], : size[0]] != 0) & (alpha > 0)
    bits, found = (np.frombuffer(buffer.read(), np.uint32) for buffer in (out.bits, out.words))
    assert np.unpackbits(bits.view(np.uint8)).sum() == HIDDEN_DIRECTIONS * expected.sum()
    counts = visibility_words(size)
    for direction in range(HIDDEN_DIRECTIONS):
        np.testing.assert_array_equal(visible_pixels(bits, direction, size), expected)
        part = slice(sum(counts[:direction]), sum(counts[: direction + 1]))
        per_line = groups_for(size[0] if direction == 0 else size[1], 32)
        expected_words = next_words(bits[part], per_line)
        np.testing.assert_array_equal(found[part].reshape(-1, per_line), expected_words)


@pytest.mark.parametrize("reduction", [1, 2, 4])
def test_composite_begin_blackens_inactive_tiles_only(ctx, rng, reduction):
    size = 150, 70
    optics = Optics(None, np.array([-3.0, 0.0, 2.0]))
    (plan, *_) = layer_plans(ladder_of(optics.occupied_px), optics, size)
    plan = replace(plan, reduction=reduction)
    across, down = tile_count(plan.size(size))
    active = rng.random((down, across)) < 0.5
    words = ctx.buffer(active.astype(np.uint32).tobytes())
    before = rng.random((size[1], size[0], 4)).astype(np.float32)
    out = new_texture(ctx, size, 4)
    upload(out, before)
    CompositePass(ctx).begin(plan, TileMask(words, (across, down), words, words), out)
    side = TILE * reduction
    is_kept = active.repeat(side, axis=0).repeat(side, axis=1)[: size[1], : size[0], None]
    np.testing.assert_array_equal(download(out), np.where(is_kept, before, (0.0, 0.0, 0.0, 1.0)))
