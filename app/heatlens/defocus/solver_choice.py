"""Choose the line solver for an OpenGL implementation."""

from functools import lru_cache, partial

import moderngl
import numpy as np

from heatlens.defocus.blur_pass import PACKED, BlurPass, BlurTargets, Diffusion, pole_layers
from heatlens.defocus.kernels import named_kernel
from heatlens.defocus.line_solver import LineSolver, PartitionSolver, SweepSolver
from heatlens.gpu.context import is_software
from heatlens.gpu.stopwatch import run_seconds
from heatlens.gpu.textures import new_array, new_texture, upload

_PROBE_RUNS = 4  # the best time counts, so that a busy machine does not change the choice
_PROBE_KERNEL = named_kernel("heat")  # compiles fastest


def fastest_solver(ctx: moderngl.Context) -> LineSolver:
    """Return the faster one of sweep and partition, the same for all renderers of a context."""
    return _fastest(ctx)(ctx)


@lru_cache(maxsize=1)
def _fastest(ctx: moderngl.Context) -> type[LineSolver]:
    """Measure sweep and partition on a probe picture.

    The probe has 1024 lines to fill a GPU, but only 64 on a software rasteriser, where they show
    the difference as well and take little time.
    """
    size = (512, 64) if is_software(ctx) else (1024, 1024)
    solvers = [SweepSolver(ctx), PartitionSolver(ctx)]
    seconds = [_probe_seconds(ctx, solver, size) for solver in solvers]
    for solver in solvers:
        solver.release()
    return type(solvers[int(np.argmin(seconds))])


def settled_solver(ctx: moderngl.Context) -> LineSolver:
    """Return the solver that is usually faster on such an OpenGL, without measuring.

    The solvers differ in the last digits. Frames of a shot that are rendered by several processes
    must not differ, so that the choice must not depend on how busy a machine is.
    """
    return SweepSolver(ctx) if is_software(ctx) else PartitionSolver(ctx)


def _probe_seconds(ctx: moderngl.Context, solver: LineSolver, size: tuple[int, int]) -> float:
    color, coc, out = (new_texture(ctx, size, channels) for channels in (4, 1, 4))
    poles = new_array(ctx, solver.between_size(size), pole_layers(_PROBE_KERNEL), 4, PACKED)
    upload(coc, np.full(size[::-1], 10.0, np.float32))
    what = Diffusion(color, coc, _PROBE_KERNEL, (1.0, 1.0))
    run = partial(BlurPass(solver).run, what, BlurTargets(poles, out))
    run()  # compiles the programs
    elapsed = min(run_seconds(ctx, run) for _ in range(_PROBE_RUNS))
    for texture in (color, coc, out, poles):
        texture.release()
    return elapsed
