"""Test the bins that summarize a plate's depth values, so that they need not be read each frame."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from heatlens.core.model.value_bins import bin_values


@given(arrays(np.float32, (5, 7), elements=st.floats(0, 20, width=32)))
def test_occupied_bins_hold_every_value(values: np.ndarray) -> None:
    ends = bin_values(values).occupied
    assert np.all(np.diff(ends) >= 0)
    assert ends[0] == values.min() and ends[-1] == values.max()
    width = max(1e-6, 2 * (ends[-1] - ends[0]) / 4096)
    for value in values.ravel():
        assert np.abs(ends - value).min() <= width


def test_gap_between_values_has_no_occupied_bin() -> None:
    values = np.concatenate([np.full(500, 0.1), np.full(500, 4.0)]).astype(np.float32)
    ends = bin_values(values).occupied
    assert not np.any((ends > 0.2) & (ends < 3.9))


def test_bin_values_of_nearly_equal_values_returns_the_two_values() -> None:
    for low, high in ((0.0, 0.0), (2.0, 2.0), (0.0, 8e-38)):
        np.testing.assert_array_equal(
            bin_values(np.array([low, high], np.float32)).occupied,
            np.array([low, high], np.float32),
        )
