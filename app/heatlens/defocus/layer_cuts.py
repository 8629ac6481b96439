"""Choose where the picture is cut into depth layers, by signed circle of confusion.

Near cuts are at fixed diameters, so that they do not move when the lens or the scene moves: a pixel
passes them smoothly as its own circle of confusion changes. A cut is used as soon as one pixel is
within its transition, so that it appears and disappears without a jump during a rack focus.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

# Diameters in px, nearest the focus first. -1 separates sharp pixels from those in front; each
# further layer spans a factor of 2.5 in blur, within which one object can insulate another.
NEAR_CUTS_PX = (-1.0, -4.0, -10.0, -25.0, -62.5)
# With fewer layers the cuts are wider apart. Leaving out those nearest to the camera instead would
# put a thin foreground object, such as a wire, into one layer with what it hides.
FEWER_NEAR_CUTS_PX: dict[int, tuple[float, ...]] = {
    0: (),
    1: NEAR_CUTS_PX[:1],
    2: (-1.0, -12.0),
    3: (-1.0, -5.0, -25.0),
    4: NEAR_CUTS_PX[:4],
}
FAR_CUT_PART = 1 / 3  # position of the far cut, as a share of the farthest coc ...
FAR_CUT_LEAST_PX = 2.0  # ... but at least this

# Half width of a cut's transition, as a share of its coc: wide enough to be smooth during a rack
# focus, narrow enough that few objects are in two layers.
NEAR_SOFTNESS = 0.1
FAR_SOFTNESS = 0.2
_BEYOND_PX = 1.0e30  # larger than any coc


@dataclass(frozen=True, slots=True)
class Cut:
    """A limit between two layers: signed coc and half width of the transition, in pixels."""

    at_px: float
    half_width_px: float


NEARER_THAN_ALL = Cut(-_BEYOND_PX, 0.1 * _BEYOND_PX)
FARTHER_THAN_ALL = Cut(_BEYOND_PX, 0.1 * _BEYOND_PX)
_BEYOND = (NEARER_THAN_ALL, FARTHER_THAN_ALL)


@dataclass(frozen=True, slots=True)
class LayerCut:
    """One layer: its limit towards the camera and its limit away from it."""

    near: Cut
    far: Cut
    is_before_focus: bool = False  # the whole layer is in front of the focus

    @property
    def is_farthest(self) -> bool:
        """True for the last layer, which has nothing behind it."""
        return self.far is FARTHER_THAN_ALL

    @property
    def is_nearest(self) -> bool:
        """True for the first layer, which nothing hides."""
        return self.near is NEARER_THAN_ALL


def layer_cuts(
    occupied_px: npt.NDArray[np.float64], layers_max: int, proxy: float = 1.0
) -> list[LayerCut]:
    """Return the layers for the signed coc in a picture (ascending), far to near.

    Empty layers are left out. A picture scaled by `proxy` is cut at the same depths as the whole
    picture. With few layers the near cuts are fewer and wider apart.
    """
    whole = _cuts_of_whole(occupied_px / proxy, layers_max)
    return whole if proxy == 1.0 else [_scaled(layer, proxy) for layer in whole]


def _scaled(layer: LayerCut, proxy: float) -> LayerCut:
    near, far = (
        cut if cut in _BEYOND else Cut(cut.at_px * proxy, cut.half_width_px * proxy)
        for cut in (layer.near, layer.far)
    )
    return replace(layer, near=near, far=far)


def _cuts_of_whole(occupied_px: npt.NDArray[np.float64], layers_max: int) -> list[LayerCut]:
    nearest_px, farthest_px = float(occupied_px[0]), float(occupied_px[-1])
    far_px = max(farthest_px * FAR_CUT_PART, FAR_CUT_LEAST_PX)
    far = Cut(far_px, far_px * FAR_SOFTNESS)
    cuts = [far] if far.at_px - far.half_width_px < farthest_px else []
    cuts = cuts[: layers_max - 1]
    near_px = FEWER_NEAR_CUTS_PX.get(layers_max - 1 - len(cuts), NEAR_CUTS_PX)
    near = [Cut(at_px, -at_px * NEAR_SOFTNESS) for at_px in near_px]
    cuts += [cut for cut in near if cut.at_px + cut.half_width_px > nearest_px]
    limits = [FARTHER_THAN_ALL, *cuts, NEARER_THAN_ALL]
    layers = [
        LayerCut(near=closer, far=farther, is_before_focus=farther.at_px <= NEAR_CUTS_PX[0])
        for farther, closer in pairwise(limits)
    ]
    layers = [layer for layer in layers if _holds_any(layer, occupied_px)]
    return [replace(layers[0], far=FARTHER_THAN_ALL), *layers[1:]]


def _holds_any(layer: LayerCut, occupied_px: npt.NDArray[np.float64]) -> bool:
    """Return True if any coc lies in the layer or its transitions."""
    low = layer.near.at_px - layer.near.half_width_px
    high = layer.far.at_px + layer.far.half_width_px
    first = int(np.searchsorted(occupied_px, low))
    return first < len(occupied_px) and bool(occupied_px[first] <= high)
