"""The histogram over dioptres, against NumPy's of the same, and at the ends of what plates hold."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.value_bins import BARS, DepthHistogram, bins_of, depth_histogram
from heatlens.core.model.value_bins import BINS as FINE_BINS

DEPTHS = st.lists(st.one_of(st.floats(0.01, 1e5), st.just(math.inf)), min_size=1, max_size=60).map(
    lambda depths: np.array(depths, np.float32).reshape(1, -1)
)


def histogram_of(depth_m: np.ndarray) -> DepthHistogram:
    return depth_histogram(bins_of(np.float32(1.0) / depth_m))


@given(DEPTHS)
def test_heights_are_roots_of_how_many_lie_there(depth_m):
    """Counted below every edge between two bins; what a fine bin holds falls to one side of it."""
    found = histogram_of(depth_m)
    assert found.heights.shape == (BARS,) and found.heights.max() == 1.0
    shares = found.heights**2
    below = np.cumsum(shares / shares.sum() * depth_m.size)
    dioptres = np.sort(1.0 / depth_m.ravel().astype(np.float64))
    edges = np.linspace(0, found.most_dioptres, BARS + 1)[1:]
    near = 1e-5 * edges + np.ptp(dioptres) / FINE_BINS
    assert np.all(below >= np.searchsorted(dioptres, edges - near) - 1e-6)
    assert np.all(below <= np.searchsorted(dioptres, edges + near, side="right") + 1e-6)


@given(DEPTHS)
def test_every_surface_is_on_the_bar_with_room_in_front(depth_m):
    found = histogram_of(depth_m)
    assert 0 < found.most_dioptres < math.inf
    nearest = float((1 / depth_m.astype(np.float64)).max())
    assert nearest == 0 or found.most_dioptres == pytest.approx(1.12 * nearest, rel=1e-6)
    assert found.heights[-1] == 0.0 or nearest == 0


def test_a_frame_where_nothing_was_hit_is_all_at_infinity():
    found = histogram_of(np.full((3, 5), np.inf, np.float32))
    assert (found.most_dioptres, found.heights[0], found.heights[1:].max()) == (1.0, 1.0, 0.0)


@given(DEPTHS, st.floats(0.0, 50.0))
def test_it_reaches_as_far_as_the_other_frames_of_the_shot(depth_m, least_most):
    """The scale stays where it is from frame to frame, and each distance has its place on it."""
    own = histogram_of(depth_m).most_dioptres
    found = depth_histogram(bins_of(np.float32(1.0) / depth_m), least_most)
    assert found.most_dioptres >= least_most
    if np.isfinite(depth_m).any():
        assert found.most_dioptres == max(own, least_most)
