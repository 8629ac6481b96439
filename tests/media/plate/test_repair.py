"""Test filling of invalid pixels: they take neighboring values and do not spread."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.plate.depth.repair import repair_color, repair_depth


def constant_color(value=0.5, shape=(7, 9, 4)):
    return np.full(shape, value, np.float32)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_repair_color_fills_bad_pixel_from_neighbors(bad):
    color = constant_color()
    color[3, 4, 1] = bad
    assert repair_color(color, "a.exr") == 1
    np.testing.assert_array_equal(color, constant_color())


def test_repair_color_ignores_single_bright_neighbor():
    color = constant_color()
    color[3, 5] = 500.0
    color[3, 4] = np.nan
    repair_color(color, "a.exr")
    assert color[3, 4].tolist() == [0.5] * 4


def test_repair_color_inside_lamp_stays_bright():
    color = constant_color()
    color[2:5, 3:6] = 500.0
    color[3, 4] = np.inf
    repair_color(color, "a.exr")
    assert color[3, 4].tolist() == [500.0] * 4


def test_repair_color_fills_hole_from_edge_to_middle():
    color = constant_color(shape=(31, 31, 4))
    color[:, 20:] = 0.25
    color[5:25, 5:25] = np.nan
    assert repair_color(color, "a.exr") == 400
    assert color[15, 6].tolist() == [0.5] * 4  # beside the good ones on the left
    assert color[15, 14].tolist() == [0.5] * 4  # nine away
    assert set(np.unique(color)) == {np.float32(0.25), np.float32(0.5)}


def test_repair_color_keeps_bright_image_whose_sum_overflows():
    color = constant_color(3e38)
    assert repair_color(color, "a.exr") == 0
    np.testing.assert_array_equal(color, constant_color(3e38))


def test_repair_color_rejects_more_than_half_bad_pixels():
    color = constant_color()
    color[:4] = np.nan
    with pytest.raises(InputError, match="36 of 63 pixels"):
        repair_color(color, "a.exr: colour")


@given(st.sets(st.tuples(st.integers(0, 6), st.integers(0, 8)), max_size=31))
def test_repair_color_keeps_good_pixels_and_makes_all_finite(bad):
    ramp = np.arange(7 * 9 * 4, dtype=np.float32).reshape(7, 9, 4) - 100  # with negative light
    color = ramp.copy()
    for row, column in bad:
        color[row, column, 2] = np.nan
    assert repair_color(color, "a.exr") == len(bad)
    good = np.ones((7, 9), bool)
    for pixel in bad:
        good[pixel] = False
    np.testing.assert_array_equal(color[good], ramp[good])
    assert np.isfinite(color).all()
    assert color.min() >= min(ramp[good].min(), 0) and color.max() <= max(ramp[good].max(), 0)


@given(st.sets(st.tuples(st.integers(0, 6), st.integers(0, 8)), min_size=1, max_size=31))
def test_repair_depth_copies_from_nearest_ring(bad):
    depth = np.arange(63, dtype=np.float32).reshape(7, 9)
    mask = np.zeros((7, 9), bool)
    for pixel in bad:
        mask[pixel] = True
    filled = np.where(mask, np.nan, depth).astype(np.float32)
    assert repair_depth(filled, mask, "a.exr") == len(bad)
    good = np.argwhere(~mask)
    for row, column in bad:
        source = np.array(divmod(int(filled[row, column]), 9))
        assert not mask[tuple(source)]
        rings = np.abs(good - (row, column)).max(axis=1)
        assert np.abs(source - (row, column)).max() == rings.min()
    np.testing.assert_array_equal(filled[~mask], depth[~mask])


@pytest.mark.parametrize("good", range(1, 9))
def test_repair_color_takes_lower_median_of_good_neighbors(good):
    """With an even count, a lamp that fills half of the neighborhood is not taken."""
    color = constant_color(9.0)
    color[2:5, 3:6] = np.nan
    around = [(y, x) for y in (2, 3, 4) for x in (3, 4, 5) if (y, x) != (3, 4)]
    for value, at in enumerate(around[:good]):
        color[at] = float(value)
    repair_color(color, "a.exr")
    assert color[3, 4].tolist() == [float((good - 1) // 2)] * 4
