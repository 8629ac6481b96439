"""Compare the line solvers with a blur in float64.

A solver is right if the blur of a small random picture equals the same blur by dense matrices.
"""

import numpy as np
from numpy.typing import NDArray

from heatlens.render.defocus.blur_pass import BlurPass, BlurTargets, Diffusion, pole_layers
from heatlens.render.defocus.kernels import Kernel, named_kernel
from heatlens.render.defocus.line_solver import LineSolver
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download, new_array, new_texture, upload

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
KERNELS = ("heat", "disc_2", "disc_4")
TOLERANCE = 2e-5  # for colors in 0..1, solved in float32
_SIZE = (96, 64)
_COC_MAX_PX = 40.0
_COMPACT_FULL_PX = 4.0  # diameter from which the Laplacian is fully compact


def worst_error(ctx: Device, solver: LineSolver, kernel_name: str) -> float:
    """Return the largest difference between GPU and float64, in colors of 0..1."""
    rng = np.random.default_rng(20060106)
    width, height = _SIZE
    color = rng.random((height, width, 4), np.float32)
    coc = (_COC_MAX_PX * rng.random((height, width)) ** 4).astype(np.float32)
    coc[rng.random((height, width)) < 0.3] = _COC_MAX_PX  # flat parts, and pixels in focus
    coc[rng.random((height, width)) < 0.05] = 0.0
    kernel = named_kernel(kernel_name)
    expected = blur_in_float64(color.astype(np.float64), coc.astype(np.float64), kernel)
    return float(np.abs(_blur_on_gpu(ctx, solver, color, coc, kernel) - expected).max())


def _blur_on_gpu(
    ctx: Device, solver: LineSolver, color: FloatArray, coc: FloatArray, kernel: Kernel
) -> FloatArray:
    """Return the blur of `color` (H, W, 4) with `coc` (H, W), computed on the GPU by `solver`."""
    color_tx, coc_tx, blurred_tx = (new_texture(ctx, _SIZE, count) for count in (4, 1, 4))
    poles = new_array(ctx, solver.size_between_axes(_SIZE), pole_layers(kernel, "f4"), 4)
    upload(color_tx, color)
    upload(coc_tx, coc)
    diffusion = Diffusion(color=color_tx, coc=coc_tx, kernel=kernel, axis_scales=(1.0, 1.0))
    BlurPass(solver).run(diffusion, BlurTargets(poles, blurred_tx))
    result = download(blurred_tx)
    for texture in (color_tx, coc_tx, blurred_tx, poles):
        texture.release()
    return result


def blur_in_float64(color: Array, coc: Array, kernel: Kernel) -> Array:
    """Compute the result of `BlurPass` for `color` (H, W, C) and `coc` (H, W) by dense matrices."""
    solved_rows = [_solve_lines(coc, kernel, kappa, color) for kappa in kernel.poles]
    blurred = np.zeros(color.shape)
    for column_pole, kappa in enumerate(kernel.poles):
        mixed = np.asarray(
            sum(
                kernel.mix[row_pole, column_pole] * solved
                for row_pole, solved in enumerate(solved_rows)
            )
        )
        blurred += _solve_lines(coc.T, kernel, kappa, mixed.swapaxes(0, 1)).real.swapaxes(0, 1)
    return blurred


def _solve_lines(coc: Array, kernel: Kernel, kappa: complex, color: Array | Complex) -> Complex:
    """Return (1 + kappa d^2 L)^-1 x along each line of `coc` (lines, n), L compact.

    `color` is x, (lines, n, channels); its end pixels continue beyond the line.
    """
    conductance = np.minimum(coc[:, 1:], coc[:, :-1]) ** 2
    compact = _laplacian(_compactness(conductance, kernel))
    system = np.eye(coc.shape[-1]) + (kappa + 0j) * _laplacian(conductance) - compact
    right_side = color.astype(np.complex128) - np.einsum("lij,ljc->lic", compact, color)
    for end in (0, -1):
        border = coc[:, end] ** 2
        flow = kappa * border - _compactness(border, kernel)
        # The line continues forever beyond its end, with the same blur. These infinitely many
        # pixels act on the last pixel as one conductance h, the root of h^2 + h = flow.
        border_conductance = (np.sqrt(1.0 + 4.0 * flow + 0j) - 1.0) / 2.0
        system[:, end, end] += border_conductance
        right_side[:, end] = right_side[:, end] + border_conductance[:, None] * color[:, end]
    return np.asarray(np.linalg.solve(system, right_side), np.complex128)


def _compactness(conductance: Array, kernel: Kernel) -> Array:
    """Return the weight of the compact Laplacian between two pixels, 0 to the kernel's maximum."""
    fraction = np.minimum(conductance / _COMPACT_FULL_PX**2, 1.0)
    return np.asarray(kernel.compact * fraction * (2.0 - fraction))


def _laplacian(conductance: Array) -> Array:
    """Return the Laplacian matrices (lines, n, n) of conductances (lines, n - 1)."""
    lines, links = conductance.shape
    matrix = np.zeros((lines, links + 1, links + 1))
    pixels = np.arange(links)
    matrix[:, pixels, pixels] += conductance
    matrix[:, pixels + 1, pixels + 1] += conductance
    matrix[:, pixels, pixels + 1] -= conductance
    matrix[:, pixels + 1, pixels] -= conductance
    return matrix
