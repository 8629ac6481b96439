"""Compare the blur of a small random picture on the GPU with the same blur in float64."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from heatlens.defocus.blur_pass import BlurPass, BlurTargets, Diffusion, pole_layers
from heatlens.defocus.kernels import Kernel, named_kernel
from heatlens.defocus.line_solver import LineSolver
from heatlens.gpu.textures import FloatArray, download, new_array, new_texture, upload

Array = NDArray[np.float64]

KERNELS = ("heat", "disc_2", "disc_4")
TOLERANCE = 2e-5  # of colours in 0..1, solved in float32
_SIZE = (96, 64)
_COC_MAX_PX = 40.0
_COMPACT_FULL_PX = 4.0  # from this diameter on the Laplacian is compact in full


def worst_error(ctx: moderngl.Context, solver: LineSolver, kernel_name: str) -> float:
    """Return the largest difference between GPU and float64, in colours of 0..1."""
    rng = np.random.default_rng(20060106)
    width, height = _SIZE
    color = rng.random((height, width, 4), np.float32)
    coc = (_COC_MAX_PX * rng.random((height, width)) ** 4).astype(np.float32)
    coc[rng.random((height, width)) < 0.3] = _COC_MAX_PX  # flat parts, and pixels in focus
    coc[rng.random((height, width)) < 0.05] = 0.0
    kernel = named_kernel(kernel_name)
    expected = blurred_float64(color.astype(np.float64), coc.astype(np.float64), kernel)
    return float(np.abs(_blurred(ctx, solver, color, coc, kernel) - expected).max())


def _blurred(
    ctx: moderngl.Context, solver: LineSolver, color: FloatArray, coc: FloatArray, kernel: Kernel
) -> FloatArray:
    color_tx, coc_tx, out = (new_texture(ctx, _SIZE, count) for count in (4, 1, 4))
    poles = new_array(ctx, solver.between_size(_SIZE), pole_layers(kernel, "f4"), 4)
    upload(color_tx, color)
    upload(coc_tx, coc)
    what = Diffusion(color_tx, coc_tx, kernel, (1.0, 1.0))
    BlurPass(solver).run(what, BlurTargets(poles, out))
    result = download(out)
    for texture in (color_tx, coc_tx, out, poles):
        texture.release()
    return result


def blurred_float64(color: Array, coc: Array, kernel: Kernel) -> Array:
    """Compute the result of `BlurPass` for `color` (H, W, C) and `coc` (H, W) by dense matrices."""
    across, compact_across = _laplacians(coc, kernel)
    down, compact_down = _laplacians(coc.T, kernel)
    source = color - np.einsum("yxw,ywc->yxc", compact_across, color)
    rows = [_solved(across, compact_across, kappa, source) for kappa in kernel.poles]
    out = np.zeros(color.shape)
    for b, kappa in enumerate(kernel.poles):
        mixed = sum(kernel.mix[a, b] * row for a, row in enumerate(rows))
        columns = np.swapaxes(np.asarray(mixed), 0, 1)
        columns = columns - np.einsum("xyw,xwc->xyc", compact_down, columns)
        out += _solved(down, compact_down, kappa, columns).real.swapaxes(0, 1)
    return out


def _laplacians(coc: Array, kernel: Kernel) -> tuple[Array, Array]:
    """Return Laplacian and compact matrix (lines, n, n) of each line of `coc` (lines, n)."""
    conductance = np.minimum(coc[:, 1:], coc[:, :-1]) ** 2
    compact = kernel.compact * np.minimum(conductance / _COMPACT_FULL_PX**2, 1.0)
    return _laplacian(conductance), _laplacian(compact)


def _laplacian(conductance: Array) -> Array:
    """Return the Laplacian matrices (lines, n, n) of conductances (lines, n - 1)."""
    lines, links = conductance.shape
    matrix = np.zeros((lines, links + 1, links + 1))
    at = np.arange(links)
    matrix[:, at, at] += conductance
    matrix[:, at + 1, at + 1] += conductance
    matrix[:, at, at + 1] -= conductance
    matrix[:, at + 1, at] -= conductance
    return matrix


def _solved(laplacian: Array, compact: Array, kappa: complex, x: Array) -> NDArray[np.complex128]:
    """Return (1 + kappa L - C)^-1 x along each line; x is (lines, n, channels)."""
    system = np.eye(laplacian.shape[-1]) + kappa * laplacian - compact
    return np.asarray(np.linalg.solve(system, x.astype(np.complex128)), np.complex128)
