"""Parts of the work of gather (steps), scatter (bins) and pyramid (levels)."""

import math
from itertools import pairwise

import numpy as np
import pytest

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.render.defocus import other_methods, scatter_pass
from heatlens.render.defocus.other_methods import (
    gather_steps,
    layout_levels,
    level_variance,
    pyramid_size,
)
from heatlens.render.defocus.scatter_pass import bin_coc_px, bin_starts, disc_sums
from heatlens.render.gpu.shader_constants import SCATTER_BINS
from support.methods_of_plates import DISCS, render_with_method
from support.plates import coc_plate_of


def test_disc_methods_in_many_steps_give_same_picture(ctx, renderer, rng, monkeypatch):
    color, coc = rng.random((40, 50, 3), np.float32), np.linspace(-25, 25, 50) * np.ones((40, 1))
    plate = coc_plate_of(color, coc.astype(np.float32))
    whole = {method: render_with_method(renderer, plate, method) for method in DISCS}
    monkeypatch.setattr(other_methods, "_SAMPLES_PER_STEP", 3000)
    monkeypatch.setattr(scatter_pass, "_FRAGMENTS_PER_STEP", 3000)
    for method in DISCS:
        np.testing.assert_allclose(
            render_with_method(renderer, plate, method), whole[method], rtol=1e-5
        )


@pytest.mark.parametrize("size", [(1920, 1080), (1, 1), (7, 4000), (4000, 7)])
@pytest.mark.parametrize("reach", [(1, 1), (101, 101), (60, 240), (50_000, 50_000)])
def test_gather_steps_cover_disc_and_picture_once(size, reach):
    steps = gather_steps(size, reach)
    rows = sum(s.disc_last - s.disc_first + 1 for s in steps if s.band_start == 0)
    assert rows == 2 * min(reach[1], size[1] - 1) + 1
    bands = sorted({(s.band_start, s.band_rows) for s in steps})
    assert sum(rows for _, rows in bands) >= size[1]
    assert all(a + rows == b for (a, rows), (b, _) in pairwise(bands))
    across = 2 * min(reach[0], size[0] - 1) + 1
    assert all((s.disc_last - s.disc_first + 1) * (across + 1) < 65_535 for s in steps)


def test_bin_starts_order_bins_far_to_near_then_by_pixel():
    counts = np.zeros((2, SCATTER_BINS), np.uint32)
    counts[:, 5], counts[:, 40] = (2, 3), (1, 4)
    starts = bin_starts(counts)
    assert (starts[0, 40], starts[1, 40]) == (0, 1)
    assert (starts[0, 5], starts[1, 5]) == (5, 7)


def test_bin_coc_px_grows_by_a_quarter_per_bin():
    assert bin_coc_px(32, 100.0) == 1.0
    assert bin_coc_px(35, 100.0) == bin_coc_px(29, 100.0) == pytest.approx(1.25**3)
    assert bin_coc_px(63, 2e4) == bin_coc_px(0, 2e4) == 2e4


def test_disc_sums_match_disc_area():
    sums = disc_sums(DiscShape())
    assert sums[128] == pytest.approx(math.pi * (64 + 1 / 12), rel=0.005)
    assert disc_sums(DiscShape(Aperture(squeeze=2.0)))[128] == pytest.approx(
        sums[128] / 2, rel=0.01
    )


def test_layout_levels_do_not_overlap():
    for size in ((1, 1), (2, 3), (1920, 1080), (5, 4000)):
        boxes = layout_levels(size, math.inf)
        covered = np.zeros(pyramid_size(boxes)[::-1], int)
        for x, y, width, height in boxes:
            covered[y : y + height, x : x + width] += 1
        assert covered.max() == 1
        assert covered.shape[0] <= size[1] + 16 and covered.shape[1] <= size[0] + 16


def test_layout_levels_has_as_many_levels_as_widest_disc_needs():
    assert layout_levels((640, 480), 0.0) == []
    for widest in (1.0, 20.0, 200.0):
        levels = len(layout_levels((4096, 4096), widest))
        assert level_variance(levels) >= widest**2 / 16 > level_variance(levels - 1)
