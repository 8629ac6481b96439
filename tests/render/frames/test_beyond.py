"""A plate with a border from other frames (`beyond`) is blurred like one with overscan, cropped."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.neighbours.found import with_neighbours
from support.cards import view_of_cards
from support.plates import lens_blurring, plate_of

SIZE, BORDER = (40, 56), 8  # height, width
LENS = lens_blurring(12.0, SIZE[1])


@pytest.fixture(scope="module")
def overscan():
    """A plate with overscan: noise at several distances, and lamps outside the frame."""
    rng = np.random.default_rng(3)
    sides = SIZE[0] + 2 * BORDER, SIZE[1] + 2 * BORDER
    color = rng.uniform(0, 1, (*sides, 3)).astype(np.float32)
    color[:BORDER, ::5] = 30.0
    depth = np.where(np.arange(sides[1]) % 20 < 8, 1.2, 5.0) * np.ones((sides[0], 1))
    display_window = Box(BORDER, BORDER, BORDER + SIZE[1], BORDER + SIZE[0])
    return replace(plate_of(color, depth), display_window=display_window)


def crop_to_frame(wide):
    """Return the plate cropped to its display window, with its overscan as `beyond`."""
    inner = np.s_[BORDER:-BORDER, BORDER:-BORDER]
    cropped = plate_of(wide.color[inner], wide.depth_m[inner])
    shown = wide.display_window
    return replace(cropped, data_window=shown, display_window=shown, with_border=wide)


@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.GATHER])
def test_plate_with_border_equals_overscan_render_cropped(renderer, overscan, method):
    shot = Shot(LENS, DefocusSettings(method=method))
    renderer.load(overscan)
    whole = renderer.pixels(shot)[BORDER:-BORDER, BORDER:-BORDER]
    renderer.load(crop_to_frame(overscan))
    picture = renderer.pixels(shot)
    assert np.array_equal(picture, whole)
    renderer.load(replace(crop_to_frame(overscan), with_border=None))
    assert np.abs(renderer.pixels(shot) - whole).max() > 0.1
    assert renderer.loaded.wide_pinhole is None


@pytest.mark.parametrize("proxy", [1.0, 0.5])
def test_hidden_surfaces_are_used_with_and_without_border(renderer, proxy):
    """Check that a preview leaves out the border, but not the hidden surfaces."""
    view, *others = (view_of_cards(0.2 * k, frame=k) for k in (0, -1, 1))
    plate = with_neighbours(view, others, BORDER).plate
    shot = Shot(replace(LENS, focus_distance_m=10.0), DefocusSettings(proxy=proxy))
    pictures = []
    for loaded in (
        plate,
        replace(plate, with_border=None),
        replace(plate, with_border=None, fragments=None),
    ):
        renderer.load(loaded)
        pictures.append(renderer.pixels(shot))
    with_all, behind_alone, without = pictures
    assert np.array_equal(with_all, behind_alone) == (proxy < 1)
    assert np.abs(behind_alone - without).max() > 0.002
