"""Compare the GPU survey of a depth image with NumPy on the same pixels, bit by bit."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from heatlens.core.model.value_bins import bin_values
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


def check_survey(ctx: Device, survey: DepthSurvey, depth_m: np.ndarray) -> None:
    texture = new_texture(ctx, depth_m.shape[::-1], 1)
    upload(texture, depth_m)
    found = survey.of(texture)
    texture.release()
    finite = depth_m[np.isfinite(depth_m)]
    ends = (finite.min(), finite.max()) if finite.size else (math.inf, math.inf)
    assert (found.near_m, found.far_m) == ends
    assert found.infinite_count == depth_m.size - finite.size
    expected = bin_values(np.float32(1.0) / depth_m)
    assert (found.dioptres.low, found.dioptres.high) == (expected.low, expected.high)
    np.testing.assert_array_equal(found.dioptres.counts, expected.counts)
    np.testing.assert_array_equal(found.dioptres.occupied, expected.occupied)


@given(PICTURES)
def test_depth_survey_of_any_image_equals_numpy(session_context, survey, depth_m):
    check_survey(session_context, survey, depth_m)


@pytest.mark.parametrize("value", [1e-3, 1.0, 3.7, 1e37, math.inf])
@pytest.mark.parametrize("shape", [(1, 1), (1, 700), (700, 1), (3, 5)])
def test_depth_survey_of_constant_depth_equals_numpy(ctx, survey, value, shape):
    check_survey(ctx, survey, np.full(shape, value, np.float32))


def test_depth_survey_of_many_random_depths_equals_numpy(ctx, survey, rng):
    """Half a million values lie between 1 m and 5 m, where a bin is about a hundred floats wide."""
    depth_m = rng.uniform(1.0, 5.0, (500, 1000)).astype(np.float32)
    check_survey(ctx, survey, depth_m)
    depth_m[rng.random(depth_m.shape) < 0.3] = np.inf
    check_survey(ctx, survey, depth_m)


def test_depth_survey_separates_adjacent_floats(ctx, survey):
    """The step is so narrow that a reciprocal one bit off falls into another bin."""
    bits = np.float32(1.9).view(np.uint32) + np.arange(8000, dtype=np.uint32)
    check_survey(ctx, survey, bits.view(np.float32).reshape(80, 100))
