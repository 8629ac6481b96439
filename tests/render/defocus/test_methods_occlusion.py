"""Occlusion in gather, scatter and pyramid, including their known weaknesses."""

import math

import numpy as np
import pytest

from heatlens.core.model.shot.settings import Method
from support.methods_of_plates import DISCS, render_with_method
from support.plates import Image, coc_plate_of


def two_halves(left_coc: float, right_coc: float) -> Image:
    """Return white on the left and black on the right, each with its coc."""
    color = np.zeros((64, 96, 3), np.float32)
    color[:, :48] = 1.0
    coc = np.full((64, 96), right_coc, np.float32)
    coc[:, :48] = left_coc
    return coc_plate_of(color, coc)


@pytest.mark.parametrize("method", DISCS)
def test_blurred_background_does_not_cover_sharp_foreground(ctx, renderer, method):
    row = render_with_method(renderer, two_halves(20.0, 0.0), method)[32, :, 0]
    assert not row[48:].any()
    np.testing.assert_allclose(row[:48], 1.0, atol=1e-5)  # nor does the sharp black smear into it


@pytest.mark.parametrize("method", DISCS)
def test_a_lamp_before_a_more_blurred_wall_keeps_its_light(ctx, renderer, method):
    color = np.zeros((64, 64, 3), np.float32)
    coc = np.full((64, 64), 20.0, np.float32)
    color[32, 32], coc[32, 32] = 100.0, 6.0
    light = render_with_method(renderer, coc_plate_of(color, coc), method)[..., 0]
    assert light.sum() == pytest.approx(100.0, rel=0.06)


def test_scatter_spills_blurred_foreground_over_sharp_background(ctx, renderer):
    """Compare with the share of the disc beyond the edge, 1 - F(x), F the disc's distribution."""
    row = render_with_method(renderer, two_halves(-20.0, 0.0), Method.SCATTER)[32, :, 0]
    x = (np.arange(48, 58) + 0.5 - 48) / 10.0
    covered = (np.arccos(x) - x * np.sqrt(1 - x**2)) / math.pi
    np.testing.assert_allclose(row[48:58], covered, atol=0.01)
    assert not row[60:].any()


def test_gather_does_not_spill_blurred_foreground(ctx, renderer):
    """Check the known weakness of gathering with a pixel's own disc: no spill of the foreground."""
    assert not render_with_method(renderer, two_halves(-20.0, 0.0), Method.GATHER)[32, 48:, 0].any()


def test_pyramid_mixes_sharp_pixels_into_blurred_neighbors(ctx, renderer):
    """Check the known weakness of pyramid levels: sharp pixels bleed into blurred neighbors."""
    row = render_with_method(renderer, two_halves(20.0, 0.0), Method.PYRAMID)[32, :, 0]
    assert 0.4 < row[47] < 0.9 and not row[48:].any()


def test_scatter_occlusion_does_not_depend_on_pixel_order(ctx, renderer):
    """Mirror the plate: the nearer disc hides the farther one in either order of the pixels."""
    plate = two_halves(-20.0, 30.0)
    row = render_with_method(renderer, plate, Method.SCATTER)[32, :, 0]
    flipped = coc_plate_of(plate.color[:, ::-1, :3].copy(), plate.coc_px[:, ::-1].copy())
    mirrored = render_with_method(renderer, flipped, Method.SCATTER)[32, ::-1, 0]
    np.testing.assert_allclose(row, mirrored, atol=1e-5)
    assert (np.diff(row) <= 1e-6).all()
