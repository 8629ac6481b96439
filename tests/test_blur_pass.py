"""The diffusion on the GPU against float64, and the laws of method: every strategy, every kernel."""

import moderngl
import numpy as np
import oracle
import pytest

from heatlens.defocus.blur_pass import BlurPass, BlurTargets, pole_layers
from heatlens.defocus.kernels import Kernel, gaussian_kernel, named_kernel
from heatlens.defocus.line_solver import SOLVERS, LineSolver
from heatlens.gpu.textures import download, new_array, new_texture, upload

KERNELS = ["heat", "disc_2", "disc_3", "disc_4", "disc_5"]
SIZES = [(1, 1), (1, 7), (2, 3), (3, 2), (7, 5), (64, 9), (300, 6), (1920, 2), (2, 1080), (4096, 1)]


@pytest.fixture(scope="module", params=list(SOLVERS))
def solver(request: pytest.FixtureRequest, session_context: moderngl.Context) -> LineSolver:
    return SOLVERS[request.param](session_context)


def blurred(
    solver: LineSolver,
    x: np.ndarray,
    coc: np.ndarray,
    kernel: Kernel,
    scales: tuple[float, float] = (1.0, 1.0),
) -> np.ndarray:
    ctx = solver._ctx
    height, width = coc.shape
    color, diameter = new_texture(ctx, (width, height), 4), new_texture(ctx, (width, height), 1)
    upload(color, x)
    upload(diameter, coc)
    targets = BlurTargets(
        new_array(ctx, (width, height), pole_layers(kernel), 4),
        new_texture(ctx, (width, height), 4),
    )
    BlurPass(solver).run(color, diameter, kernel, scales, targets)
    result = download(targets.out_color)
    for texture in (color, diameter, targets.poles, targets.out_color):
        texture.release()
    return result


def random_plate(
    rng: np.random.Generator, size: tuple[int, int], coc_max: float
) -> tuple[np.ndarray, np.ndarray]:
    """Colours in 0..1 and a circle of confusion with flat parts, ramps, jumps and points in focus."""
    width, height = size
    x = rng.random((height, width, 4), np.float32)
    coc = coc_max * rng.random((height, width), np.float32) ** 4
    coc[rng.random((height, width)) < 0.4] = coc_max
    coc[rng.random((height, width)) < 0.02] = 0.0
    return x, np.copysign(coc, rng.standard_normal((height, width))).astype(np.float32)


@pytest.mark.parametrize("size", SIZES, ids=lambda s: f"{s[0]}x{s[1]}")
@pytest.mark.parametrize("name", KERNELS)
def test_agrees_with_float64(
    ctx: moderngl.Context, solver: LineSolver, rng: np.random.Generator, name: str, size
) -> None:
    x, coc = random_plate(rng, size, 60.0)
    kernel = named_kernel(name)
    expected = oracle.blur(x.astype(np.float64), coc.astype(np.float64), kernel)
    np.testing.assert_allclose(blurred(solver, x, coc, kernel), expected, atol=1e-5)


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("axis", ["rows", "columns"])
def test_wide_blur_on_long_lines_agrees_with_float64(
    ctx: moderngl.Context, solver: LineSolver, rng: np.random.Generator, name: str, axis: str
) -> None:
    size = (16384, 1) if axis == "rows" else (1, 16384)
    x, coc = random_plate(rng, size, 2000.0)
    kernel = named_kernel(name)
    expected = oracle.blur(x.astype(np.float64), coc.astype(np.float64), kernel)
    np.testing.assert_allclose(blurred(solver, x, coc, kernel), expected, atol=1e-5)
