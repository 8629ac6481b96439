"""Lens and plate as the blur knows them."""

import numpy as np

from heatlens.defocus.optics import Optics
from heatlens.model.aperture import Aperture
from heatlens.model.coc import CocLine
from heatlens.model.disc_shape import DiscShape

SQUEEZED = DiscShape(Aperture(squeeze=2.0), 1.5)


def test_proxy_scales_everything_but_the_shape() -> None:
    optics = Optics(CocLine(12.0, -30.0), np.array([-20.0, 12.0]), SQUEEZED).scaled(0.25)
    assert optics.line == CocLine(3.0, -7.5)
    assert (optics.nearest_px, optics.farthest_px, optics.at_infinity_px) == (-5.0, 3.0, 3.0)
    assert optics.disc == SQUEEZED
