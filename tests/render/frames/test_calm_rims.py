"""Rims of things that pass from layer to layer do not flash in a focus pull."""

from dataclasses import replace

import numpy as np

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus import layer_cuts
from support.plates import FOCUS_M, lens_blurring, plate_of
from support.unrest import display_of, flash

HEIGHT, WIDTH, FINE = 64, 96, 4
WALL_M = 6.0
DARK, BRIGHT = 0.05, 0.8


def test_stems_do_not_darken_while_they_leave_the_focus(ctx, renderer):
    """Pull focus past stems before a bright wall, so that another layer takes them.

    While both layers had the mixed pixels at their rims, these were covered twice: a block of 4 px
    flashed by 10.2 levels.
    """
    y, x = (np.mgrid[: HEIGHT * FINE, : WIDTH * FINE] + 0.5) / FINE
    is_stem = (x + 0.3 * y) % 9 < 2.5
    cover = is_stem.reshape(HEIGHT, FINE, WIDTH, FINE).mean((1, 3))[..., None]
    color = (BRIGHT + (DARK - BRIGHT) * cover).repeat(3, -1).astype(np.float32)
    depth_m = np.where(is_stem[FINE // 2 :: FINE, FINE // 2 :: FINE], FOCUS_M, WALL_M)
    renderer.load(plate_of(color, depth_m))
    lens = lens_blurring(12.0, WIDTH)
    distances_m = 1.0 / np.linspace(1 / 2.02, 1 / 2.2, 6)
    lenses = [replace(lens, focus_distance_m=float(at)) for at in distances_m]
    frames = [renderer.pixels(Shot(it, DefocusSettings()))[..., :3].copy() for it in lenses]
    assert flash(frames) < 5.0


def test_card_that_passes_a_cut_is_between_its_pictures_in_both_layers(ctx, renderer, monkeypatch):
    """Move the cut behind the focus through a blurred card: its rims stay between both ends.

    While both layers had the card, its blurred rims were covered twice: .12 beyond both.
    """
    y, x = np.mgrid[:48, :64]
    color = np.where(y - 24.4 - 0.1 * (x - 32) > 0, BRIGHT, DARK)
    depth_m = np.where(color == BRIGHT, 3.0, 4.0)
    renderer.load(plate_of(color[..., None].repeat(3, -1).astype(np.float32), depth_m))
    lens = replace(lens_blurring(9.0, 64), focus_distance_m=2.0)
    pictures = []
    for share in np.linspace(0.5, 0.83, 7):
        monkeypatch.setattr(layer_cuts, "FAR_CUT_SHARE", share)
        pictures.append(display_of(renderer.pixels(Shot(lens, DefocusSettings()))[..., :3]))
    first, *between, last = pictures
    low, high = np.minimum(first, last), np.maximum(first, last)
    assert np.maximum(low - between, between - high).max() < 0.01
