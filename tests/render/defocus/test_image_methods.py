"""Pictures with an aperture image: every method keeps light and the image's orientation."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.shot.settings import Method
from support.methods_of_plates import ANY_LENS, DISCS, render_with_method
from support.opening_images import letter
from support.plates import coc_plate_of

SIDE = 65
LENS = replace(ANY_LENS, aperture_image=letter())


@pytest.mark.parametrize("method", [Method.DIFFUSION, *DISCS])
def test_aperture_image_keeps_constant_color(renderer, method):
    """The coc passes from one side of the focus to the other; parts of the letter are dark."""
    color = np.full((SIDE, SIDE, 3), (0.2, 0.5, 0.7), np.float32)
    coc = np.tile(np.linspace(-20, 20, SIDE, dtype=np.float32), (SIDE, 1))
    blurred = render_with_method(renderer, coc_plate_of(color, coc), method, LENS)[..., :3]
    inside = blurred if method is not Method.SCATTER else blurred[20:-20, 20:-20]
    np.testing.assert_allclose(inside, color[0, 0] * np.ones_like(inside), rtol=2e-3)


@pytest.mark.parametrize("coc_px", [40.0, -40.0])
@pytest.mark.parametrize("method", [Method.DIFFUSION, *DISCS])
def test_lamp_shows_aperture_image_upright_behind_focus(renderer, method, coc_px):
    color = np.zeros((SIDE, SIDE, 3), np.float32)
    color[SIDE // 2, SIDE // 2] = 500.0
    plate = coc_plate_of(color, np.full((SIDE, SIDE), coc_px, np.float32))
    shown = render_with_method(renderer, plate, method, LENS)[..., 1]
    y, x = np.mgrid[:SIDE, :SIDE] - SIDE // 2
    expected = DiscShape(Aperture(aperture_image=letter())).coverage(x, y, coc_px / 2, 0.5)
    np.testing.assert_allclose(
        shown / shown.sum(), expected / expected.sum(), atol=0.05 * expected.max() / expected.sum()
    )
