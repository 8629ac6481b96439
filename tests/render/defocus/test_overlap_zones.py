"""Zones of one kind of views fade out where views of the other kind replace the picture anyway."""

import numpy as np
import pytest
from numpy.typing import NDArray

from heatlens.render.defocus.overlap_zones import guess_shares, least_shares
from heatlens.render.gpu.shader_constants import FAR_BLOCK, FAR_WHOLE_PX_2


def _pixel_weights(excess_px_2: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the weight of the views at each pixel, as part_over.comp.glsl defines it.

    It is the mean over the blocks around the pixel, weighted by a tent two blocks wide to each
    side. Blocks beyond the picture are those at its border.
    """
    rows, columns = excess_px_2.shape[:2]
    share = np.clip(excess_px_2 / FAR_WHOLE_PX_2, 0.0, 1.0)
    share_of_block = share[..., 0] * (1.0 - share[..., 1])
    weights = np.empty((rows * FAR_BLOCK, columns * FAR_BLOCK))
    for y, x in np.ndindex(weights.shape):
        position = (np.array([y, x]) + 0.5) / FAR_BLOCK - 0.5
        first = np.floor(position).astype(int) - 1
        total = tents = 0.0
        for offset in np.ndindex(4, 4):
            block = first + offset
            tent = np.prod(np.maximum(2.0 - np.abs(block - position), 0.0))
            row, column = np.clip(block, 0, [rows - 1, columns - 1])
            total, tents = total + tent * share_of_block[row, column], tents + tent
        weights[y, x] = total / tents
    return weights


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_least_share_of_block_is_never_more_than_weight_of_its_pixels(seed: int) -> None:
    generator = np.random.default_rng(seed)
    excess_px_2 = generator.uniform(-50.0, 2 * FAR_WHOLE_PX_2, (7, 9, 2)).astype(np.float32)
    excess_px_2[..., 1] -= FAR_WHOLE_PX_2
    shares = least_shares(excess_px_2)
    weights = _pixel_weights(excess_px_2).reshape(7, FAR_BLOCK, 9, FAR_BLOCK)
    assert (shares <= weights.min(axis=(1, 3)) + 1e-6).all()


def test_block_amid_whole_blocks_is_replaced_wholly() -> None:
    excess_px_2 = np.full((7, 9, 2), FAR_WHOLE_PX_2, np.float32)
    excess_px_2[..., 1] = -1.0
    excess_px_2[0, 0, 0] = -1.0  # one corner is in no zone
    expected = np.ones((7, 9), np.float32)
    expected[:3, :3] = 0.0
    np.testing.assert_array_equal(least_shares(excess_px_2), expected)


@pytest.mark.parametrize("reach", [0, 2, 20])
def test_guess_counts_by_what_is_seen_around_a_block(reach: int) -> None:
    seen = np.random.default_rng(1).uniform(0.75, 1.0, (5, 8)).astype(np.float32)
    expected = np.empty(seen.shape)
    for row, column in np.ndindex(seen.shape):
        rows, columns = (slice(max(at - reach, 0), at + reach + 1) for at in (row, column))
        expected[row, column] = np.clip((seen[rows, columns].mean() - 0.8) / 0.2, 0.0, 1.0)
    np.testing.assert_allclose(guess_shares(seen, reach), expected, atol=1e-5)
    assert expected.max() > 0.1
