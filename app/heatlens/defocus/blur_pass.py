"""The diffusion of one image: rows, then columns, with a kernel's poles on shared conductances."""

from collections.abc import Iterator
from dataclasses import dataclass

import moderngl

from heatlens.defocus.kernels import Kernel
from heatlens.defocus.line_solver import Bindings, LineSolver, LineSystem
from heatlens.defocus.plate_passes import tiles
from heatlens.gpu.program import ComputeProgram


@dataclass(frozen=True)
class BlurTargets:
    """Where the blur works and where it ends, all of the picture's size."""

    poles: moderngl.TextureArray  # one layer a pole, two if complex; f4, or f2 to move half
    out_color: moderngl.Texture  # RGBA


def pole_layers(kernel: Kernel) -> int:
    """How many layers the image between rows and columns has."""
    return len(kernel.poles) * (2 if kernel.is_complex else 1)


class BlurPass:
    """y = Re sum_ab M_ab (1 + kappa_b L_y)^-1 (1 + kappa_a L_x)^-1 x, L compact for discs."""

    def __init__(self, ctx: moderngl.Context, solver: LineSolver) -> None:
        self._solver = solver
        self._source = ComputeProgram(ctx, "compact_source.comp.glsl")

    def run(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        kernel: Kernel,
        axis_scales: tuple[float, float],
        targets: BlurTargets,
        least_px: float = 0.0,
    ) -> None:
        """Diffuse RGBA `color` by |`coc`| (diameter in pixels) times `axis_scales` (x, y).

        A coc under `least_px` counts as that. `color` must not be the target: with several steps
        the target is fed back, and a compact kernel's source lies there first.
        """
        for _ in self.steps(color, coc, kernel, axis_scales, targets, least_px):
            pass

    def steps(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        kernel: Kernel,
        axis_scales: tuple[float, float],
        targets: BlurTargets,
        least_px: float = 0.0,
    ) -> Iterator[None]:
        """`run` in short steps, so that a window can answer in between."""
        system = LineSystem(
            "lib/blur_system.lib.glsl",
            poles=len(kernel.poles),
            is_complex=kernel.is_complex,
            defines=(("HALF_POLES", 1),) if targets.poles.dtype == "f2" else (),
        )
        uniforms = {
            "kappa": _numbers(kernel, "poles"),
            "mix_weights": _numbers(kernel, "mix"),
            "compact_c": kernel.compact,
            "least_px": least_px,
        }
        source = color
        if kernel.compact:
            self._make_source(color, coc, axis_scales, uniforms, targets.out_color)
            source = targets.out_color
        for _ in range(kernel.steps):
            yield from self._step(system, coc, color, source, axis_scales, uniforms, targets)
            source = targets.out_color

    def _make_source(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        axis_scales: tuple[float, float],
        uniforms: dict[str, object],
        out_color: moderngl.Texture,
    ) -> None:
        self._source.dispatch(
            tiles(color.size),
            textures={"color_tx": color, "coc_tx": coc},
            images={"out_color_img": out_color},
            uniforms=uniforms | {"axis_scales": axis_scales},
        )

    def _step(
        self,
        system: LineSystem,
        coc: moderngl.Texture,
        color: moderngl.Texture,
        source: moderngl.Texture,
        axis_scales: tuple[float, float],
        uniforms: dict[str, object],
        targets: BlurTargets,
    ) -> Iterator[None]:
        """Rows of `source`, then columns; what is in focus is `color` again."""
        rows = Bindings(
            {"coc_tx": coc, "source_tx": source},
            {"out_poles_img": targets.poles},
            uniforms | {"axis_scale": axis_scales[0]},
        )
        columns = Bindings(
            {"coc_tx": coc, "color_tx": color, "poles_tx": targets.poles},
            {"out_color_img": targets.out_color},
            uniforms | {"axis_scale": axis_scales[1]},
        )
        yield from self._solver.steps(system, "rows", color.size, rows)
        yield from self._solver.steps(system, "columns", color.size, columns)


def _numbers(kernel: Kernel, field: str) -> object:
    """A kernel's coefficients as the shader's `Num` array takes them."""
    values = getattr(kernel, field).ravel()
    numbers = [(z.real, z.imag) for z in values] if kernel.is_complex else [z.real for z in values]
    return numbers if len(numbers) > 1 else numbers[0]
