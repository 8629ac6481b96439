"""Cuts between layers at fixed gaps, for tests that are not about finding the cuts."""

import numpy as np

from heatlens.core.model.shot.settings import LAYERS_MAX
from heatlens.render.defocus.layer_cuts import Cut, LayerCut, layer_cuts

_PLACES_PX = np.array([-62.5, -25.0, -10.0, -4.0])
LADDER_PX = _PLACES_PX[:, None] * (1.1, 0.9)  # the ends of a ladder of gaps


def ladder_of(
    occupied_px: np.ndarray, layers_max: int = LAYERS_MAX, proxy: float = 1.0
) -> list[LayerCut]:
    """Return the layers of a picture with these gaps."""
    return layer_cuts(occupied_px, LADDER_PX * proxy, layers_max, proxy)


def nearer_than(cut: Cut, coc: np.ndarray) -> np.ndarray:
    """Return the share of each CoC on the near side of a cut, as lib/layer.lib.glsl computes it."""
    t = np.clip((coc - cut.at_px + cut.half_width_px) / (2 * cut.half_width_px), 0, 1)
    return 1 - t * t * (3 - 2 * t)


def membership(layer: LayerCut, coc: np.ndarray) -> np.ndarray:
    """Return which share of each coc belongs to `layer`."""
    return np.clip(nearer_than(layer.far, coc) - nearer_than(layer.near, coc), 0, 1)
