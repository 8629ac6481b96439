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
    """Return L x along the first axis; weights (n - 1, ...)."""
    flow = weights[..., None] * np.diff(x, axis=0)
    zero = np.zeros((1, *flow.shape[1:]))
    return np.concatenate([zero, flow]) - np.concatenate([flow, zero])


def repeated_heat(flow: Complex) -> Complex:
    """Return the effective heat capacity of a border pixel that is repeated infinitely often.

    `flow` is the conductance between two such pixels; pixels are added until nothing changes.
    """
    heat = np.zeros_like(flow)
    for _ in range(100_000):
        previous_heat, heat = heat, flow * (1.0 + heat) / (1.0 + flow + heat)
        if np.all(np.abs(heat - previous_heat) <= 1e-13 * np.abs(heat)):
            break
    return heat


@dataclass(frozen=True)
class Ends:
    """The pixels beyond the two ends of a line: heat capacities (2,) and values (2, channels)."""

    heats: Complex
    values: Complex


def solve_line(flow: Complex, x: Complex, ends: Ends | None = None) -> Complex:
    """Return (1 + L)^-1 x along one line with complex conductances flow (n - 1,).

    X (n, channels).
    """
    n = len(x)
    heat, right_side = np.ones(n, np.complex128), x.astype(np.complex128)
    if ends is not None:
        for i, extra_heat, value in zip((0, n - 1), ends.heats, ends.values, strict=True):
            heat[i] += extra_heat
            right_side[i] += extra_heat * value
    if n == 1:
        return right_side / heat[:, None]
    flow = np.concatenate([[0.0], flow, [0.0]])
    bands = np.zeros((3, n), np.complex128)
    bands[0, 1:] = -flow[1:n]
    bands[1] = heat + flow[:n] + flow[1 : n + 1]
    bands[2, : n - 1] = -flow[1:n]
    return solve_banded((1, 1), bands, right_side)


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
    smoothed = [
        line - laplacian(weights, line)
        for line, weights in zip(x, compact_weights(joined, kernel), strict=True)
    ]
    return np.stack(
        [
            solve_line(flows, line, Ends(heat, raw[[0, -1]]))
            for flows, line, heat, raw in zip(flow(joined), smoothed, heats, x, strict=True)
        ]
    )
