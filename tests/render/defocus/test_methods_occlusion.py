"""What hides what in the field's other methods, with the weaknesses they are known for."""

import math

import numpy as np
import pytest

from heatlens.core.model.shot.settings import Method
from support.methods_of_plates import DISCS, through
from support.plates import Image, coc_plate_of


def two_halves(left_coc: float, right_coc: float) -> Image:
    """Return white on the left and black on the right, each with its coc."""
    color = np.zeros((64, 96, 3), np.float32)
    color[:, :48] = 1.0
    coc = np.full((64, 96), right_coc, np.float32)
    coc[:, :48] = left_coc
    return coc_plate_of(color, coc)


@pytest.mark.parametrize("method", DISCS)
def test_a_blurred_background_does_not_cover_what_is_sharp_before_it(ctx, renderer, method):
    row = through(renderer, two_halves(20.0, 0.0), method)[32, :, 0]
    assert not row[48:].any()
    np.testing.assert_allclose(row[:48], 1.0, atol=1e-5)  # nor does the sharp black smear into it


def test_a_scattered_foreground_spills_over_what_is_sharp_behind_it(ctx, renderer):
    """By the part of the disc that lies over the edge, 1 - F(x) for a disc's distribution F."""
    row = through(renderer, two_halves(-20.0, 0.0), Method.SCATTER)[32, :, 0]
    x = (np.arange(48, 58) + 0.5 - 48) / 10.0
    covered = (np.arccos(x) - x * np.sqrt(1 - x**2)) / math.pi
    np.testing.assert_allclose(row[48:58], covered, atol=0.01)
    assert not row[60:].any()


def test_a_gathered_foreground_ends_where_it_is_sharp_beyond(ctx, renderer):
    """The known weakness of gathering with a pixel's own disc: no spill."""
    assert not through(renderer, two_halves(-20.0, 0.0), Method.GATHER)[32, 48:, 0].any()


def test_a_pyramid_knows_no_depth(ctx, renderer):
    """The known weakness of levels: what is sharp flows into the blurred beside it."""
    row = through(renderer, two_halves(20.0, 0.0), Method.PYRAMID)[32, :, 0]
    assert 0.4 < row[47] < 0.9 and not row[48:].any()


def test_scattered_discs_hide_those_behind_in_any_order_of_the_picture(ctx, renderer):
    """Three depths, mirrored: who comes first in memory does not matter, who is nearer does."""
    plate = two_halves(-20.0, 30.0)
    row = through(renderer, plate, Method.SCATTER)[32, :, 0]
    flipped = coc_plate_of(plate.color[:, ::-1, :3].copy(), plate.coc_px[:, ::-1].copy())
    mirrored = through(renderer, flipped, Method.SCATTER)[32, ::-1, 0]
    np.testing.assert_allclose(row, mirrored, atol=1e-5)
    assert (np.diff(row) <= 1e-6).all()
