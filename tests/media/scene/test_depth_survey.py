"""What the GPU tells of a depth picture, against NumPy on the same pixels: to the last bit."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from heatlens.core.model.value_bins import bins_of
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import new_texture, upload
from heatlens.render.scene_gpu.depth_survey import DepthSurvey

DEPTHS = st.one_of(
    st.floats(2.0**-10, 2.0**17, width=32),
    st.floats(2.0**-99, 2.0**122, width=32),
    st.just(math.inf),
)
PICTURES = arrays(np.float32, array_shapes(min_dims=2, max_dims=2, max_side=9), elements=DEPTHS)


@pytest.fixture(scope="module")
def survey(session_context: Device) -> DepthSurvey:
    return DepthSurvey(session_context)


def check(ctx: Device, survey: DepthSurvey, depth_m: np.ndarray) -> None:
    texture = new_texture(ctx, depth_m.shape[::-1], 1)
    upload(texture, depth_m)
    found = survey.of(texture)
    texture.release()
    finite = depth_m[np.isfinite(depth_m)]
    ends = (finite.min(), finite.max()) if finite.size else (math.inf, math.inf)
    assert (found.near_m, found.far_m) == ends
    assert found.infinite_count == depth_m.size - finite.size
    expected = bins_of(np.float32(1.0) / depth_m)
    assert (found.dioptres.low, found.dioptres.high) == (expected.low, expected.high)
    np.testing.assert_array_equal(found.dioptres.counts, expected.counts)
    np.testing.assert_array_equal(found.dioptres.occupied, expected.occupied)


@given(PICTURES)
def test_whatever_is_drawn(session_context, survey, depth_m):
    check(session_context, survey, depth_m)


@pytest.mark.parametrize("value", [1e-3, 1.0, 3.7, 1e37, math.inf])
@pytest.mark.parametrize("shape", [(1, 1), (1, 700), (700, 1), (3, 5)])
def test_all_of_one_depth(ctx, survey, value, shape):
    check(ctx, survey, np.full(shape, value, np.float32))


def test_every_mantissa_bit_and_more_pixels_than_workers(ctx, survey, rng):
    """Half a million places between 1 m and 5 m, where a bin is a hundred floats wide or so."""
    depth_m = rng.uniform(1.0, 5.0, (500, 1000)).astype(np.float32)
    check(ctx, survey, depth_m)
    depth_m[rng.random(depth_m.shape) < 0.3] = np.inf
    check(ctx, survey, depth_m)


def test_neighbouring_floats_are_told_apart(ctx, survey):
    """A step so narrow that a reciprocal one bit off lies in another bin."""
    bits = np.float32(1.9).view(np.uint32) + np.arange(8000, dtype=np.uint32)
    check(ctx, survey, bits.view(np.float32).reshape(80, 100))
