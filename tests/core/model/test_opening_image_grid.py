"""Compare the light of an image used as the aperture with sums over its cells and many points."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import LensError
from heatlens.core.model.lens import opening
from heatlens.core.model.lens.aperture import Aperture, shape_uniforms
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField, _parts_past_barrel
from heatlens.core.model.lens.opening import Barrel
from heatlens.core.model.lens.opening_image import (
    BARREL_STEPS,
    IMAGE_SIDE,
    OpeningImage,
    light_in_circle,
)
from support.opening_images import image_of, letter, opening_images

OPEN = image_of(np.ones((8, 8), np.float32), "open")
CENTERS = (np.arange(IMAGE_SIDE) + 0.5) * 2 / IMAGE_SIDE - 1
X, Y = np.meshgrid(CENTERS, -CENTERS)
CELL = (2 / IMAGE_SIDE) ** 2  # square radii


def inside(x, y):
    return np.hypot(x, y) <= 1.0


def test_white_opening_image_equals_round_aperture():
    grid = OPEN.grid()
    assert grid.cells[128, 128] == pytest.approx(1.0, rel=1e-3)
    assert grid.cells[0, 0] == 0.0  # there is no glass in the corner
    assert grid.light(None, 0.0) == pytest.approx(math.pi, rel=1e-6)
    assert grid.variance(0.0) == pytest.approx(0.25, rel=1e-3)
    for rim in (-1.0, 0.5, 1.0):
        assert grid.variance(rim) == pytest.approx(
            opening.variance(opening.Blades(0, 0.0, 0.0), rim), rel=2e-3
        )


@settings(max_examples=20)
@given(opening_images(), st.floats(-1, 1), st.floats(0, 0.9))
def test_grid_light_and_variance_equal_sums_over_cells(image, rim, across):
    grid, barrel = image.grid(), Barrel((across, 0.2), 0.9)
    cells = grid.cells * opening.profile(np.minimum(X**2 + Y**2, 1.0), rim)
    assert grid.cells.sum() * CELL == pytest.approx(math.pi)
    assert grid.light(None, rim) == pytest.approx(cells.sum() * CELL)
    assert grid.variance(rim) == pytest.approx((cells * (X**2 + Y**2)).sum() / cells.sum() / 2)
    past = opening.past_barrel(X, Y, barrel)[0] * IMAGE_SIDE / 2  # in cells
    passed = cells * np.clip(0.5 - past, 0.0, 1.0)
    assert grid.light(barrel, rim) == pytest.approx(passed.sum() * CELL)


def test_light_in_circle_weights_edge_cells_by_area_inside():
    light = light_in_circle(np.ones((IMAGE_SIDE, IMAGE_SIDE), np.float32))
    assert light.mean() * 4 == pytest.approx(math.pi, rel=1e-4)
    assert light[128, 128] == 1.0 and light[0, 0] == 0.0
    assert 0.0 < light[37, 37] < 1.0 and ((light > 0) & (light < 1)).sum() > 800


@pytest.mark.parametrize(("turn", "times"), [(90.0, 1), (180.0, 2), (-90.0, -1), (450.0, 1)])
def test_grid_rotates_image_counterclockwise(turn, times):
    turned, expected = letter().grid(turn).cells, np.rot90(letter().grid().cells, times)
    np.testing.assert_allclose(turned, expected, atol=2e-3)


def test_rotated_grid_keeps_light_and_rotates_centroid():
    straight, turned = letter().grid().cells, letter().grid(30.0).cells
    assert turned.sum() == pytest.approx(straight.sum(), rel=1e-9)  # both have the mean 1

    def middle(cells):
        return np.array([(cells * X).sum(), (cells * Y).sum()]) / cells.sum()

    x, y = middle(straight)
    cosine, sine = math.cos(math.radians(30)), math.sin(math.radians(30))
    expected = (cosine * x - sine * y, sine * x + cosine * y)
    np.testing.assert_allclose(middle(turned), expected, atol=2e-3)


@settings(max_examples=20)
@given(opening_images(), st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(0.0, 0.5))
def test_grid_cover_is_mean_of_cells_over_box(image, x, y, half):
    grid = image.grid()
    half_px = max(half * IMAGE_SIDE / 2, 0.5)
    column, row = (x + 1) * IMAGE_SIDE / 2, (1 - y) * IMAGE_SIDE / 2

    def part(center):  # of each cell that lies in the box
        cells = np.arange(IMAGE_SIDE)
        return np.clip(
            np.minimum(cells + 1, center + half_px) - np.maximum(cells, center - half_px), 0, 1
        )

    expected = part(row) @ grid.cells @ part(column) / (2 * half_px) ** 2
    assert float(grid.cover(x, y, (half, half))) == pytest.approx(expected, abs=1e-6)


def test_grid_cover_accepts_non_square_boxes():
    cells = letter().grid().cells
    tall = letter().grid().cover(-CENTERS[40], 0.0, (0.0, 1.0))
    assert float(tall) == pytest.approx(cells[:, 255 - 40].mean(), abs=1e-9)
    wide = letter().grid().cover(0.0, -CENTERS[100], (1.0, 0.0))
    assert float(wide) == pytest.approx(cells[100].mean(), abs=1e-9)


def test_grid_points_are_distributed_like_cell_light():
    side = 256
    square = (np.stack(np.meshgrid(*[np.arange(side)] * 2), -1).reshape(-1, 2) + 0.5) / side
    for image in (letter(), OPEN):
        points, grid = image.grid().points(square), image.grid()
        assert (grid.cover(*points.T, (0.0, 0.0)) > 0).all()
        column, row = ((points * (1, -1) + 1) * 4).astype(int).T  # in an 8 x 8 raster
        shares = np.bincount(row * 8 + column, minlength=64).reshape(8, 8) / len(points)
        blocks = grid.cells.reshape(8, 32, 8, 32).sum(axis=(1, 3))
        np.testing.assert_allclose(shares, blocks / blocks.sum(), atol=4e-3)


def test_grid_maps_ends_of_unit_square_to_ends_of_opening():
    corners = np.array([[0.0, 0.0], [1.0, 1.0], [0.5, 1.0]])
    points = OPEN.grid().points(corners)
    assert np.isfinite(points).all() and inside(*points.T * 0.99).all()
    assert points[0, 1] > 0.9 and points[2, 1] < -0.9  # from the top down


def test_parts_past_barrel_fall_from_middle_to_corner():
    parts = OPEN.grid().light_shares_past_barrel(1.0, 1.0, 0.0)
    assert parts.shape == (2 * BARREL_STEPS + 1, BARREL_STEPS + 1) == (17, 9)
    assert parts[BARREL_STEPS, 0] == pytest.approx(1.0, abs=0.02)
    for row in (parts[BARREL_STEPS], parts[BARREL_STEPS:, 0]):
        assert all(after < before for before, after in pairwise(row))
    np.testing.assert_allclose(parts, parts[::-1], atol=1e-9)  # a round one is the same up and down
    light = OPEN.grid().light(Barrel((1.0, 0.0), 1.0), 0.0) / math.pi
    assert parts[BARREL_STEPS, -1] == pytest.approx(light, abs=0.02)
    rows = letter().grid().light_shares_past_barrel(0.8, 1.0, 0.0)
    for y, x in ((0, 3), (12, 5), (16, 8)):
        barrel = Barrel((0.8 * x / 8, 0.8 * (y - 8) / 8), 1.0)
        expected = letter().grid().light(barrel, 0.0) / math.pi
        assert rows[y, x] == pytest.approx(expected, abs=0.02)


def test_grid_of_unread_opening_image_names_the_file():
    with pytest.raises(LensError, match=r"heart\.png"):
        OpeningImage("heart.png").grid()


def test_aperture_with_image_uses_light_and_points_of_image():
    aperture = Aperture(aperture_image=letter(), blade_rotation_deg=90.0, squeeze=2.0, blades=5)
    grid = letter().grid(90.0)
    assert aperture.diaphragm.number == 0 and not aperture.is_plain
    np.testing.assert_array_equal(aperture.grid.cells, grid.cells)
    assert aperture.light(0.3) == letter().grid().light(None, 0.3)
    variance = letter().grid().variance(0.0)
    assert aperture.spreads == (math.sqrt(4 * variance),) * 2
    square = np.random.default_rng(1).random((50, 2))
    np.testing.assert_allclose(aperture.points(square, 3.0), grid.points(square) * (1.5, 3.0))
    assert aperture.covers(*aperture.points(square).T).all()
    assert not aperture.covers(0.49, 0.9)
    uniforms = shape_uniforms(aperture)
    assert uniforms["aperture_image_scale"] == grid.scale and uniforms["aperture_blades"] == 0
    assert uniforms["aperture_lights"] == (aperture.light(-0.0), aperture.light(0.0))
    assert DiscShape(aperture).switches == {"SHAPED": True, "COLORED": False, "IMAGED": True}


def test_field_uniforms_hold_image_light_past_barrel():
    field = PictureField.of((60, 40))
    aperture = Aperture(aperture_image=letter(), cat_eye=0.5, stopped_down=1.5, rim=0.5)
    passed = field.uniforms(aperture)["aperture_image_passed"]
    most = 0.5 / 2 * 1.5
    for side, rim in ((0, -0.5), (1, 0.5)):
        expected = letter().grid().light_shares_past_barrel(most, 1.5, rim).ravel()
        np.testing.assert_allclose([pair[side] for pair in passed], expected)
    still = field.uniforms(Aperture(aperture_image=letter()))["aperture_image_passed"]
    assert still == [(1.0, 1.0)] * 153 and "aperture_image_passed" not in field.uniforms(Aperture())


def test_parts_past_barrel_swap_sides_with_reversed_rim():
    bright = Aperture(aperture_image=letter(), cat_eye=0.8, stopped_down=1.2, rim=0.7)
    sides = [np.array(_parts_past_barrel(it)) for it in (bright, replace(bright, rim=-0.7))]
    assert not np.allclose(sides[0][:, 0], sides[0][:, 1])
    np.testing.assert_array_equal(sides[0], sides[1][:, ::-1])
