"""Compare the histogram over dioptres with NumPy counts, also for sky and for near surfaces."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.value_bins import BARS, DepthHistogram, bin_values, depth_histogram
from heatlens.core.model.value_bins import BINS as FINE_BINS

DEPTHS = st.lists(st.one_of(st.floats(0.01, 1e5), st.just(math.inf)), min_size=1, max_size=60).map(
    lambda depths: np.array(depths, np.float32).reshape(1, -1)
)


def histogram_of(depth_m: np.ndarray) -> DepthHistogram:
    return depth_histogram(bin_values(np.float32(1.0) / depth_m))


@given(DEPTHS)
def test_histogram_heights_are_square_roots_of_pixel_shares(depth_m):
    """Compare the pixel counts below each bar edge; a fine bin falls wholly to one side of it."""
    histogram = histogram_of(depth_m)
    assert histogram.heights.shape == (BARS,) and histogram.heights.max() == 1.0
    shares = histogram.heights**2
    below = np.cumsum(shares / shares.sum() * depth_m.size)
    dioptres = np.sort(1.0 / depth_m.ravel().astype(np.float64))
    edges = np.linspace(0, histogram.most_dioptres, BARS + 1)[1:]
    near = 1e-5 * edges + np.ptp(dioptres) / FINE_BINS
    assert np.all(below >= np.searchsorted(dioptres, edges - near) - 1e-6)
    assert np.all(below <= np.searchsorted(dioptres, edges + near, side="right") + 1e-6)


@given(DEPTHS)
def test_histogram_range_covers_nearest_surface_with_12_percent_margin(depth_m):
    histogram = histogram_of(depth_m)
    assert 0 < histogram.most_dioptres < math.inf
    nearest = float((1 / depth_m.astype(np.float64)).max())
    assert nearest == 0 or histogram.most_dioptres == pytest.approx(1.12 * nearest, rel=1e-6)
    assert histogram.heights[-1] == 0.0 or nearest == 0


def test_histogram_of_sky_only_has_one_bar_at_infinity():
    histogram = histogram_of(np.full((3, 5), np.inf, np.float32))
    assert (histogram.most_dioptres, histogram.heights[0], histogram.heights[1:].max()) == (
        1.0,
        1.0,
        0.0,
    )


@given(DEPTHS, st.floats(0.0, 50.0))
def test_histogram_range_is_at_least_the_requested_one(depth_m, least_most):
    """The range of other frames keeps the scale fixed, so a distance keeps its position on it."""
    own_most_dioptres = histogram_of(depth_m).most_dioptres
    histogram = depth_histogram(bin_values(np.float32(1.0) / depth_m), least_most)
    assert histogram.most_dioptres >= least_most
    if np.isfinite(depth_m).any():
        assert histogram.most_dioptres == max(own_most_dioptres, least_most)
