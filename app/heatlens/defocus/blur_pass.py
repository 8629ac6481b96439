"""The diffusion of one image: rows, then columns, with a kernel's poles on shared conductances."""

from dataclasses import dataclass

import moderngl

from heatlens.defocus.kernels import Kernel
from heatlens.defocus.line_solver import Bindings, LineSolver, LineSystem


@dataclass(frozen=True)
class BlurTargets:
    """Where the blur works and where it ends, all of the picture's size."""

    poles: moderngl.TextureArray  # one layer a pole, two if complex; f4, or f2 to move half
    out_color: moderngl.Texture  # RGBA


def pole_layers(kernel: Kernel) -> int:
    """How many layers the image between rows and columns has."""
    return len(kernel.poles) * (2 if kernel.is_complex else 1)


class BlurPass:
    """y = Re sum_ab M_ab (1 + kappa_b L_y)^-1 (1 + kappa_a L_x)^-1 x."""

    def __init__(self, solver: LineSolver) -> None:
        self._solver = solver

    def run(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        kernel: Kernel,
        axis_scales: tuple[float, float],
        targets: BlurTargets,
        least_px: float = 0.0,
    ) -> None:
        """Diffuse RGBA `color` by |`coc`| (diameter in pixels), at least `least_px`, times
        `axis_scales` (x, y).

        With several steps out_color is fed back; it must not be `color` itself.
        """
        system = LineSystem(
            "lib/blur_system.lib.glsl",
            poles=len(kernel.poles),
            is_complex=kernel.is_complex,
            defines=(("HALF_POLES", 1),) if targets.poles.dtype == "f2" else (),
        )
        uniforms = {
            "kappa": _numbers(kernel, "poles"),
            "mix_weights": _numbers(kernel, "mix"),
            "least_px": least_px,
        }
        for step in range(kernel.steps):
            source = color if step == 0 else targets.out_color
            textures = {"coc_tx": coc, "color_tx": source}
            self._solver.solve(
                system,
                "rows",
                color.size,
                Bindings(
                    textures,
                    {"out_poles_img": targets.poles},
                    uniforms | {"axis_scale": axis_scales[0]},
                ),
            )
            self._solver.solve(
                system,
                "columns",
                color.size,
                Bindings(
                    {"coc_tx": coc, "color_tx": color, "poles_tx": targets.poles},
                    {"out_color_img": targets.out_color},
                    uniforms | {"axis_scale": axis_scales[1]},
                ),
            )


def _numbers(kernel: Kernel, field: str) -> object:
    """A kernel's coefficients as the shader's `Num` array takes them."""
    values = getattr(kernel, field).ravel()
    numbers = [(z.real, z.imag) for z in values] if kernel.is_complex else [z.real for z in values]
    return numbers if len(numbers) > 1 else numbers[0]
