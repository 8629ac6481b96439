"""Lens and plate as the blur knows them."""

import numpy as np

from heatlens.defocus.optics import Optics
from heatlens.model.coc import CocLine


def test_proxy_scales_everything_but_the_shape() -> None:
    optics = Optics(CocLine(12.0, -30.0), np.array([-20.0, 12.0]), (0.5, 1.0)).scaled(0.25)
    assert optics.line == CocLine(3.0, -7.5)
    assert (optics.nearest_px, optics.farthest_px, optics.at_infinity_px) == (-5.0, 3.0, 3.0)
    assert optics.axis_scales == (0.5, 1.0)
