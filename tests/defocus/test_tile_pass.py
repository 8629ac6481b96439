"""Layers are worked on in the tiles where they show; that leaves the picture as it is."""

import numpy as np
import pytest

from heatlens.defocus.fragment_pass import Fragments
from heatlens.defocus.layer_plan import layer_plans
from heatlens.defocus.optics import Optics
from heatlens.defocus.pixel_list import Slices
from heatlens.defocus.scratch import Scratch
from heatlens.defocus.tile_mask import tile_count
from heatlens.defocus.tile_pass import TilePass
from heatlens.gpu.shader_constants import TILE
from heatlens.gpu.textures import new_texture, upload
from heatlens.model.lens import Lens
from heatlens.model.settings import DefocusSettings, Quality
from heatlens.model.shot import Shot
from support.layers import ladder_of
from support.plates import lens_blurring, plate_of, room


def active_tiles(ctx, coc: np.ndarray) -> list[tuple[np.ndarray, tuple[float, float], int]]:
    """Return for each layer its mask (tiles down, across), its ends in px, its reduction."""
    size = coc.shape[::-1]
    picture = Fragments(
        *(new_texture(ctx, size, channels) for channels in (4, 1)),
        *(new_texture(ctx, size, channels, "f2") for channels in (1, 4, 4)),
    )
    upload(picture.coc, coc.astype(np.float32))
    picture.kind.write(np.zeros(coc.shape, np.float16))
    optics = Optics(None, np.unique(coc).astype(np.float64))
    plans = layer_plans(ladder_of(optics.occupied_px), optics, size)
    tile_pass, pool = TilePass(ctx), Scratch(ctx)
    found = tile_pass.look_through(picture, plans, pool)
    masks = []
    for number, plan in enumerate(plans):
        mask, listed = tile_pass.find(found, plans, number, optics, pool)
        across, down = tile_count(plan.size(size))
        words = np.frombuffer(mask.words.read(4 * across * down), np.uint32).reshape(down, across)
        head = np.frombuffer(listed.words.read(28), np.uint32).astype(int)
        assert head[3] == head[6] == np.count_nonzero(words)
        assert head[0] == -(-head[6] // Slices(ctx).count(size))
        assert tuple(head[4:6]) == (plan.reduction, plan.reduction)
        masks.append((words != 0, plan.ends_px, plan.reduction))
    return masks


def test_every_pixel_of_a_layer_lies_in_an_active_tile(ctx, rng):
    coc = rng.choice([-90.0, -30.0, -6.0, 0.0, 2.0, 25.0], (200, 331), p=[0.01] * 5 + [0.95])
    for mask, (low, high), reduction in active_tiles(ctx, coc):
        rows, columns = np.nonzero((coc > low) & (coc < high))
        side = TILE * reduction
        assert len(rows) and mask[rows // side, columns // side].all()


def test_what_is_far_from_a_layer_is_left_out(ctx):
    coc = np.zeros((320, 640))
    coc[:, :20] = -8.0
    masks = active_tiles(ctx, coc)
    assert len(masks) == 2
    focus, near = (mask for mask, *_ in masks)
    assert near[:, :2].all() and not near[:, 4:].any()
    assert focus[:, 1:].all()


def test_the_tiles_of_a_blur_are_those_that_it_reaches(ctx):
    """A point in the middle: the tiles within its coc, and none beyond twice that."""
    coc = np.zeros((512, 512))
    coc[256, 256] = -20.0
    (near,) = (mask for mask, (_, high), _ in active_tiles(ctx, coc) if high < 0)
    y, x = np.nonzero(near)
    away_px = TILE * np.hypot(np.maximum(np.abs(y - 16) - 1, 0), np.maximum(np.abs(x - 16) - 1, 0))
    assert near[15:18, 15:18].all() and away_px.max() <= 2 * 20.0


@pytest.mark.parametrize("quality", Quality)
@pytest.mark.parametrize("coc_px", [6.0, 25.0, 70.0])
def test_leaving_tiles_out_changes_nothing_to_see(ctx, renderer, monkeypatch, quality, coc_px):
    color, depth = room(400, 230)
    renderer.load(plate_of(color, depth))
    shot = Shot(lens_blurring(coc_px, 400), DefocusSettings(quality=quality))
    where_it_shows = renderer.pixels(shot)
    monkeypatch.setattr("heatlens.defocus.tile_pass.SPREAD", 1e4)
    everywhere = renderer.pixels(shot)
    off = np.abs(np.clip(where_it_shows, 0, 1) - np.clip(everywhere, 0, 1))
    assert off.max() < 4 / 255 and off.mean() < 1e-4


def test_a_scene_without_blur_keeps_every_bit(ctx, renderer):
    color, depth = room(131, 77)
    renderer.load(plate_of(color, np.where(depth < 1.0, 2.0, 2.0).astype(np.float32)))
    picture = renderer.pixels(Shot(Lens(50.0, 2.0, 2.0, 36.0), DefocusSettings()))
    assert np.array_equal(picture[..., :3], color)
