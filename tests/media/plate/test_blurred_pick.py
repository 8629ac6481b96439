"""Test what a click means where something near is blurred over the pixel."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.coc_line import surfaces_at
from support.plates import plate_of

WALL_M, TWIGS_M = 3.0, 0.9
LENS = Lens(focal_length_mm=50, f_stop=1.4, focus_distance_m=WALL_M, sensor_width_mm=36)
HOLE, TWIG = (41, 30), (44, 30)


def twigs(gap=3, width=5):
    """Return a plate of twigs before a wall, `width` pixels wide and `gap` apart."""
    depth = np.full((60, 360), WALL_M, np.float32)
    columns = np.arange(360) % (gap + width)
    depth[:, columns >= gap] = TWIGS_M
    return plate_of(np.ones((60, 360, 3), np.float32), depth)


def test_surfaces_at_hole_in_blurred_foreground_gives_foreground_first():
    plate = twigs()
    assert plate.depth_m[HOLE[1], HOLE[0]] == pytest.approx(WALL_M)
    first, other = surfaces_at(plate, LENS, *HOLE)
    assert (first.depth_m, other.depth_m) == pytest.approx((TWIGS_M, WALL_M))
    assert plate.depth_m[first.y, first.x] == pytest.approx(TWIGS_M)
    assert (other.x, other.y) == HOLE


def test_surfaces_at_sharp_pixel_gives_its_own_surface():
    (hole_surface,) = surfaces_at(twigs(), replace(LENS, focus_distance_m=TWIGS_M), *HOLE)
    assert hole_surface.depth_m == pytest.approx(WALL_M)
    (stopped_surface,) = surfaces_at(twigs(), replace(LENS, f_stop=64.0), *HOLE)
    assert stopped_surface.depth_m == pytest.approx(WALL_M)
    (twig_surface,) = surfaces_at(twigs(), LENS, *TWIG)
    assert twig_surface.depth_m == pytest.approx(TWIGS_M)


def test_surfaces_at_blurred_thin_object_gives_background_first():
    surfaces = surfaces_at(twigs(gap=30, width=6), LENS, 170, 30)
    assert [it.depth_m for it in surfaces] == pytest.approx([WALL_M, TWIGS_M])


@given(st.integers(0, 359), st.integers(0, 59), st.floats(0.5, 20), st.floats(0.8, 8))
def test_surfaces_at_any_pixel_exist_in_the_plate(x, y, f_stop, focus_m):
    plate = twigs()
    for it in surfaces_at(plate, replace(LENS, f_stop=f_stop, focus_distance_m=focus_m), x, y):
        around = plate.depth_m[max(it.y - 2, 0) : it.y + 3, max(it.x - 2, 0) : it.x + 3]
        assert np.isclose(around, it.depth_m, rtol=1e-6).any()


def test_surfaces_at_rejects_pixel_outside_plate():
    with pytest.raises(InputError, match="outside"):
        surfaces_at(twigs(), LENS, 900, 3)
