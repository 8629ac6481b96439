"""FrameRenderer.steps: same picture as `pixels`, independent slots, early close, stopwatch."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer, run_all_steps
from heatlens.render.gpu.textures import download
from support.plates import plate_of, room

SHOT = Shot(Lens(50.0, 1.4, 1.0, 36.0), DefocusSettings(quality=Quality.DRAFT))


@pytest.fixture
def loaded(ctx, renderer: FrameRenderer) -> FrameRenderer:
    renderer.load(plate_of(*room()))
    return renderer


def test_steps_give_picture_of_pixels(loaded):
    whole = loaded.pixels(SHOT)
    assert np.array_equal(download(run_all_steps(loaded.steps(SHOT, slot=1))), whole)


def test_steps_in_one_slot_keep_picture_of_other_slot(loaded):
    nearer = replace(SHOT, lens=replace(SHOT.lens, focus_distance_m=0.8))
    texture = run_all_steps(loaded.steps(SHOT, slot=0))
    before = download(texture)
    nearer_steps = loaded.steps(nearer, slot=1)
    for _ in range(5):
        next(nearer_steps)
    assert np.array_equal(download(texture), before)
    run_all_steps(nearer_steps)
    assert np.array_equal(download(texture), before)


def test_steps_closed_early_do_not_change_next_picture(loaded):
    expected = loaded.pixels(SHOT)
    unfinished_steps = loaded.steps(replace(SHOT, lens=replace(SHOT.lens, f_stop=2.8)))
    for _ in range(7):
        next(unfinished_steps)
    unfinished_steps.close()
    assert np.array_equal(loaded.pixels(SHOT), expected)


def test_stopwatch_counts_each_pass_run_once(loaded):
    loaded.stopwatch.times.clear()
    loaded.stopwatch.is_on = True
    try:
        expected = loaded.pixels(SHOT)
    finally:
        loaded.stopwatch.is_on = False
    times = loaded.stopwatch.times
    assert times["coc"].runs == 1
    assert times["blur"].runs == times["layer split"].runs > 1
    assert np.array_equal(loaded.pixels(SHOT), expected)


def test_proxy_picture_follows_loaded_plate(loaded):
    """Check that the cached plate at proxy size is not reused for another loaded plate."""
    half = replace(SHOT, defocus=replace(SHOT.defocus, proxy=0.5))
    first = loaded.pixels(half)
    color, depth = room()
    loaded.load(plate_of(color[:, ::-1].copy(), depth[:, ::-1].copy()))
    mirrored = loaded.pixels(half)
    assert not np.array_equal(mirrored, first)
    loaded.load(plate_of(color, depth))
    third = loaded.pixels(replace(half, defocus=replace(half.defocus, proxy=1 / 3)))
    assert third.shape != first.shape
    assert np.array_equal(loaded.pixels(half), first)
