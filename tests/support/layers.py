"""Cuts between layers, for tests that are not about where these are."""

import numpy as np

from heatlens.defocus.layer_cuts import LayerCut, layer_cuts
from heatlens.model.shot.settings import LAYERS_MAX

_PLACES_PX = np.array([-62.5, -25.0, -10.0, -4.0])
LADDER_PX = _PLACES_PX[:, None] * (1.1, 0.9)  # the ends of a ladder of gaps


def ladder_of(
    occupied_px: np.ndarray, layers_max: int = LAYERS_MAX, proxy: float = 1.0
) -> list[LayerCut]:
    """Return the layers of a picture with these gaps."""
    return layer_cuts(occupied_px, LADDER_PX * proxy, layers_max, proxy)
