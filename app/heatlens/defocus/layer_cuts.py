"""Where the picture is cut into depth layers, by signed circle of confusion.

Near cuts stand at fixed diameters, so that they do not move when the lens or the scene does: a
pixel passes them smoothly as its own circle of confusion changes, and a rack focus does not flicker.
"""

from dataclasses import dataclass
from itertools import pairwise

# Diameters in px, nearest the focus first. -1 parts what is sharp from what is in front of it; then
# each layer holds a factor of 2.5 of blur, within which one object may insulate another.
NEAR_CUTS_PX = (-1.0, -4.0, -10.0, -25.0, -62.5)
FAR_CUT_PART = 1 / 3  # of the farthest circle of confusion
FAR_LEAST_PX = 6.0  # below this the far side needs no cut
NO_CUT_PX = 1.0e30  # farther than any coc; its transition stays finite in float32


@dataclass(frozen=True, slots=True)
class LayerCut:
    """One layer: from its limit towards the camera to its limit away from it, signed pixels."""

    near_px: float
    far_px: float
    is_farthest: bool


def layer_cuts(nearest_px: float, farthest_px: float, layers_max: int) -> list[LayerCut]:
    """Layers for a picture whose coc lies in nearest_px..farthest_px, far to near.

    With fewer layers than the picture asks for, the cuts nearest to the camera go first.
    """
    cuts = [cut for cut in NEAR_CUTS_PX if cut > nearest_px]
    if farthest_px > FAR_LEAST_PX:
        cuts.insert(0, farthest_px * FAR_CUT_PART)
    limits = [NO_CUT_PX, *cuts[: layers_max - 1], -NO_CUT_PX]
    return [LayerCut(near, far, far == NO_CUT_PX) for far, near in pairwise(limits)]
