"""Reference results in float64 for the heat blur, with which the GPU is compared."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_banded

from heatlens.render.defocus.kernels import Kernel

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]


def conductances(diameter: Array) -> Array:
    """Return min(d, d')^2 between neighbours along the last axis: (..., n) to (..., n-1)."""
    return np.minimum(diameter[..., 1:], diameter[..., :-1]) ** 2


def compact_weights(conductance: Array, kernel: Kernel) -> Array:
    """Return the weights c of the compact Laplacian between neighbors; they fade below 4 px."""
    part = np.minimum(conductance / 16.0, 1.0)
    return kernel.compact * part * (2.0 - part)


def laplacian(weights: Array, x: Array) -> Array:
    """Return L x along each line: weights (lines, n - 1), x (lines, n, channels)."""
    flow = weights[..., None] * np.diff(x, axis=1)
    zero = np.zeros((len(x), 1, x.shape[2]))
    return np.concatenate([zero, flow], axis=1) - np.concatenate([flow, zero], axis=1)


def repeated_heat(flow: Complex) -> Complex:
    """Return the effective heat capacity of a border pixel that is repeated infinitely often.

    `flow` is the conductance between two such pixels. One more pixel changes nothing, so that the
    heat h is f (1 + h) / (1 + f + h), or h^2 + h = f.
    """
    return (np.sqrt(1.0 + 4.0 * flow) - 1.0) / 2.0


@dataclass(frozen=True)
class Ends:
    """The pixels beyond both ends of each line.

    They have heat capacities (lines, 2) and values (lines, 2, channels).
    """

    heats: Complex
    values: Complex


def solve_lines(flow: Complex, x: Complex, ends: Ends | None = None) -> Complex:
    """Return (1 + L)^-1 x along each line with complex conductances flow (lines, n - 1).

    X is (lines, n, channels). The lines are one banded system, in which nothing flows from a line
    to the next.
    """
    lines, n, channels = x.shape
    heat, right_side = np.ones((lines, n), np.complex128), x.astype(np.complex128)
    if ends is not None:
        for i, end in enumerate((0, n - 1)):
            heat[:, end] += ends.heats[:, i]
            right_side[:, end] += ends.heats[:, i, None] * ends.values[:, i]
    from_previous = np.pad(flow, ((0, 0), (1, 0)))
    to_next = np.pad(flow, ((0, 0), (0, 1)))
    diagonal = (heat + from_previous + to_next).ravel()
    bands = np.stack([-from_previous.ravel(), diagonal, -to_next.ravel()])
    if lines * n == 1:
        return right_side / heat[..., None]
    solved = solve_banded((1, 1), bands, right_side.reshape(lines * n, channels))
    return solved.reshape(x.shape)


def blur(
    x: Array,
    coc: Array,
    kernel: Kernel,
    scales: tuple[float, float] = (1.0, 1.0),
    repeats_border: bool = True,
) -> Array:
    """Diffuse x (H, W, C) by |coc| (H, W), rows then columns, in complex128.

    If `repeats_border`, the border pixels are repeated beyond it, else there are none.
    """
    across, down = np.abs(coc) * scales[0], np.abs(coc.T) * scales[1]
    for _ in range(kernel.steps):
        x = _blur_once(x, across, down, kernel, repeats_border)
    return x


def _blur_once(x: Array, across: Array, down: Array, kernel: Kernel, repeats_border: bool) -> Array:
    rows = [_solve_lines(x, across, kappa, kernel, repeats_border) for kappa in kernel.poles]
    out = np.zeros(x.shape)
    for column_pole, kappa in enumerate(kernel.poles):
        mixed = sum(kernel.mix[a, column_pole] * row for a, row in enumerate(rows))
        solved = _solve_lines(mixed.swapaxes(0, 1), down, kappa, kernel, repeats_border)
        out += solved.swapaxes(0, 1).real
    return out


def _solve_lines(
    x: Complex, diameter: Array, kappa: complex, kernel: Kernel, repeats_border: bool
) -> Complex:
    """Return (1 + kappa d^2 L)^-1 of each row of x (H, W, C)."""
    if x.shape[1] == 1:  # one pixel, repeated without end: there is nothing to mix it with
        return x.astype(np.complex128)

    def flow(conductance: Array) -> Complex:
        return kappa * conductance - compact_weights(conductance, kernel)

    joined = conductances(diameter)
    heats = repeats_border * repeated_heat(flow(diameter[:, [0, -1]] ** 2))
    smoothed = x - laplacian(compact_weights(joined, kernel), x)
    return solve_lines(flow(joined), smoothed, Ends(heats, x[:, [0, -1]]))
