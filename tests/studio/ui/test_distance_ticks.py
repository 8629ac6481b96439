"""Ticks under the focus bar: round distances in the unit shown, for any range of depth."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.units import FOOT_M, INCH_M, parse_distance_m
from heatlens.core.model.value_bins import BINS, DepthHistogram, bin_values, depth_histogram
from heatlens.studio.ui.panels.depth_scale import Tick, distance_ticks, scale_ticks, visible_heights

WIDTH = 310.0  # of the bar at the narrowest
STEPS = (1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)


def width_of(text: str) -> float:
    return 7.0 * len(text)


def ticks_from(near_m: float, unit: str, width: float = WIDTH) -> list[Tick]:
    scale = DepthHistogram(np.zeros(BINS), 1.0 / near_m)

    def x_at(distance_m: float) -> float:
        return (1.0 - scale.scale_position(distance_m)) * width

    return distance_ticks(near_m, unit, x_at, (0.0, width), width_of)


def round_m(unit: str) -> np.ndarray:
    """Return all round distances of the unit in meters, computed from decimal text."""
    numbers = np.array([float(f"{step}e{power}") for power in range(-4, 8) for step in STEPS])
    if unit == "m":
        return numbers
    return np.concatenate([numbers[numbers < 12] * INCH_M, numbers[numbers >= 1] * FOOT_M])


@given(st.floats(0.01, 1000.0), st.sampled_from(["m", "ft"]), st.floats(280.0, 900.0))
def test_distance_ticks_are_at_least_three_and_never_overlap(near_m, unit, width):
    ticks = sorted(ticks_from(near_m, unit, width), key=lambda tick: tick.text_x)
    assert len(ticks) >= 3 and ticks[-1].text == "inf"
    assert [t.distance_m for t in ticks] == sorted(t.distance_m for t in ticks)
    edges = np.array([(t.text_x, t.text_x + width_of(t.text)) for t in ticks])
    assert edges[0, 0] >= 0 and edges[-1, 1] == pytest.approx(width)
    assert np.all(edges[1:, 0] - edges[:-1, 1] >= 7.0 - 1e-9)


@given(st.floats(0.01, 1000.0), st.sampled_from(["m", "ft"]))
def test_distance_ticks_are_round_and_labeled_with_their_distance(near_m, unit):
    for distance_m, text, text_x in ticks_from(near_m, unit):
        if math.isfinite(distance_m):
            assert np.isclose(round_m(unit), distance_m, rtol=1e-9).any()
            assert parse_distance_m(text) == pytest.approx(distance_m, rel=1e-3)
            middle = text_x + width_of(text) / 2
            assert middle == pytest.approx((1 - near_m / distance_m) * WIDTH)


@pytest.mark.parametrize(
    ("near_m", "unit", "expected"),
    [
        (12.5, "m", {"15 m", "20 m", "30 m", "50 m", "inf"}),
        (1.2, "m", {"1.5 m", "2 m", "3 m", "5 m", "inf"}),
        (1.2, "ft", {"5'", "7'", "10'", "20'", "inf"}),
        (0.04, "m", {"5 cm", "0.1 m", "0.2 m", "inf"}),
        (0.1, "ft", {'5"', "1'", "2'", "inf"}),
    ],
)
def test_distance_ticks_of_usual_ranges(near_m, unit, expected):
    assert expected <= {tick.text for tick in ticks_from(near_m, unit)}


def test_visible_heights_ignore_the_high_bin_of_the_sky():
    sky = np.zeros(100_000, np.float32)
    histogram = depth_histogram(bin_values(np.append(sky, np.float32([0.2, 0.2, 0.2, 0.2, 0.1]))))
    assert np.sort(histogram.heights)[-2] < 0.01
    heights = visible_heights(histogram)
    assert np.sort(heights)[-4:] == pytest.approx([0.0, 0.5, 1.0, 1.0])
    assert heights[0] == 1.0


def test_visible_heights_of_sky_only_keep_all_heights():
    histogram = depth_histogram(bin_values(np.zeros(9, np.float32)))
    assert visible_heights(histogram).tolist() == histogram.heights.tolist()


@given(st.floats(0.05, 20.0), st.floats(-0.04, 0.4), st.sampled_from(["m", "ft"]))
def test_scale_ticks_from_the_film_plane_are_placed_by_pupil_distance(near_m, offset_m, unit):
    histogram = DepthHistogram(np.zeros(BINS), 1.0 / near_m)
    for distance_m, text, text_x in scale_ticks(histogram, offset_m, unit, (0.0, WIDTH), width_of):
        if math.isfinite(distance_m):
            middle = text_x + width_of(text) / 2
            fraction = near_m / (distance_m - offset_m)
            assert middle == pytest.approx((1 - min(fraction, 1.0)) * WIDTH, abs=1e-6)
