"""Fit the kernels of `disc_kernels.json`: `python -m heatlens.render.defocus.fit_kernels --help`.

Not used when pictures are rendered. It needs SciPy, which the extra `fit` installs.

`kernel_error.py` has the error that is minimized, and its mathematics. Given the poles, the mix M
solves linear equations, so that only the poles are searched: variable projection, after G. H. Golub
and V. Pereyra, SIAM J. Numer. Anal. 10 (1973). The derivative along the poles follows from the
Lagrangian at the solution. Poles are varied as log kappa, whose imaginary part phi is bounded:
cos(phi / 2) >= 0.16 keeps elimination without pivoting stable.

The stored kernels were found with the same weight, but how its integral was sampled is not
recorded: the stored poles of disc_2 are within 2 % of the minimum that is found here, and their
error within 0.03 %. With more poles the minimum is flatter, and a search from the stored poles ends
at a lower error.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from heatlens.render.defocus.kernel_error import LIGHT, VARIANCE, Complexes, DiscError, Reals
from heatlens.render.defocus.kernels import RIMS, named_kernel

COS_LEAST = 0.16  # smallest cosine of half the argument of a pole
PHASE_MOST = 2 * np.arccos(COS_LEAST)  # largest argument of a pole, radians
# Power p in the weight of the error (`kernel_error.py`), by the name of the kernel.
POWERS = {"disc_2": 1.0, "disc_3": 1.0, "disc_4": 1.0, "disc_5": 0.75}
_SIZES = float(np.log(3e-4)), float(np.log(0.1))  # log range of the poles at which a search starts


@dataclass(frozen=True, eq=False)
class Fit:
    """A kernel of J poles: poles (J,), mixing weights M (J, J), and its error E."""

    poles: Complexes
    mix: Complexes
    error: float


# Each search begins at the poles of the previous rim, from the flat disc outwards. The poles of
# neighboring rims correspond then, and `rim_kernel` can mix them one by one. Searches from random
# poles give them no common order.
def fit_rims(name: str) -> list[Fit]:
    """Return a kernel for each of `RIMS`, with as many poles as the stored flat disc `name`."""
    power, fits = POWERS[name], {}
    for sign in (1.0, -1.0):
        poles = named_kernel(name).poles
        for rim in sorted((r for r in RIMS if r * sign >= 0), key=abs):
            error = DiscError(power, rim)
            if rim > RIMS[0]:  # the last rim of this side keeps the poles of the one before
                poles = refine_poles(error, poles).poles
            mix, _ = error.best_mix(poles)
            fits[rim] = Fit(poles, mix, error.evaluate(poles, mix)[0])
    return [fits[rim] for rim in RIMS]


def fit_disc(count: int, power: float = 1.0, starts: int = 12, seed: int = 1) -> Fit:
    """Return the best kernel of `count` poles that `starts` searches from random poles find.

    `power` is that of `DiscError`, and `seed` that of the random poles.
    """
    error, random = DiscError(power), np.random.default_rng(seed)
    fits = []
    for _ in range(starts):
        size = random.uniform(_SIZES[0], _SIZES[1], count)
        phase = random.uniform(-PHASE_MOST, PHASE_MOST, count)
        fits.append(refine_poles(error, np.exp(size + 1j * phase)))
    return min(fits, key=lambda fit: fit.error)


def refine_poles(error: DiscError, poles: Complexes) -> Fit:
    """Return the kernel of least error that a search downhill from `poles` finds."""
    count = len(poles)

    def error_of(point: Reals) -> tuple[float, Reals]:
        """Return the error in decibels at a point of the search, and its gradient."""
        poles_here = _poles_at(point, count)
        mix, multipliers = error.best_mix(poles_here)
        value, by_pole, _ = error.evaluate(poles_here, mix)
        # The slope of the Lagrangian; light does not depend on the poles, so only the second
        # constraint, the variance, adds to it.
        by_log = (by_pole + multipliers[1] * _moment_by_pole(mix)) * poles_here
        return error.decibels(value, _real_slopes(by_log))

    options = {"maxiter": 2000, "ftol": 1e-13, "gtol": 1e-9}
    result = minimize(
        error_of,
        _to_point(poles),
        jac=True,
        method="L-BFGS-B",
        bounds=_bounds(count),
        options=options,
    )
    poles = _poles_at(result.x, count)
    mix, _ = error.best_mix(poles)
    return Fit(poles, mix, error.evaluate(poles, mix)[0])


# An M of rank K below the number of poles would need only K images between rows and columns, which
# are most of the memory that a blur moves. The stored kernels have full rank, although the last
# singular value of disc_4 is .002, where the first is 1.3.
def fit_of_rank(error: DiscError, start_fit: Fit, rank: int) -> Fit:
    """Return the kernel of least error near `start_fit` whose M is V V^T, V (J, `rank`)."""
    search = _RankSearch(error, len(start_fit.poles), rank)
    images = images_of(start_fit.mix)[:, :rank]
    result = minimize(
        search.error_of,
        np.concatenate([_to_point(start_fit.poles), _real_slopes(images.conj())]),
        jac=True,
        method="SLSQP",
        bounds=_bounds(len(start_fit.poles)) + [(None, None)] * (2 * images.size),
        constraints={"type": "eq", "fun": search.excess, "jac": search.excess_slopes},
        options={"maxiter": 3000, "ftol": 1e-12},
    )
    poles, images = search.poles_and_images(result.x)
    mix = images @ images.T
    return Fit(poles, mix, error.evaluate(poles, mix)[0])


@dataclass(frozen=True, eq=False)
class _RankSearch:
    """The error and the exact constraints at a point of a search, with their gradients.

    A point holds log poles, then the real and the imaginary parts of V (J, rank), M = V V^T.

    count  the number of poles, J
    rank   the number of columns of V
    """

    error: DiscError
    count: int
    rank: int

    def poles_and_images(self, point: Reals) -> tuple[Complexes, Complexes]:
        """Return the poles (J,) and V (J, rank) of a point."""
        real, imaginary = np.split(point[2 * self.count :], 2)
        images = (real + 1j * imaginary).reshape(self.count, self.rank)
        return _poles_at(point, self.count), images

    def error_of(self, point: Reals) -> tuple[float, Reals]:
        """Return the error in decibels and its slopes."""
        poles, images = self.poles_and_images(point)
        value, by_pole, by_mix = self.error.evaluate(poles, images @ images.T)
        return self.error.decibels(value, _slopes(poles, images, by_pole, by_mix))

    def excess(self, point: Reals) -> Reals:
        """Return the relative excess of light and variance (2,)."""
        poles, images = self.poles_and_images(point)
        mix = images @ images.T
        return np.array([mix.sum().real / LIGHT, _moment(poles, mix) / VARIANCE]) - 1

    def excess_slopes(self, point: Reals) -> Reals:
        """Return the slopes of `excess` along the point (2, length of the point)."""
        poles, images = self.poles_and_images(point)
        each = np.ones((self.count, self.count), np.complex128)
        light = _slopes(poles, images, 0 * poles, each)
        by_pole = _moment_by_pole(images @ images.T)
        moment = _slopes(poles, images, by_pole, 2 * poles[:, None] * each)
        return np.array([light / LIGHT, moment / VARIANCE])


def _slopes(poles: Complexes, images: Complexes, by_pole: Complexes, by_mix: Complexes) -> Reals:
    """Convert gradients along the poles and M = V V^T to gradients along log poles and V.

    `images` is V (J, rank). The result has the layout of a point of `_RankSearch`.
    """
    return np.concatenate(
        [_real_slopes(by_pole * poles), _real_slopes((by_mix + by_mix.T) @ images)]
    )


def _real_slopes(slopes: Complexes) -> Reals:
    """Return slopes along real and imaginary parts from complex ones, as `evaluate` gives them."""
    return np.concatenate([slopes.real.ravel(), -slopes.imag.ravel()])


def _to_point(poles: Complexes) -> Reals:
    """Return the point (2 J,) of a search at `poles`: real, then imaginary parts of log kappa."""
    logs = np.log(poles)
    return np.concatenate([logs.real, logs.imag])


def _poles_at(point: Reals, count: int) -> Complexes:
    """Return the `count` poles at a point of a search."""
    poles: Complexes = np.exp(point[:count] + 1j * point[count : 2 * count])
    return poles


def _bounds(count: int) -> list[tuple[float | None, float | None]]:
    """Return the limits of the real and then of the imaginary parts of `count` log poles."""
    return [(-12.0, 0.0)] * count + [(-PHASE_MOST, PHASE_MOST)] * count


def _moment(poles: Complexes, mix: Complexes) -> float:
    """Return the variance along an axis of a kernel for a disc of diameter 1."""
    return float(2 * (mix.sum(axis=1) @ poles).real)


def _moment_by_pole(mix: Complexes) -> Complexes:
    """Return the slopes (J,) of `_moment` along the poles."""
    slopes: Complexes = 2 * mix.sum(axis=1)
    return slopes


def images_of(mix: Complexes) -> Complexes:
    """Return V (J, J) with M = V V^T, the columns with the largest share first.

    This is the Takagi factorization of the symmetric matrix M.
    """
    left, share, right = np.linalg.svd(mix)
    phase = np.sqrt(np.diagonal(left.conj().T @ right.T))
    images: Complexes = left * phase * np.sqrt(share)
    return images


def entry_of(fit: Fit) -> dict[str, object]:
    """Return a kernel as an entry of the JSON file."""
    moment = _moment(fit.poles, fit.mix)
    return {
        "kappa": [_rounded_pair(pole) for pole in fit.poles],
        "M": [[_rounded_pair(weight) for weight in row] for row in fit.mix],
        "variance_over_disc": round(moment / VARIANCE, 6),
    }


def _rounded_pair(value: complex) -> list[float]:
    """Return the real and imaginary part, rounded to 9 digits."""
    return [float(f"{value.real:.9g}"), float(f"{value.imag:.9g}")]


def main(words: Sequence[str] | None = None) -> int:
    """Fit the requested kernels and print how they compare with the stored ones."""
    parser = argparse.ArgumentParser(
        prog="python -m heatlens.render.defocus.fit_kernels",
        description="Fit sums of exponentials to a disc: the kernels that heatlens blurs with.",
    )
    parser.add_argument("names", nargs="*", default=[*POWERS], help="disc_2 to disc_5, or all")
    parser.add_argument("--starts", type=int, default=12, help="searches from random poles")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random poles")
    parser.add_argument("--from-stored", action="store_true", help="search from the stored poles")
    parser.add_argument(
        "--rank", type=int, help="images that the row pass hands to the column pass, at most"
    )
    parser.add_argument("--rims", action="store_true", help="fit discs with bright and soft rims")
    parser.add_argument("-o", "--output", type=Path, help="write the kernels to this JSON file")
    args = parser.parse_args(words)
    if args.rims:
        _fit_and_print_rims(args.names, args.output)
        return 0
    entries = {name: entry_of(_fit_and_print(name, args)) for name in args.names}
    if args.output is not None:
        args.output.write_text(json.dumps({"kernels": entries}, indent=1) + "\n", encoding="utf-8")
    return 0


def _fit_and_print_rims(names: Sequence[str], output: Path | None) -> None:
    """Print how well discs with a rim are matched, and write them, one kernel on each line."""
    lines = []
    for name in names:
        for rim, fit in zip(RIMS, fit_rims(name), strict=True):
            power = POWERS[name]
            flat = named_kernel(name)
            error = DiscError(power, rim)
            fit_error, flat_error = fit.error, error.evaluate(flat.poles, flat.mix)[0]
            errors = f"error {fit_error / error.disc_norm:.2e} of the disc's norm"
            errors += f", flat {flat_error / error.disc_norm:.2e}"
            sys.stdout.write(f"{name} rim {rim:g}: {errors}\n")
            lines.append(json.dumps({"name": name, "rim": rim} | entry_of(fit)))
    if output is not None:
        output.write_text('{"kernels": [\n' + ",\n".join(lines) + "\n]}\n", encoding="utf-8")


def _fit_and_print(name: str, args: argparse.Namespace) -> Fit:
    """Fit one kernel by the options of the command, and print its error."""
    power, stored = POWERS[name], named_kernel(name)
    error = DiscError(power)
    if args.from_stored:
        fit = refine_poles(error, stored.poles)
    else:
        fit = fit_disc(len(stored.poles), power, args.starts, args.seed)
    if args.rank is not None:
        fit = fit_of_rank(error, fit, args.rank)
    stored_share = error.evaluate(stored.poles, stored.mix)[0] / error.disc_norm
    images = np.linalg.matrix_rank(fit.mix, tol=1e-9)
    error_share = fit.error / error.disc_norm
    summary = f"{len(fit.poles)} poles, {images} images, error {error_share:.4e} of the disc's norm"
    sys.stdout.write(f"{name}: {summary}; stored {stored_share:.4e}\n")
    return fit


if __name__ == "__main__":
    sys.exit(main())
