"""A picture in steps is the picture; what is looked at is left alone while the next comes about."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer, drained
from heatlens.render.gpu.textures import download
from support.plates import plate_of, room

SHOT = Shot(Lens(50.0, 1.4, 1.0, 36.0), DefocusSettings(quality=Quality.DRAFT))


@pytest.fixture
def loaded(ctx, renderer: FrameRenderer) -> FrameRenderer:
    renderer.load(plate_of(*room()))
    return renderer


def test_steps_make_the_picture_of_render(loaded):
    whole = loaded.pixels(SHOT)
    assert np.array_equal(download(drained(loaded.steps(SHOT, slot=1))), whole)


def test_slots_do_not_disturb_each_other(loaded):
    nearer = replace(SHOT, lens=replace(SHOT.lens, focus_distance_m=0.8))
    shown = drained(loaded.steps(SHOT, slot=0))
    before = download(shown)
    between = loaded.steps(nearer, slot=1)
    for _ in range(5):
        next(between)
    assert np.array_equal(download(shown), before)
    drained(between)
    assert np.array_equal(download(shown), before)


def test_steps_left_early_leave_nothing_behind(loaded):
    expected = loaded.pixels(SHOT)
    left = loaded.steps(replace(SHOT, lens=replace(SHOT.lens, f_stop=2.8)))
    for _ in range(7):
        next(left)
    left.close()
    assert np.array_equal(loaded.pixels(SHOT), expected)


def test_the_stopwatch_counts_a_pass_once_whatever_its_steps(loaded):
    loaded.stopwatch.times.clear()
    loaded.stopwatch.on = True
    try:
        expected = loaded.pixels(SHOT)
    finally:
        loaded.stopwatch.on = False
    times = loaded.stopwatch.times
    assert times["coc"].runs == 1
    assert times["blur"].runs == times["layer split"].runs > 1
    assert np.array_equal(loaded.pixels(SHOT), expected)


def test_a_smaller_picture_is_of_the_plate_that_is_loaded(loaded):
    """The plate at proxy size is kept from picture to picture, but not from plate to plate."""
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
