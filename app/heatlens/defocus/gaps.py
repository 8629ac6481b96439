"""Find the gaps between the things in a picture, where it is best cut into layers.

Depths are compared in dioptres, because the blurs of two things then differ equally at every focus.
So gaps depend on the picture and not on the lens: while focus or iris move, everything stays in its
layer, except when it comes into focus.

The cost of a set of cuts is estimated, with weights that suit many pictures: things of different
blur in one layer keep light from each other, a thing that a cut crosses is blurred in two parts,
and every layer takes time. Dynamic programming finds the cheapest of all sets.
"""

from functools import cache, lru_cache

import numpy as np
import numpy.typing as npt

from heatlens.model.value_bins import ValueBins, bin_step

Array = npt.NDArray[np.float64]

GAPS_MAX = 6
_CELLS = 256  # cells in which values are counted; a cut is between two cells
_STRAY = 0.0005  # share of the values at either end that does not widen the cells
_POWER = 0.65  # exponent of the distance of two values in the cost of sharing a layer
_CROSSING = 0.12  # cost of a cut through all values
_NEARBY = 0.02  # distance from a cut, as a share of the range, at which a value counts only 1/e
_LAYER = 0.0005  # cost of one more layer
_SOFTNESS = 0.01  # half width of a cut's transition, as a share of the range


@lru_cache(maxsize=16)
def gaps_of(bins: ValueBins) -> Array:
    """Return the ends (n, 2) of the transition of each cut, in the unit of `bins`, ascending."""
    shares = bins.counts / bins.counts.sum()
    low, high = np.interp((_STRAY, 1.0 - _STRAY), np.cumsum(shares), bins.middles)
    if not bin_step(low, high):
        return np.zeros((0, 2))
    places = np.clip((bins.middles - low) / (high - low) * _CELLS, 0, _CELLS - 1).astype(np.int64)
    cells = np.bincount(places, shares, _CELLS).astype(np.float64)
    cuts = low + (high - low) / _CELLS * np.array(_cheapest_cuts(cells), np.float64)
    return cuts[:, None] + (high - low) * np.array([-_SOFTNESS, _SOFTNESS])


def _cheapest_cuts(cells: Array) -> list[int]:
    """Return the cells before which to cut, ascending."""
    layers, crossing = _layer_costs(cells), _LAYER + _CROSSING * (_weights()[1] @ cells)
    costs, before = [layers[0]], []  # least cost of the cells up to each end, by number of cuts
    for _ in range(GAPS_MAX):
        ways = (costs[-1] + crossing)[:, None] + layers
        before.append(ways.argmin(axis=0))
        costs.append(ways.min(axis=0))
    cuts = [_CELLS]
    for latest in before[: int(np.argmin([cost[-1] for cost in costs]))][::-1]:
        cuts.append(int(latest[cuts[-1]]))
    return cuts[:0:-1]


def _layer_costs(cells: Array) -> Array:
    """Return the cost of a layer from each place (begin) to each later one (end), else infinity."""
    pairs = np.zeros((_CELLS + 1, _CELLS + 1))
    pairs[1:, 1:] = (cells[:, None] * cells * _weights()[0]).cumsum(axis=0).cumsum(axis=1)
    own = np.diagonal(pairs)
    within = 0.5 * (own + own[:, None] - pairs - pairs.T)
    return np.where(np.tri(_CELLS + 1, dtype=bool), np.inf, within)


@cache
def _weights() -> tuple[Array, Array]:
    """Return the cost of each pair of cells in a layer, and how near each place is to each cell."""
    cells = np.arange(_CELLS)
    apart = np.abs(cells[:, None] - cells) / _CELLS
    away = np.abs(np.arange(_CELLS + 1)[:, None] - cells - 0.5) / _CELLS
    return apart**_POWER, np.exp(-away / _NEARBY)
