"""Cut the picture into depth layers, by signed circle of confusion.

One cut separates what is in focus from what is in front of it, and another lies behind the focus.
All nearer cuts are in gaps between things. A cut is used as soon as one pixel is within its
transition, so that it appears and disappears without a jump during a rack focus.

The gaps are found among depths in dioptres, because the blurs of two things then differ equally at
every focus. So gaps depend on the picture and not on the lens: while focus or iris move, everything
stays in its layer, except when it comes into focus.

The cost of a set of cuts is estimated, with weights that suit many pictures: things of different
blur in one layer keep light from each other, a thing that a cut crosses is blurred in two parts,
and every layer takes time. Dynamic programming finds the cheapest of all sets.
"""

from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from heatlens.core.model.shot.settings import LAYERS_MAX
from heatlens.core.model.value_bins import ValueBins, bin_step

Array = npt.NDArray[np.float64]

GAPS_MAX = 6
FAR_FROM_PX = 1.5  # coc, in pixels at full size, from which a surface belongs to the far field
_FAR_SOFTNESS = 0.2  # half width of the transition at that cut, as a share of its coc
_CELLS = 256  # cells in which values are counted; a cut is between two cells
_OUTLIER_SHARE = (
    0.0005  # share of the values at either end that is ignored for the range of the cells
)
_POWER = 0.65  # exponent of the distance of two values in the cost of sharing a layer
_CROSSING = 0.12  # cost of a cut through all values
_NEARBY = 0.02  # distance from a cut, as a share of the range, at which a value counts only 1/e
_LAYER = 0.0005  # cost of one more layer
_SOFTNESS = 0.01  # half width of a cut's transition, as a share of the range


# Cuts lie in gaps between things: mean FLIP of eleven lenses .0432, against .0445 with cuts at
# fixed diameters (-1, -4, -10, -25 and -62.5 px), and in less time. Fixed cuts go through things,
# which a focus pull then moves from layer to layer. Only what is seen in the frame is counted:
# hidden surfaces of fragment lists, and those outside the frame, fill the gap between two things (a
# face with known surfaces: .0153 with them, .0105 without).
@lru_cache(maxsize=16)
def gaps_of(bins: ValueBins) -> Array:
    """Return the ends (n, 2) of the transition of each cut, in the unit of `bins`, ascending.

    n is 0 if nearly all values are equal, or no cut is worth its cost.
    """
    shares = bins.counts / bins.counts.sum()
    low, high = np.interp((_OUTLIER_SHARE, 1.0 - _OUTLIER_SHARE), np.cumsum(shares), bins.middles)
    if not bin_step(low, high):
        return np.zeros((0, 2))
    cell_of_bin = np.clip((bins.middles - low) / (high - low) * _CELLS, 0, _CELLS - 1).astype(
        np.int64
    )
    cells = np.bincount(cell_of_bin, shares, _CELLS).astype(np.float64)
    cuts = low + (high - low) / _CELLS * np.array(_cheapest_cuts(cells), np.float64)
    return cuts[:, None] + (high - low) * np.array([-_SOFTNESS, _SOFTNESS])


# Dynamic programming: the cost of a set of cuts is a sum over its layers and cuts. The cheapest
# layers up to a cell with n cuts are therefore the cheapest up to an earlier cell with n - 1 cuts,
# and one more layer. No set has to be tried as a whole.
def _cheapest_cuts(cells: Array) -> list[int]:
    """Return the numbers of the cells before which to cut, ascending.

    `cells` is the share of all values in each cell.
    """
    layers, crossing = _layer_costs(cells), _LAYER + _CROSSING * (_cost_weights()[1] @ cells)
    costs, previous_cells = (
        [layers[0]],
        [],
    )  # least cost of the cells up to each end, by number of cuts
    for _ in range(GAPS_MAX):
        candidates = (costs[-1] + crossing)[:, None] + layers
        previous_cells.append(candidates.argmin(axis=0))
        costs.append(candidates.min(axis=0))
    cuts = [_CELLS]  # the end of the last layer; the cuts are followed back from there
    for previous in previous_cells[: int(np.argmin([cost[-1] for cost in costs]))][::-1]:
        cuts.append(int(previous[cuts[-1]]))
    return cuts[:0:-1]


# The cost of a layer is a sum over all pairs of its cells. A summed-area table of the pairs gives
# that sum for every first and last cell at once.
def _layer_costs(cells: Array) -> Array:
    """Return the cost of a layer from each first cell (row) to each end (column), exclusive.

    The cost is infinite where the end is not after the first cell.
    """
    pairs = np.zeros((_CELLS + 1, _CELLS + 1))
    pairs[1:, 1:] = (cells[:, None] * cells * _cost_weights()[0]).cumsum(axis=0).cumsum(axis=1)
    diagonal = np.diagonal(pairs)
    costs = 0.5 * (diagonal + diagonal[:, None] - pairs - pairs.T)
    return np.where(np.tri(_CELLS + 1, dtype=bool), np.inf, costs)


@cache
def _cost_weights() -> tuple[Array, Array]:
    """Return the cost of each pair of cells in a layer, and how much each cut crosses each cell.

    The first are (cells, cells), the second (cells + 1, cells), from 0 (far away) up to 1.
    """
    cells = np.arange(_CELLS)
    pair_distance = np.abs(cells[:, None] - cells) / _CELLS
    cut_distance = np.abs(np.arange(_CELLS + 1)[:, None] - cells - 0.5) / _CELLS
    return pair_distance**_POWER, np.exp(-cut_distance / _NEARBY)


FIRST_CUT_PX = -1.0  # limit between the sharp range and anything in front of it
FIRST_SOFTNESS_PX = 0.5  # half width of its transition: wide, because every pull passes it
FAR_CUT_SHARE = 1 / 3  # position of the far cut, as a share of the farthest coc ...
FAR_CUT_LEAST_PX = 1.3  # ... but at least this
FAR_SOFTNESS = 0.2  # half width of its transition, as a share of its coc ...
FAR_SOFTNESS_LEAST_PX = 0.8  # ... but at least this, because the farthest thing may pass it

_OUTER_LIMIT_PX = 1.0e30  # larger than any coc


@dataclass(frozen=True, slots=True)
class Cut:
    """A limit between two layers: signed coc and half width of the transition, in pixels."""

    at_px: float
    half_width_px: float


NEARER_THAN_ALL = Cut(-_OUTER_LIMIT_PX, 0.1 * _OUTER_LIMIT_PX)
FARTHER_THAN_ALL = Cut(_OUTER_LIMIT_PX, 0.1 * _OUTER_LIMIT_PX)
_OUTER_LIMITS = (NEARER_THAN_ALL, FARTHER_THAN_ALL)


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
    occupied_px: Array, gaps_px: Array, layers_max: int, proxy: float = 1.0
) -> list[LayerCut]:
    """Return at most `layers_max` layers of a picture, far to near.

    `occupied_px` is the signed coc that occurs in the picture, ascending. `gaps_px` are the ends
    (n, 2) of the transitions of cuts in gaps, ascending. Empty layers are left out. A picture
    scaled by `proxy` is cut at the same depths as the whole picture.
    """
    full_size_layers = _cuts_at_full_size(occupied_px / proxy, gaps_px / proxy, layers_max)
    return (
        full_size_layers
        if proxy == 1.0
        else [_scale_layer(layer, proxy) for layer in full_size_layers]
    )


def _scale_layer(layer: LayerCut, proxy: float) -> LayerCut:
    """Return the layer with its limits for a picture scaled by `proxy`."""
    near, far = (
        cut if cut in _OUTER_LIMITS else Cut(cut.at_px * proxy, cut.half_width_px * proxy)
        for cut in (layer.near, layer.far)
    )
    return replace(layer, near=near, far=far)


# Behind the focus there is one cut. Without it a sharp wire fence insulates each mesh of the
# blurred background from the next (FLIP .148 against .109 in the prototype); more cuts there gained
# nothing. The cut is soft, because what is guessed behind wires changes with the layer of the wall:
# a softer cut calmed a slow focus pull over that fence from 2.22 to 1.76.
def _cuts_at_full_size(occupied_px: Array, gaps_px: Array, layers_max: int) -> list[LayerCut]:
    """Return the layers of a picture at full size, far to near, without empty ones.

    The arguments are those of `layer_cuts`.
    """
    farthest_px = float(occupied_px[-1])
    far_px = max(farthest_px * FAR_CUT_SHARE, FAR_CUT_LEAST_PX)
    far = Cut(far_px, max(far_px * FAR_SOFTNESS, FAR_SOFTNESS_LEAST_PX))
    cuts = [far] if far.at_px - far.half_width_px < farthest_px else []
    cuts = cuts[: layers_max - 1]
    cuts += _near_cuts(occupied_px, gaps_px, layers_max - 1 - len(cuts))
    limits = [FARTHER_THAN_ALL, *cuts, NEARER_THAN_ALL]
    layers = [
        LayerCut(near=closer, far=farther, is_before_focus=farther.at_px <= FIRST_CUT_PX)
        for farther, closer in pairwise(limits)
    ]
    layers = [layer for layer in layers if _contains_any(layer, occupied_px)]
    return [replace(layers[0], far=FARTHER_THAN_ALL), *layers[1:]]


def _near_cuts(occupied_px: Array, gaps_px: Array, count: int) -> list[Cut]:
    """Return at most `count` cuts in front of the focus that some pixel reaches, far to near.

    Of more gaps, those nearest to the camera are used: they stay the same during a focus pull.
    """
    if not count:
        return []
    first = Cut(FIRST_CUT_PX, FIRST_SOFTNESS_PX)
    gaps = gaps_px[gaps_px[:, 1] < first.at_px - first.half_width_px][: count - 1]
    cuts = [first, *(Cut((low + high) / 2, (high - low) / 2) for low, high in gaps[::-1].tolist())]
    return [cut for cut in cuts if cut.at_px + cut.half_width_px > occupied_px[0]]


def _contains_any(layer: LayerCut, occupied_px: Array) -> bool:
    """Return True if any coc lies in the layer or its transitions."""
    low = layer.near.at_px - layer.near.half_width_px
    high = layer.far.at_px + layer.far.half_width_px
    first = int(np.searchsorted(occupied_px, low))
    return first < len(occupied_px) and bool(occupied_px[first] <= high)


def with_far_cut(cuts: list[LayerCut], proxy: float) -> list[LayerCut]:
    """Return the layers, far to near, with an additional cut where the far field begins.

    `proxy` is the scale of the picture. If that makes too many layers, the new cut replaces its
    neighbor: the farther one, because the far field blurs what lies behind the cut by itself, or
    the nearer one where none is farther.
    """
    at_px = FAR_FROM_PX * proxy
    cut = Cut(at_px, at_px * _FAR_SOFTNESS)
    index = next((i for i, layer in enumerate(cuts) if layer.near.at_px < at_px), None)
    if index is None:  # everything is farther
        return [*cuts[:-1], replace(cuts[-1], near=cut)]
    # The layer with the cut becomes two; behind and in front of them the layers stay.
    farther, nearer = replace(cuts[index], near=cut), replace(cuts[index], far=cut)
    behind, in_front = cuts[:index], cuts[index + 1 :]
    if behind and farther.far.at_px < 2 * at_px:  # too close to the next cut, which it replaces
        behind, farther = behind[:-1], replace(behind[-1], near=cut)
    if len(behind) + 2 + len(in_front) > LAYERS_MAX:
        if behind:
            behind, farther = behind[:-1], replace(farther, far=behind[-1].far)
        else:
            nearer, in_front = replace(nearer, near=in_front[0].near), in_front[1:]
    return [*behind, farther, nearer, *in_front]
