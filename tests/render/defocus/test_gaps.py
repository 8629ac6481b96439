"""Gaps between things: cuts never go through one, and belong to what is seen, not to the lens."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.value_bins import ValueBins, bin_values
from heatlens.media.plate.behind import with_behind
from heatlens.render.defocus import layer_cuts as gaps
from heatlens.render.defocus.layer_cuts import gaps_of, layer_cuts
from heatlens.render.source.pinhole import optics_of
from support.plates import plate_of

Things = list[tuple[float, float, float]]  # share of the picture, farthest and nearest value
WALL = (0.5, 0.1, 0.12)
FIGURES: Things = [WALL, (0.2, 0.4, 0.45), (0.3, 1.0, 1.15)]
CONTENTS = st.lists(st.floats(0, 1), min_size=gaps._CELLS, max_size=gaps._CELLS).map(
    lambda shares: np.array(shares) ** 8
)


def bins_with(things: Things, pixels: int = 20_000) -> ValueBins:
    values = [np.linspace(far, near, int(pixels * share)) for share, far, near in things]
    return bin_values(np.concatenate(values).astype(np.float32))


@given(st.floats(0.5, 2.0), st.floats(0.0, 0.1), st.floats(0.05, 0.4))
def test_gap_between_object_and_wall_separates_them(far, deep, share) -> None:
    ends = gaps_of(bins_with([WALL, (share, far, far * (1.0 + deep))]))
    np.testing.assert_array_equal(((WALL[2] < ends) & (ends < far)).all(axis=1), [True])


def test_gaps_separate_each_pair_of_objects_once() -> None:
    ends = gaps_of(bins_with(FIGURES))
    assert len(ends) == len(FIGURES) - 1
    for (low, high), (farther, nearer) in zip(ends, pairwise(FIGURES), strict=True):
        assert farther[2] < low < high < nearer[1]


def test_gaps_of_single_depth_are_empty() -> None:
    assert not len(gaps_of(bin_values(np.ones(9, np.float32))))
    assert not len(gaps_of(bin_values(np.append(np.ones(99_999), 3.0).astype(np.float32))))


def test_gaps_of_bins_ignore_stray_pixels() -> None:
    """A speck just before the lens widens the bins, but all objects stay separated."""
    ends = gaps_of(bins_with([*FIGURES, (0.0003, 30.0, 30.0)]))
    for farther, nearer in pairwise(FIGURES):
        assert any(farther[2] < low < high < nearer[1] for low, high in ends)


@pytest.mark.parametrize(("scale", "offset"), [(4.0, 0.0), (0.25, 3.0), (16.0, -2.0)])
def test_gaps_scale_with_unit_of_depth(scale: float, offset: float) -> None:
    moved = [(share, scale * far + offset, scale * near + offset) for share, far, near in FIGURES]
    np.testing.assert_allclose(
        gaps_of(bins_with(moved)), scale * gaps_of(bins_with(FIGURES)) + offset, atol=2e-3 * scale
    )


@given(st.floats(1.2, 5.0), st.floats(1.2, 5.0), st.floats(0.7, 4.0))
def test_layers_before_focus_hold_same_depths_at_every_focus_distance(a, b, f_stop) -> None:
    """Two focus distances and f-stops give the same layers: no pixel changes layers in a pull."""
    bins = bins_with([(0.3, 0.05, 0.2), (0.1, 0.85, 0.9), (0.2, 1.0, 2.0), (0.4, 2.6, 2.65)])
    values = np.linspace(0.9, 2.65, 300)  # all nearer than either focus
    found = []
    for lens in (Lens(50.0, f_stop, a, 36.0), Lens(50.0, 0.7, b, 36.0)):
        line = coc_line(lens, 1920)
        occupied, ends, coc = (
            (line.at_infinity_px + line.per_dioptre_px * it)[::-1]
            for it in (bins.occupied, gaps_of(bins), values)
        )
        limits = [it.near.at_px for it in layer_cuts(occupied, ends[:, ::-1], 7)[:-1]]
        found.append(np.searchsorted(sorted(limits), coc))
    np.testing.assert_array_equal(np.diff(found[0]), np.diff(found[1]))


@given(CONTENTS, st.lists(st.integers(1, gaps._CELLS - 1), max_size=gaps.GAPS_MAX, unique=True))
def test_cheapest_cuts_cost_no_more_than_any_others(content: np.ndarray, others: list[int]) -> None:
    """The cost is computed by its definition, for the cuts found and for any others."""
    if not content.sum():
        return
    content = content / content.sum()

    def cost(cuts: list[int]) -> float:
        cells = np.arange(gaps._CELLS)
        layer = np.searchsorted(cuts, cells, "right")
        ill = (abs(cells[:, None] - cells) / len(cells)) ** gaps._POWER
        together = layer[:, None] == layer
        crossed = [
            content @ np.exp(-abs(cells + 0.5 - cut) / len(cells) / gaps._NEARBY) for cut in cuts
        ]
        shared = 0.5 * content @ (ill * together) @ content
        return float(shared + gaps._CROSSING * sum(crossed) + gaps._LAYER * len(cuts))

    assert cost(gaps._cheapest_cuts(content)) <= cost(sorted(others)) + 1e-9


def test_gaps_ignore_surfaces_that_are_known_but_hidden() -> None:
    """Surfaces that a file gives behind others add no gaps."""
    depth_m = np.where(np.arange(64) < 32, 1.0, 8.0)[None].repeat(16, axis=0)
    plate = plate_of(np.full((16, 64, 3), 0.5), depth_m)
    plate_with_behind = with_behind(
        plate, [plate_of(np.full((16, 64, 3), 0.2), np.full((16, 64), 20.0))]
    )
    assert plate_with_behind.bins.occupied.size > plate.bins.occupied.size
    lens = Lens(50.0, 1.4, 3.0, 36.0)
    gaps_of_plate, gaps_with_behind = (
        optics_of(it, it.bins, lens).gaps_px for it in (plate, plate_with_behind)
    )
    np.testing.assert_array_equal(gaps_of_plate, gaps_with_behind)
