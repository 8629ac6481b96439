"""Plan the work on each layer: its size, and how far its blur reaches.

A strongly blurred layer has no detail to lose: it is processed at 1/2, 1/4 or 1/8 size, as long as
its circle of confusion there stays large enough for the shape of the disc. While it is only just
large enough, both sizes are processed and mixed, so that a layer changes its size without a jump.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from heatlens.render.defocus.layer_cuts import FARTHER_THAN_ALL, Cut, LayerCut
from heatlens.render.defocus.optics import Optics

REDUCTIONS = (8, 4, 2)
LEAST_REDUCED_PX = 7.0  # smallest coc of a reduced layer, in its own pixels
ALONE_FROM_PX = 8.0  # coc from which a reduced layer is not mixed with the one at twice its size
LEAST_REDUCED_SIDE = 64  # smallest shorter side of a reduced layer; smaller ones gain little
SPREAD = 1.0  # reach of a kernel, relative to the coc; beyond it, less than a thousandth is left
_END_BY = 0.61  # where in a cut, from its middle, a pixel is visible by END (lib/layer.lib.glsl)
_ENTERED_SHARE = 0.03  # share of the picture from which a surface that enters a layer is wide
SHAPES_WITHIN_PX = 6.0  # coc beyond a layer in focus over which its shapes begin to be followed
MARGIN_PX = 8.0  # neighborhood used by the fill, and by enlarging a reduced layer


@dataclass(frozen=True, slots=True)
class LayerPlan:
    """The plan of one layer.

    reduction     size of a pixel of the layer, in pixels of the picture
    widest_px     largest |coc| in the layer, in pixels of the picture
    uncovered_px  how far behind a silhouette hidden content can show, in pixels of the picture
    share         how much of the layer has this size, 0..1; the rest has twice this size
    is_passed     a surface is passing through the layer's near cut, at any size of the layer
    shape_share   how far the layer shows shapes of things in focus before something farther, 0..1
    """

    cut: LayerCut
    reduction: int
    widest_px: float
    uncovered_px: float
    share: float = 1.0
    shape_share: float = 0.0
    is_passed: bool = False

    @property
    def is_entered(self) -> bool:
        """True if a surface is passing into a layer of full size: its pixels are known in part."""
        return self.reduction == 1 and self.is_passed

    @property
    def sized_plans(self) -> "list[LayerPlan]":
        """The plan of each size at which the layer is processed, the larger one first."""
        if self.share == 1.0:
            return [self]
        return [replace(self, reduction=self.reduction // 2, share=1.0), self]

    @property
    def coc_range_px(self) -> tuple[float, float]:
        """The range of signed coc that belongs to the layer, with its transitions."""
        near, far = self.cut.near, self.cut.far
        return near.at_px - near.half_width_px, far.at_px + far.half_width_px

    @property
    def follows_lines(self) -> bool:
        """True if the guess of what wide things hide of the layer follows rows and columns."""
        return self.reduction == 1 and not self.cut.is_before_focus

    @property
    def shows_pixels(self) -> bool:
        """True if the layer begins before the focus and ends behind it: single pixels are seen."""
        return self.reduction == 1 and self.cut.near.at_px < 0.0 < self.cut.far.at_px

    @property
    def is_in_focus(self) -> bool:
        """True if the layer may contain pixels in focus."""
        low_px, high_px = self.coc_range_px
        return low_px < 1.0 and high_px > -1.0

    def size(self, picture: tuple[int, int]) -> tuple[int, int]:
        """Return width and height of the layer, given those of the picture, rounded up."""
        return -(-picture[0] // self.reduction), -(-picture[1] // self.reduction)

    @property
    def resampled_px_2(self) -> float:
        """The blur caused by reducing and enlarging the layer, as a squared disc diameter.

        In pixels of the layer. Variances add, a disc's is d^2 / 16; a box of `reduction` pixels has
        1/12 - 1/(12 reduction^2) more than one pixel, and linear interpolation 1/6 on the mean.
        """
        if self.reduction == 1:
            return 0.0
        return 16.0 * (1 / 12 - 1 / (12 * self.reduction**2) + 1 / 6)


def layer_plans(cuts: list[LayerCut], optics: Optics, size: tuple[int, int]) -> list[LayerPlan]:
    """Return a plan for each layer of a picture of `size` (width, height), in the same order."""
    return [_plan_layer(cut, optics, min(size)) for cut in cuts]


# Layers are reduced from a coc of 8 px on: mean FLIP .0457, against .0456 at full size and .0469
# when reduced from 5 px on. Both sizes are mixed between 7 and 8 px, because the change from one
# size to the next was the largest jump in slow focus pulls: the unrest of one shot fell from 3.05
# to 2.44.
def _plan_layer(cut: LayerCut, optics: Optics, side_px: int) -> LayerPlan:
    """Plan the layer of `cut` in a picture whose shorter side is `side_px`."""
    coc = optics.occupied_px
    # a plan of the cut alone, only for its range of coc
    cut_alone = LayerPlan(cut, reduction=1, widest_px=0.0, uncovered_px=0.0)
    low, high = (np.searchsorted(coc, end) for end in cut_alone.coc_range_px)
    layer_coc = coc[max(low - 1, 0) : high + 1]  # a limit may lie within a bin
    widest_px = float(np.max(np.abs(layer_coc), initial=0.0))
    narrowest_px = _least_px(cut, float(layer_coc[-1])) * min(optics.disc.spreads)
    allowed_reductions = [k for k in REDUCTIONS if side_px >= k * LEAST_REDUCED_SIDE]
    reduction = next((k for k in allowed_reductions if narrowest_px >= k * LEAST_REDUCED_PX), 1)
    share = np.clip(
        (narrowest_px / reduction - LEAST_REDUCED_PX) / (ALONE_FROM_PX - LEAST_REDUCED_PX), 0.0, 1.0
    )
    # the blur of what hides the layer: the nearest surface is blurred most
    nearer_px = 0.0 if cut.is_nearest else max(-optics.nearest_px, 0.0)
    uncovered_px = max(optics.disc.half_extents) * (nearer_px + widest_px) / 2 + MARGIN_PX
    return LayerPlan(
        cut,
        reduction,
        widest_px,
        uncovered_px,
        share=1.0 if reduction == 1 else float(share),
        shape_share=_shape_share(cut_alone, float(coc[-1])),
        is_passed=_is_passed(cut.near, optics),
    )


def _is_passed(near: Cut, optics: Optics) -> bool:
    """Return True if a wide surface behind the focus is passing into a layer that begins at `near`.

    Its pixels become ends of the guess from the middle of the cut on (lib/layer.lib.glsl).
    """
    end_px = near.at_px + _END_BY * near.half_width_px
    return near.at_px > 0.0 and optics.share_between(near.at_px, end_px) > _ENTERED_SHARE


def _shape_share(plan: LayerPlan, farthest_px: float) -> float:
    """Return how far a layer shows shapes in focus before something farther, 0..1.

    `farthest_px` is the largest signed coc in the picture. The share is 0 where the farther layer
    begins, and grows from there, because that layer ends when a focus pull comes to the farthest.
    """
    if not plan.is_in_focus or plan.cut.is_before_focus or plan.cut.is_farthest:
        return 0.0
    begin_px = plan.cut.far.at_px - plan.cut.far.half_width_px
    share = min(max((farthest_px - begin_px) / SHAPES_WITHIN_PX, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


def _least_px(cut: LayerCut, farthest_px: float) -> float:
    """Return the smallest |coc| in pixels that a layer can hold, by its limits.

    Limits move little during a focus pull. `farthest_px` is the largest signed coc in the layer; it
    is used if the layer is in front of the focus and nothing is behind it.
    """
    if not cut.is_before_focus:
        return cut.near.at_px - cut.near.half_width_px
    if cut.far is FARTHER_THAN_ALL:
        return -farthest_px
    return -cut.far.at_px - cut.far.half_width_px


def reach_tiles(plan: LayerPlan, nearest_px: float, wider_scale: float, tile_px: float) -> int:
    """Return the distance from its content, in tiles, up to which a layer can be visible.

    `nearest_px` is the smallest signed coc in the picture, `wider_scale` the larger half extent of
    a disc, and `tile_px` the side of a tile in pixels of the picture.
    """
    uncovered = (max(-nearest_px, 0.0) + plan.widest_px) / 2
    reach = wider_scale * max(SPREAD * plan.widest_px, uncovered) + MARGIN_PX
    return math.ceil(reach / tile_px) + 1
