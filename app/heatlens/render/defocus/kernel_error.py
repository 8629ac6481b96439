"""Compute the error of a kernel against a disc, which `fit_kernels.py` minimizes. Needs SciPy.

A disc is approximated by a function of the line Laplacians that costs the same for every size,

    K = Re sum_ab M_ab (1 + kappa_a d^2 L_x)^-1 (1 + kappa_b d^2 L_y)^-1,

with J complex poles kappa and a complex symmetric matrix M. On a uniform plate L is the second
difference, whose Fourier transform is the squared frequency, so that for a disc of radius 1 (d = 2)
a factor has the transform f_a(u) = 1 / (1 + 4 kappa_a u^2), in radians a radius, and the disc has
2 J_1(q) / q at q^2 = u^2 + v^2. By Parseval the error of the kernel is an integral over frequency,

    E = integral w(q) (Re sum_ab M_ab f_a(u) f_b(v) - 2 J_1(q) / q)^2 du dv,   w = (q^2 + 0.3)^-p,

weighted as the spectra of images fall off (p = 1; 3/4 for five poles, which can follow finer
detail). Two properties are exact: light, Re sum M = 1, and variance, 2 Re sum_ab M_ab kappa_a =
1/16.

A disc with a bright or soft rim is fitted in the same way, at the size at which it has the variance
of the flat disc of diameter d. Its brightness is a polynomial in 1 - s^2, s from the middle to the
rim, and (m + 1) (1 - s^2)^m has the transform 2^(m+1) (m+1)! J_(m+1)(q) / q^(m+1).
"""

import math
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.special import jv

from heatlens.core.model.lens.opening import RIM_MOST, RIM_POWER, Blades, variance

Reals = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]

LIGHT, VARIANCE = 1.0, 1 / 16
IMAGE_SPECTRUM = 0.3  # the constant 0.3 in the weight w(q) of the error
_FREQUENCY_MOST, _RADII, _ANGLES = 60.0, 480, 12  # samples of the integral


class DiscError:
    """The error E of kernels against a disc, by quadrature over an eighth of the frequencies.

    By symmetry, an eighth of the directions stands for all of them.
    """

    def __init__(self, power: float = 1.0, rim: float = 0.0) -> None:
        """Set up the error with the `power` p of the weight, for a disc with a `rim`, -1 to 1."""
        radius, per_radius = _gauss_points(np.linspace(0, _FREQUENCY_MOST, _RADII // 8 + 1), 8)
        angle, per_angle = _gauss_points(np.array([0.0, np.pi / 4]), _ANGLES)
        weight = per_radius * radius * (radius**2 + IMAGE_SPECTRUM) ** -power
        self._across_2 = (np.outer(radius, np.cos(angle)) ** 2).ravel()
        self._down_2 = (np.outer(radius, np.sin(angle)) ** 2).ravel()
        self._weight = np.outer(weight, per_angle).ravel()
        # A disc with a rim has the size at which its variance is that of the flat disc.
        spread = np.sqrt(4 * variance(Blades(number=0, turn=0.0, curvature=0.0), rim))
        self._disc = np.repeat(spectrum(radius / spread, rim), _ANGLES)

    @cached_property
    def disc_norm(self) -> float:
        """E of a kernel that is zero: the norm of the disc itself."""
        return float(self._weight @ self._disc**2)

    def decibels(self, value: float, slopes: Reals) -> tuple[float, Reals]:
        """Return an error relative to the disc's norm in decibels, and its slopes.

        In decibels, a search converges equally well for good and poor kernels.
        """
        in_decibels = 10 * float(np.log10(value / self.disc_norm))
        return in_decibels, 10 / np.log(10) / value * slopes

    def evaluate(self, poles: Complexes, mix: Complexes) -> tuple[float, Complexes, Complexes]:
        """Return E, dE/dkappa (J,) and dE/dM (J, J) for the poles kappa and the mix M.

        E changes by the real part of the products of these slopes with changes of kappa and M.
        """
        across, down = self._factors(poles)
        mixed_across, mixed_down = mix @ across, mix @ down
        difference = np.sum(across * mixed_down, axis=0).real - self._disc
        weighted = self._weight * difference
        # Derivatives of the factors f_a along kappa_a.
        slope_across = -4 * self._across_2 * across**2
        slope_down = -4 * self._down_2 * down**2
        by_pole = 2 * (slope_across * mixed_down + slope_down * mixed_across) @ weighted
        by_mix = 2 * (across * weighted) @ down.T
        return float(weighted @ difference), by_pole, (by_mix + by_mix.T) / 2

    def best_mix(self, poles: Complexes) -> tuple[Complexes, Reals]:
        """Return the M (J, J) of least error with exact light and variance, for given `poles`.

        The second result are the Lagrange multipliers (2,) of light and variance.
        """
        # M is symmetric: the unknowns are the real and imaginary parts of M_ab with a <= b.
        pairs = [(a, b) for a in range(len(poles)) for b in range(a, len(poles))]
        across, down = self._factors(poles)
        columns, light, variance = [], [], []
        for a, b in pairs:
            factor = across[a] * down[b] if a == b else across[a] * down[b] + across[b] * down[a]
            moment = 2 * (poles[a] if a == b else poles[a] + poles[b])
            columns += [factor.real, -factor.imag]
            light += [1.0 if a == b else 2.0, 0.0]
            variance += [moment.real, -moment.imag]
        basis, constraints = np.array(columns), np.array([light, variance])
        weighted = basis * self._weight
        # The Lagrangian is stationary: least squares with two linear constraints.
        system = np.block(
            [[2 * weighted @ basis.T, constraints.T], [constraints, np.zeros((2, 2))]]
        )
        right_side = np.concatenate([2 * weighted @ self._disc, [LIGHT, VARIANCE]])
        solution = np.linalg.lstsq(system, right_side, rcond=1e-15)[0]
        mix = np.zeros((len(poles), len(poles)), np.complex128)
        for (a, b), real, imaginary in zip(pairs, solution[0:-2:2], solution[1:-2:2], strict=True):
            mix[a, b] = mix[b, a] = complex(real, imaginary)
        return mix, solution[-2:]

    def _factors(self, poles: Complexes) -> tuple[Complexes, Complexes]:
        """Return the factors f_a(u) and f_a(v) of each pole, each (J, frequencies)."""
        kappa = poles[:, None]
        return 1 / (1 + 4 * kappa * self._across_2), 1 / (1 + 4 * kappa * self._down_2)


def spectrum(frequency: Reals, rim: float) -> Reals:
    """Return the transform of a disc of radius 1 and light 1 with a bright or soft rim, -1 to 1."""
    rim_share = RIM_MOST * abs(rim)
    return (1 - rim_share) * _fading_spectrum(frequency, 0) + rim_share * _rim_spectrum(
        frequency, rim > 0
    )


def _rim_spectrum(frequency: Reals, is_bright: bool) -> Reals:
    """Return the transform of (p + 1) s^2p if bright, else (p + 1) (1 - s^2)^p; p = RIM_POWER."""
    if not is_bright:
        return _fading_spectrum(frequency, RIM_POWER)
    total = np.zeros_like(frequency)
    for m in range(RIM_POWER + 1):  # s^2p = (1 - (1 - s^2))^p
        total += (-1) ** m * math.comb(RIM_POWER, m) * _fading_spectrum(frequency, m) / (m + 1)
    return (RIM_POWER + 1) * total


def _fading_spectrum(frequency: Reals, power: int) -> Reals:
    """Return the transform of (m + 1) (1 - s^2)^m, m = `power`; for m = 0 it is 2 J_1(q) / q."""
    order = power + 1
    bessel = jv(order, frequency) / frequency**order
    return np.asarray(2.0**order * math.factorial(order) * bessel)


def _gauss_points(edges: Reals, count: int) -> tuple[Reals, Reals]:
    """Return points and weights of Gauss-Legendre quadrature, `count` in each interval of `edges`.

    Both results are flat, ascending.
    """
    points, weights = np.polynomial.legendre.leggauss(count)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (points + 1)).ravel(), (half * weights).ravel()
