"""What is known of a plate's depths without looking at them again each frame."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from heatlens.core.model.value_bins import bins_of


@given(arrays(np.float32, (5, 7), elements=st.floats(0, 20, width=32)))
def test_every_value_lies_in_an_occupied_bin(values: np.ndarray) -> None:
    ends = bins_of(values).occupied
    assert np.all(np.diff(ends) >= 0)
    assert ends[0] == values.min() and ends[-1] == values.max()
    width = max(1e-6, 2 * (ends[-1] - ends[0]) / 4096)
    for value in values.ravel():
        assert np.abs(ends - value).min() <= width


def test_a_gap_between_depths_stays_empty() -> None:
    values = np.concatenate([np.full(500, 0.1), np.full(500, 4.0)]).astype(np.float32)
    ends = bins_of(values).occupied
    assert not np.any((ends > 0.2) & (ends < 3.9))


def test_values_all_but_the_same_are_one_place() -> None:
    for low, high in ((0.0, 0.0), (2.0, 2.0), (0.0, 8e-38)):
        np.testing.assert_array_equal(
            bins_of(np.array([low, high], np.float32)).occupied, np.array([low, high], np.float32)
        )
