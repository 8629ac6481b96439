"""float64 answers that the GPU is compared with."""

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_banded

from heatlens.defocus.kernels import Kernel

Array = npt.NDArray[np.float64]


def conductances(diameter: Array) -> Array:
    """Return min(d, d')^2 between neighbours along the last axis: (..., n) to (..., n-1)."""
    return np.minimum(diameter[..., 1:], diameter[..., :-1]) ** 2


def compact_weights(conductance: Array, kernel: Kernel) -> Array:
    """Return c of the compact Laplacian between neighbours; it fades with d^2 below 4 px."""
    return kernel.compact * np.minimum(conductance / 16.0, 1.0)


def laplacian(weights: Array, x: Array) -> Array:
    """Return L x along the first axis; weights (n - 1, ...)."""
    flow = weights[..., None] * np.diff(x, axis=0)
    zero = np.zeros((1, *flow.shape[1:]))
    return np.concatenate([zero, flow]) - np.concatenate([flow, zero])


def solve_line(flow: npt.NDArray[np.complex128], x: npt.NDArray[np.complex128]) -> Array:
    """Return (1 + L)^-1 x along one line with complex conductances flow (n - 1,).

    X (n, channels).
    """
    n = len(x)
    if n == 1:
        return x.astype(np.complex128)
    flow = np.concatenate([[0.0], flow, [0.0]])
    bands = np.zeros((3, n), np.complex128)
    bands[0, 1:] = -flow[1:n]
    bands[1] = 1.0 + flow[:n] + flow[1 : n + 1]
    bands[2, : n - 1] = -flow[1:n]
    return solve_banded((1, 1), bands, x.astype(np.complex128))


def blur(x: Array, coc: Array, kernel: Kernel, scales: tuple[float, float] = (1.0, 1.0)) -> Array:
    """Diffuse x (H, W, C) by |coc| (H, W), rows then columns, in complex128."""
    across, down = (conductances(d) for d in (np.abs(coc) * scales[0], (np.abs(coc) * scales[1]).T))
    weights = compact_weights(across.T, kernel), compact_weights(down.T, kernel)
    for _ in range(kernel.steps):
        x = x - laplacian(weights[0], x.swapaxes(0, 1)).swapaxes(0, 1)
        x = _blur_once(x, across, down, weights[1], kernel)
    return x


def _blur_once(x: Array, across: Array, down: Array, compact_down: Array, kernel: Kernel) -> Array:
    def flows(conductance: Array, kappa: complex) -> npt.NDArray[np.complex128]:
        return kappa * conductance - compact_weights(conductance, kernel)

    rows = [
        np.stack(
            [solve_line(flow, line) for flow, line in zip(flows(across, kappa), x, strict=True)]
        )
        for kappa in kernel.poles
    ]
    out = np.zeros(x.shape)
    for column_pole, kappa in enumerate(kernel.poles):
        mixed = sum(kernel.mix[a, column_pole] * row for a, row in enumerate(rows))
        mixed = mixed - laplacian(compact_down, mixed)
        for i, flow in enumerate(flows(down, kappa)):
            out[:, i] += solve_line(flow, mixed[:, i]).real
    return out
