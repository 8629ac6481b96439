"""Frames along a line of the screen, and the words of the ruler over them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.studio.ui.timeline.view import TimeScale


@given(st.integers(-50, 1000), st.integers(1, 5000), st.floats(100, 2000), st.floats(4, 60))
def test_text_x_keeps_words_of_the_ruler_between_its_ends(first, count, width, words_width):
    scale = TimeScale.over(first, first + count, 130.0, width)
    for frame in (first, first + count // 2, first + count):
        x = scale.text_x(frame, words_width)
        assert scale.x <= x <= scale.x + scale.width - words_width + 1e-9
        assert x <= scale.x_at(frame) <= x + words_width


def test_text_x_centers_words_on_their_frame():
    scale = TimeScale.over(1, 240, 130.0, 787.0)
    assert scale.text_x(100, 24.0) == pytest.approx(scale.x_at(100) - 12.0)
    assert scale.text_x(240, 24.0) == 130.0 + 787.0 - 24.0
