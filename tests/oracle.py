"""float64 answers that the GPU is compared with."""

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_banded

from heatlens.defocus.kernels import Kernel

Array = npt.NDArray[np.float64]


def conductances(diameter: Array) -> Array:
    """min(d, d')^2 between neighbours along the last axis: (..., n) to (..., n-1)."""
    return np.minimum(diameter[..., 1:], diameter[..., :-1]) ** 2


def solve_line(conductance: Array, kappa: complex, x: npt.NDArray[np.complex128]) -> Array:
    """(1 + kappa L)^-1 x along one line; x (n, channels)."""
    n = len(x)
    if n == 1:
        return x.astype(np.complex128)
    flow = kappa * np.concatenate([[0.0], conductance, [0.0]])
    bands = np.zeros((3, n), np.complex128)
    bands[0, 1:] = -flow[1:n]
    bands[1] = 1.0 + flow[:n] + flow[1 : n + 1]
    bands[2, : n - 1] = -flow[1:n]
    return solve_banded((1, 1), bands, x.astype(np.complex128))


def blur(x: Array, coc: Array, kernel: Kernel, scales: tuple[float, float] = (1.0, 1.0)) -> Array:
    """x (H, W, C) diffused by |coc| (H, W), rows then columns, in complex128."""
    for _ in range(kernel.steps):
        x = _blur_once(x, np.abs(coc), kernel, scales)
    return x


def _blur_once(x: Array, d: Array, kernel: Kernel, scales: tuple[float, float]) -> Array:
    by_row, by_column = conductances(d * scales[0]), conductances((d * scales[1]).T)
    rows = [
        np.stack([solve_line(b, kappa, line) for b, line in zip(by_row, x, strict=True)])
        for kappa in kernel.poles
    ]
    out = np.zeros(x.shape)
    for column_pole, kappa in enumerate(kernel.poles):
        mixed = sum(kernel.mix[a, column_pole] * row for a, row in enumerate(rows))
        for i, b in enumerate(by_column):
            out[:, i] += solve_line(b, kappa, mixed[:, i]).real
    return out
