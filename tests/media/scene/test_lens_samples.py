"""Test points on the lens: within the aperture, evenly spread, and reproducible."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.pupil import Pupil
from heatlens.render.scene_gpu.accumulation import _DIRECTIONS, _digits, _sobol, lens_samples

UNIT, TALL = Pupil(Aperture(), 1.0), Pupil(Aperture(squeeze=2.0), 0.02)
seeds = st.integers(0, 2**32 - 1)


def occupied_boxes(cells: np.ndarray, split: int, levels: int) -> int:
    """Return how many of the 2^levels boxes, 2^split across, hold a point."""
    across, down = 2**split, 2 ** (levels - split)
    return len({(int(x * across), int(y * down)) for x, y in cells})


@given(seeds, st.integers(0, 300), st.integers(0, 64), st.floats(1, 2), st.floats(1e-4, 1))
def test_lens_samples_lie_on_lens_and_in_pixel(
    seed: int, first: int, count: int, squeeze: float, radius_m: float
) -> None:
    pupil = Pupil(Aperture(squeeze=squeeze), radius_m)
    offsets, jitters = lens_samples(first, first + count, pupil, seed)
    assert offsets.shape == jitters.shape == (count, 2)
    assert np.all(np.sum((offsets / pupil.half_extents_m) ** 2, axis=1) <= 1 + 1e-12)
    assert np.all((jitters >= -0.5) & (jitters < 0.5))


@given(seeds, st.integers(0, 200), st.integers(0, 200))
def test_lens_samples_prefix_does_not_change(seed: int, first: int, more: int) -> None:
    all_samples = lens_samples(0, first + more, TALL, seed)
    parts = (lens_samples(0, first, TALL, seed), lens_samples(first, first + more, TALL, seed))
    for all_of_it, *pieces in zip(all_samples, *parts, strict=True):
        np.testing.assert_array_equal(all_of_it, np.concatenate(pieces))


@given(seeds, st.integers(0, 200), st.integers(0, 60), st.integers(3, 16), st.floats(0, 1))
def test_lens_samples_of_bladed_aperture_continue_and_stay_inside(
    seed: int, first: int, more: int, blades: int, curvature: float
) -> None:
    pupil = Pupil(
        Aperture(squeeze=1.5, blades=blades, blade_rotation_deg=20.0, blade_curvature=curvature),
        0.3,
    )
    all_offsets, _ = lens_samples(0, first + more, pupil, seed)
    part, _ = lens_samples(first, first + more, pupil, seed)
    np.testing.assert_array_equal(all_offsets[first:], part)
    assert np.all(pupil.aperture.covers(*(0.9999 * all_offsets / 0.3).T))


def test_lens_samples_fill_polygon_evenly() -> None:
    offsets, _ = lens_samples(0, 1024, Pupil(Aperture(blades=5), 1.0))
    np.testing.assert_allclose(offsets.mean(axis=0), 0, atol=1e-3)
    variance = (2 + np.cos(2 * np.pi / 5)) / 12
    np.testing.assert_allclose(np.cov(offsets.T, bias=True), variance * np.eye(2), atol=1e-3)


def test_lens_samples_of_another_seed_differ() -> None:
    first_seed, second_seed = (lens_samples(0, 32, UNIT, seed)[0] for seed in (0, 1))
    assert np.abs(first_seed - second_seed).max(axis=1).min() > 1e-6


@given(seeds)
def test_lens_samples_have_moments_of_even_disc_and_pixel(seed: int) -> None:
    offsets, jitters = lens_samples(0, 1024, TALL, seed)
    disc = offsets / TALL.half_extents_m
    # 1024 random points would miss these by 16 times as much.
    np.testing.assert_allclose(disc.mean(axis=0), 0, atol=1e-3)
    np.testing.assert_allclose(np.cov(disc.T, bias=True), np.eye(2) / 4, atol=1e-3)
    np.testing.assert_allclose(np.mean(np.sum(disc**2, axis=1)), 0.5, atol=1e-3)
    np.testing.assert_allclose(jitters.mean(axis=0), 0, atol=1e-3)
    np.testing.assert_allclose(np.cov(jitters.T, bias=True), np.eye(2) / 12, atol=1e-3)


@pytest.mark.parametrize("stretch", range(4))
def test_lens_samples_have_equal_share_in_each_ring_and_sector(stretch: int) -> None:
    """256 points after whole runs of 256; random ones miss by sqrt(15) of 16, these by half of
    that.
    """
    misses = []
    for seed in range(32):
        disc, _ = lens_samples(256 * stretch, 256 * (stretch + 1), UNIT, seed)
        turns = np.arctan2(disc[:, 1], disc[:, 0]) / (2 * np.pi) % 1
        for shares in (np.sum(disc**2, axis=1), turns):
            sixteenths = np.clip((shares * 16).astype(int), 0, 15)
            misses.append(np.bincount(sixteenths, minlength=16) - 16)
    assert np.mean(np.square(misses)) < 15 / 4


@pytest.mark.parametrize("count", [64, 66, 256])
def test_lens_samples_have_lower_discrepancy_than_random(
    count: int, rng: np.random.Generator
) -> None:
    from scipy.stats import qmc  # here: costs every worker a second to collect

    lens, jitter = lens_samples(0, count, UNIT)
    radii = np.sum(lens**2, axis=1)
    turns = np.arctan2(lens[:, 1], lens[:, 0]) / (2 * np.pi) % 1
    random = np.median([star_discrepancy(rng.random((count, 2))) for _ in range(15)])
    assert star_discrepancy(np.stack([radii, turns], axis=1)) < 0.6 * random
    assert star_discrepancy(jitter + 0.5) < 0.6 * random
    whole = np.column_stack([radii, turns, jitter + 0.5])
    at_random = np.median([qmc.discrepancy(rng.random((count, 4))) for _ in range(15)])
    assert qmc.discrepancy(whole) < 0.4 * at_random


def star_discrepancy(points: np.ndarray) -> float:
    """Return the largest difference between a corner's area and its share of points, on a grid."""
    grid = np.linspace(0, 1, 33)
    inside = points[None, :, :] <= grid[:, None, None]
    shares = inside[:, :, 0].astype(float) @ inside[:, :, 1].T / len(points)
    return float(np.abs(shares - np.outer(grid, grid)).max())


@given(seeds, st.integers(0, 8), st.integers(0, 8))
def test_sobol_points_of_power_of_two_form_a_net(seed: int, levels: int, split: int) -> None:
    """Each dyadic box of area 1/n holds exactly one of n points, as Sobol sequences guarantee."""
    points = _sobol(np.arange(2**levels, dtype=np.uint32), seed)
    assert occupied_boxes(points[:, :2], min(split, levels), levels) == 2**levels
    for dimension in range(4):
        assert len(np.unique(np.floor(points[:, dimension] * 2**levels))) == 2**levels


def test_unscrambled_sobol_points_equal_those_of_scipy() -> None:
    from scipy.stats import qmc  # here: costs every worker a second to collect

    numbers = np.arange(256, dtype=np.uint32)
    our_points = np.stack([_digits(numbers, row) for row in _DIRECTIONS], axis=1) / 2**32
    scipy_points = qmc.Sobol(4, scramble=False).random(256)  # in the order of Gray's code
    np.testing.assert_array_equal(
        our_points[np.lexsort(our_points.T)], scipy_points[np.lexsort(scipy_points.T)]
    )
