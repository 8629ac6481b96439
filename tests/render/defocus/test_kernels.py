"""The fitted kernels: light, symmetry, variance and stability, from the numbers in the file."""

import numpy as np
import pytest

from heatlens.render.defocus.kernels import Kernel, gaussian_kernel, named_kernel, rim_kernel
from support.oracle import compact_weights, conductances, repeated_heat, solve_lines

NAMES = ["heat", "disc_2", "disc_3", "disc_4", "disc_5"]


@pytest.mark.parametrize("name", NAMES)
def test_kernel_keeps_light_and_is_symmetric(name: str) -> None:
    kernel = named_kernel(name)
    assert kernel.mix.sum().real == pytest.approx(1.0, abs=1e-7)
    np.testing.assert_array_equal(kernel.mix, kernel.mix.T)


@pytest.mark.parametrize("name", NAMES)
def test_kernel_variance_is_that_of_disc(name: str) -> None:
    """Second moment along an axis: 2 Re sum_ab M_ab kappa_a d^2, a disc's d^2 / 16."""
    kernel = named_kernel(name)
    assert 2 * (kernel.mix.sum(axis=1) @ kernel.poles).real == pytest.approx(1 / 16, rel=1e-5)


def test_gaussian_kernel_steps_share_variance_of_disc() -> None:
    for steps in (1, 2, 5):
        kernel = gaussian_kernel(steps)
        assert steps * 2 * kernel.poles[0].real == pytest.approx(1 / 16)


@pytest.mark.parametrize("name", NAMES)
def test_kernel_poles_are_stable_without_pivoting(name: str) -> None:
    """cos(phi/2) of a pole measures how positive definite the rotated matrix is."""
    phi = np.angle(named_kernel(name).poles)
    assert np.cos(phi / 2).min() > 0.15


@pytest.mark.parametrize("name", NAMES)
def test_kernel_inverses_stay_small_for_any_diameters(name: str, rng: np.random.Generator) -> None:
    """The inverses of all poles stay small, even where the compact c turns its phase."""
    check_inverses(named_kernel(name), rng, trials=200)


def check_inverses(kernel: Kernel, rng: np.random.Generator, trials: int) -> None:
    for trial in range(trials):
        n = int(rng.integers(3, 30))
        uniform = np.full(n, rng.uniform(0.1, 30.0))
        d = uniform if trial % 2 else rng.choice([0.0, 1, 2, 4, 5, 7, 9, 11, 13, 16, 25], n)
        conductance = conductances(d)
        for kappa in kernel.poles:
            flow = kappa * conductance - compact_weights(conductance, kernel)
            unit = np.eye(n, dtype=np.complex128)
            inverse = solve_lines(flow[None], unit[None])[0]
            assert np.linalg.norm(inverse, 2) < 8.0


@pytest.mark.parametrize("name", NAMES)
def test_repeated_border_pixel_has_the_heat_of_many_pixels(name: str) -> None:
    diameters = np.array([0.5, 3.0, 20.0])
    for kappa in named_kernel(name).poles:
        flow = kappa * diameters**2
        heat = np.zeros_like(flow)
        for _ in range(2000):
            heat = flow * (1.0 + heat) / (1.0 + flow + heat)
        np.testing.assert_allclose(repeated_heat(flow), heat, rtol=1e-12)


def test_real_kernels_are_solved_in_real_arithmetic() -> None:
    assert not named_kernel("heat").is_complex
    assert not gaussian_kernel(3).is_complex
    assert named_kernel("disc_2").is_complex


RIM_NAMES = ["disc_2", "disc_3", "disc_4"]
RIM_VALUES = [-1.0, -0.9, -0.4, 0.1, 0.625, 0.8, 1.0]  # of which some are stored and some are mixed


@pytest.mark.parametrize("rim", RIM_VALUES)
@pytest.mark.parametrize("name", RIM_NAMES)
def test_rim_kernel_keeps_light_variance_and_number_of_poles(name: str, rim: float) -> None:
    kernel, flat = rim_kernel(name, rim), named_kernel(name)
    assert kernel.mix.sum().real == pytest.approx(1.0, abs=1e-7)
    assert 2 * (kernel.mix.sum(axis=1) @ kernel.poles).real == pytest.approx(1 / 16, rel=1e-9)
    np.testing.assert_allclose(kernel.mix, kernel.mix.T, atol=1e-12)
    assert np.cos(np.angle(kernel.poles) / 2).min() > 0.15
    assert kernel.poles.shape == flat.poles.shape and kernel.compact == flat.compact


def test_rim_kernel_of_zero_rim_is_flat_disc_kernel() -> None:
    assert all(rim_kernel(name, 0.0) is named_kernel(name) for name in RIM_NAMES)


@pytest.mark.parametrize("rim", [-1.0, -0.6, 0.8, 1.0])
@pytest.mark.parametrize("name", RIM_NAMES)
def test_rim_kernel_inverses_stay_small_for_any_diameters(
    name: str, rim: float, rng: np.random.Generator
) -> None:
    check_inverses(rim_kernel(name, rim), rng, trials=60)
