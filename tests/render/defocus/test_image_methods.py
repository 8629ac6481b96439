"""An image as the opening in whole pictures: what methods must keep, and which way it stands."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.shot.settings import Method
from support.methods_of_plates import ANY_LENS, DISCS, through
from support.opening_images import letter
from support.plates import coc_plate_of

SIDE = 65
LENS = replace(ANY_LENS, aperture_image=letter())


@pytest.mark.parametrize("method", [Method.DIFFUSION, *DISCS])
def test_one_colour_stays_that_colour(renderer, method):
    """On both sides of the focus and in it, though the letter is dark in places."""
    color = np.full((SIDE, SIDE, 3), (0.2, 0.5, 0.7), np.float32)
    coc = np.tile(np.linspace(-20, 20, SIDE, dtype=np.float32), (SIDE, 1))
    blurred = through(renderer, coc_plate_of(color, coc), method, LENS)[..., :3]
    inside = blurred if method is not Method.SCATTER else blurred[20:-20, 20:-20]
    np.testing.assert_allclose(inside, color[0, 0] * np.ones_like(inside), rtol=2e-3)


@pytest.mark.parametrize("coc_px", [40.0, -40.0])
@pytest.mark.parametrize("method", [Method.DIFFUSION, *DISCS])
def test_a_lamp_shows_it_upright_behind_the_focus(renderer, method, coc_px):
    color = np.zeros((SIDE, SIDE, 3), np.float32)
    color[SIDE // 2, SIDE // 2] = 500.0
    plate = coc_plate_of(color, np.full((SIDE, SIDE), coc_px, np.float32))
    shown = through(renderer, plate, method, LENS)[..., 1]
    y, x = np.mgrid[:SIDE, :SIDE] - SIDE // 2
    expected = DiscShape(Aperture(aperture_image=letter())).coverage(x, y, coc_px / 2, 0.5)
    np.testing.assert_allclose(
        shown / shown.sum(), expected / expected.sum(), atol=0.05 * expected.max() / expected.sum()
    )
