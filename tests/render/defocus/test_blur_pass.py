"""The diffusion on the GPU against float64, and its laws: every strategy, every kernel."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.render.defocus.blur_pass import (
    PACKED,
    BlurPass,
    BlurTargets,
    Diffusion,
    Over,
    pole_layers,
)
from heatlens.render.defocus.kernels import Kernel, gaussian_kernel, named_kernel
from heatlens.render.defocus.line_solver import SOLVERS, LineSolver
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import Storage, download, new_array, new_texture, upload
from support import oracle

KERNELS = ["heat", "disc_2", "disc_3", "disc_4", "disc_5"]
FEW_SIZES = [(1, 1), (7, 5), (300, 6)]
SIZES = [*FEW_SIZES, (1, 7), (2, 3), (3, 2), (64, 9), (1920, 2), (2, 1080), (4096, 1)]
# Every size with an even and an odd number of poles: nothing else in a kernel depends on the size.
CASES = [(name, size) for name in ("disc_3", "disc_4") for size in SIZES]
CASES += [
    (name, size) for name in KERNELS if name not in ("disc_3", "disc_4") for size in FEW_SIZES
]


@pytest.fixture(scope="module", params=list(SOLVERS))
def solver(request: pytest.FixtureRequest, session_context: Device) -> LineSolver:
    return SOLVERS[request.param](session_context)


def run_blur(
    solver: LineSolver,
    x: np.ndarray,
    coc: np.ndarray,
    kernel: Kernel,
    scales: tuple[float, float] = (1.0, 1.0),
    storage: Storage = "f4",
    behind: np.ndarray | None = None,
    is_farthest: bool = False,
    corner: tuple[int, int] | None = None,
) -> np.ndarray:
    """Return the blurred picture, or `behind` with the blurred picture over it."""
    ctx = solver._ctx
    height, width = coc.shape
    color, diameter = new_texture(ctx, (width, height), 4), new_texture(ctx, (width, height), 1)
    upload(color, x)
    upload(diameter, coc)
    targets = BlurTargets(
        new_array(
            ctx, solver.size_between_axes((width, height)), pole_layers(kernel, storage), 4, storage
        ),
        new_texture(ctx, (width, height), 4),
    )
    out = targets.out_color
    if behind is not None:
        out = new_texture(ctx, (width, height), 4)
        upload(out, behind)
        targets = replace(targets, over=Over(out, is_farthest))
    BlurPass(solver).run(Diffusion(color, diameter, kernel, scales, corner=corner), targets)
    result = download(out)
    for texture in {color, diameter, targets.poles, targets.out_color, out}:
        texture.release()
    return result


def random_plate(
    rng: np.random.Generator, size: tuple[int, int], coc_max: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return colours in 0..1; a coc with flat parts, ramps, jumps and points in focus."""
    width, height = size
    x = rng.random((height, width, 4), np.float32)
    coc = coc_max * rng.random((height, width), np.float32) ** 4
    coc[rng.random((height, width)) < 0.4] = coc_max
    coc[rng.random((height, width)) < 0.02] = 0.0
    return x, np.copysign(coc, rng.standard_normal((height, width))).astype(np.float32)


def test_blur_of_picture_in_texture_corner_ignores_the_rest(solver, rng):
    x, coc = random_plate(rng, (70, 21), 9.0)
    alone = run_blur(solver, x, coc, named_kernel("disc_4"), storage=PACKED)
    margins = ((0, 7), (0, 5))
    x = np.pad(x, (*margins, (0, 0)), constant_values=np.nan)
    coc = np.pad(coc, margins, constant_values=np.nan)
    with_rest = run_blur(solver, x, coc, named_kernel("disc_4"), storage=PACKED, corner=(70, 21))
    np.testing.assert_array_equal(with_rest[:21, :70], alone)


@pytest.mark.parametrize("kernel", [named_kernel("disc_4"), gaussian_kernel(3)], ids=str)
def test_blur_layer_is_composited_by_its_coverage(solver, rng, kernel):
    x, coc = random_plate(rng, (40, 21), 9.0)
    behind = rng.random((21, 40, 4), np.float32)
    layer = run_blur(solver, x, coc, kernel)
    cover = layer[..., 3:]
    expected = np.maximum(layer[..., :3] + (1 - cover) * behind[..., :3], 0)
    over = run_blur(solver, x, coc, kernel, behind=behind)
    np.testing.assert_allclose(over[..., :3], expected, atol=1e-6)
    farthest = run_blur(solver, x, coc, kernel, behind=behind, is_farthest=True)
    np.testing.assert_allclose(farthest[..., :3], np.maximum(layer[..., :3] / cover, 0), rtol=1e-5)
    assert (over[..., 3] == 1).all() and (farthest[..., 3] == 1).all()


@pytest.mark.parametrize(("name", "size"), CASES, ids=str)
def test_blur_agrees_with_float64(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str, size
) -> None:
    x, coc = random_plate(rng, size, 60.0)
    kernel = named_kernel(name)
    expected = oracle.blur(x.astype(np.float64), coc.astype(np.float64), kernel)
    np.testing.assert_allclose(run_blur(solver, x, coc, kernel), expected, atol=1e-5)


# One real pole, an even number of poles, and the most: rounding errors grow with them.
@pytest.mark.parametrize("name", ["heat", "disc_4", "disc_5"])
@pytest.mark.parametrize("axis", ["rows", "columns"])
def test_wide_blur_on_long_lines_agrees_with_float64(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str, axis: str
) -> None:
    size = (16384, 1) if axis == "rows" else (1, 16384)
    x, coc = random_plate(rng, size, 2000.0)
    kernel = named_kernel(name)
    expected = oracle.blur(x.astype(np.float64), coc.astype(np.float64), kernel)
    np.testing.assert_allclose(run_blur(solver, x, coc, kernel), expected, atol=1e-5)


@pytest.mark.parametrize("name", KERNELS)
def test_squeeze_scales_each_axis(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str
) -> None:
    x, coc = random_plate(rng, (40, 30), 20.0)
    scales = (0.5, 1.25)
    expected = oracle.blur(x.astype(np.float64), coc.astype(np.float64), named_kernel(name), scales)
    result = run_blur(solver, x, coc, named_kernel(name), scales)
    np.testing.assert_allclose(result, expected, atol=1e-5)


@pytest.mark.parametrize("steps", [1, 2, 5])
def test_gaussian_steps_agree_with_float64(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, steps: int
) -> None:
    x, coc = random_plate(rng, (33, 21), 30.0)
    kernel = gaussian_kernel(steps)
    expected = oracle.blur(x.astype(np.float64), coc.astype(np.float64), kernel)
    np.testing.assert_allclose(run_blur(solver, x, coc, kernel), expected, atol=1e-5)


@pytest.mark.parametrize("name", KERNELS)
def test_blur_keeps_constant_picture(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str
) -> None:
    _, coc = random_plate(rng, (61, 47), 90.0)
    x = np.full((47, 61, 4), 0.75, np.float32)
    np.testing.assert_allclose(run_blur(solver, x, coc, named_kernel(name)), x, atol=1e-5)


@pytest.mark.parametrize("name", KERNELS)
def test_blur_keeps_light_inside_border(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str
) -> None:
    """The border is in focus, so that no light crosses it."""
    x, coc = random_plate(rng, (61, 47), 90.0)
    coc[[0, -1]], coc[:, [0, -1]] = 0.0, 0.0
    total = run_blur(solver, x, coc, named_kernel(name)).sum(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(total, x.sum(axis=(0, 1), dtype=np.float64), rtol=1e-5)


@pytest.mark.parametrize("coc_px", [2.0, 20.0])
@pytest.mark.parametrize("name", KERNELS)
def test_blur_extends_border_pixels_beyond_the_picture(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str, coc_px: float
) -> None:
    """The border is blurred as in the middle of a larger picture that repeats it."""
    x, coc = random_plate(rng, (21, 17), coc_px)
    margins = ((60, 60), (60, 60))
    larger = np.pad(x, (*margins, (0, 0)), mode="edge"), np.pad(coc, margins, mode="edge")
    expected = run_blur(solver, *larger, named_kernel(name))[60:-60, 60:-60]
    np.testing.assert_allclose(run_blur(solver, x, coc, named_kernel(name)), expected, atol=2e-4)


@pytest.mark.parametrize("name", KERNELS)
def test_blur_keeps_every_bit_of_pixels_in_focus(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str
) -> None:
    x, coc = random_plate(rng, (61, 47), 90.0)
    coc[10:20, 5:50] = 0.0
    result = run_blur(solver, x, coc, named_kernel(name))
    assert np.array_equal(result[coc == 0.0], x[coc == 0.0])
    assert not np.array_equal(result, x)


@pytest.mark.parametrize("name", ["heat", "disc_4"])
def test_blur_of_transposed_plate_is_transposed_blur(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str
) -> None:
    """The coc is uniform: the order of rows and columns matters where the blur varies."""
    x = rng.random((39, 52, 4), np.float32)
    coc = np.full((39, 52), 17.0, np.float32)
    kernel = named_kernel(name)
    across = run_blur(solver, np.ascontiguousarray(x.swapaxes(0, 1)), coc.T.copy(), kernel)
    np.testing.assert_allclose(across.swapaxes(0, 1), run_blur(solver, x, coc, kernel), atol=1e-5)


def test_blur_with_small_scratch_gives_same_picture(
    ctx: Device, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A small scratch buffer splits the lines into tiles, whose borders must not show."""
    x, coc = random_plate(rng, (50, 70), 30.0)
    kernel = named_kernel("disc_3")
    for solver_type in SOLVERS.values():
        whole = run_blur(solver_type(ctx), x, coc, kernel)
        with monkeypatch.context() as patch:
            patch.setattr("heatlens.render.defocus.line_solver.SCRATCH_BYTES_MAX", 1)
            tiled = run_blur(solver_type(ctx), x, coc, kernel)
        assert np.array_equal(whole, tiled)


@pytest.mark.parametrize("name", KERNELS)
def test_blur_with_half_precision_storage_is_close_to_float(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str
) -> None:
    """Packed storage between rows and columns keeps the mean light and does not overflow."""
    x, coc = random_plate(rng, (120, 90), 40.0)
    x[40, 50] = 1e6
    coc[40, 50] = 0.0
    kernel = named_kernel(name)
    exact, half = (run_blur(solver, x, coc, kernel, storage=s) for s in ("f4", PACKED))
    assert half[40, 50, 0] == 1e6
    np.testing.assert_allclose(half, exact, atol=2e-3)
    np.testing.assert_allclose(half.mean(dtype=np.float64), exact.mean(dtype=np.float64), rtol=5e-5)
