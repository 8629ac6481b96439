"""What happens to one depth layer before and after it is blurred."""

from collections.abc import Iterator
from dataclasses import dataclass

import moderngl

from heatlens.defocus.fragment_pass import Fragments
from heatlens.defocus.layer_cuts import LayerCut
from heatlens.defocus.line_solver import Bindings, LineSolver, LineSystem
from heatlens.defocus.pixel_list import clear_list
from heatlens.defocus.plate_passes import tiles
from heatlens.gpu.program import ComputeProgram, groups_for


@dataclass(frozen=True)
class Layer:
    """A layer's pixels."""

    color: moderngl.Texture  # rgb times coverage, a coverage, marked where it has to be guessed
    state: moderngl.Texture  # r diameter |coc|, g how far it has content, 0..1


class LayerSplitPass:
    """One layer out of the picture."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._program = ComputeProgram(ctx, "layer_split.comp.glsl")

    def run(self, picture: Fragments, cut: LayerCut, pixels: moderngl.Buffer, out: Layer) -> None:
        """Write the layer between the limits of `cut`, and the list of its hidden `pixels`."""
        clear_list(pixels)
        self._program.dispatch(
            tiles(picture.coc.size),
            textures=picture.textures(),
            images={"out_layer_img": out.color, "out_state_img": out.state},
            buffers={0: pixels},
            uniforms={**_limits(cut), "is_farthest": cut.is_farthest},
        )


def _limits(cut: LayerCut) -> dict[str, object]:
    """As lib/layer.lib.glsl takes them."""
    return {
        "cut_near_px": (cut.near.at_px, cut.near.half_width_px),
        "cut_far_px": (cut.far.at_px, cut.far.half_width_px),
    }


class HiddenFillPass:
    """Guesses what nearer layers hide, along structures that go on behind them."""

    _DIRECTIONS = 4

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._all_program = ComputeProgram(ctx, "seen_bits_all.comp.glsl")
        self._clear_program = ComputeProgram(ctx, "seen_bits_clear.comp.glsl")
        self._cost_program = ComputeProgram(ctx, "hidden_cost.comp.glsl")
        self._fill_program = ComputeProgram(ctx, "hidden_fill.comp.glsl")
        self._all: tuple[tuple[int, int], moderngl.Buffer] | None = None

    @staticmethod
    def bits_bytes(size: tuple[int, int]) -> int:
        """Bytes of the packed seen-masks of a picture: lines of whole 32-bit words."""
        return 4 * sum(_words(size))

    def steps(
        self,
        layer: Layer,
        pixels: moderngl.Buffer,
        bits: moderngl.Buffer,
        cost: moderngl.Texture,
        coc: moderngl.Texture,
        cut: LayerCut,
        reach_px: int,
    ) -> Iterator[None]:
        """Fill the hidden `pixels` of `layer` in place, in short steps; `bits`, `cost` are scratch.

        What is farther than `reach_px` from everything seen stays empty.
        """
        size = layer.color.size
        buffers = {0: pixels, 1: bits}
        seen = {"layer_tx": layer.color}
        self._ctx.copy_buffer(bits, self._all_seen(size), self.bits_bytes(size))
        self._clear_program.dispatch_indirect(pixels, buffers=buffers, uniforms={"size": size})
        yield
        reach = {"reach_px": reach_px}
        self._cost_program.dispatch_indirect(
            pixels, textures=seen, images={"out_cost_img": cost}, buffers=buffers, uniforms=reach
        )
        yield
        self._fill_program.dispatch_indirect(
            pixels,
            textures={"cost_tx": cost, "coc_tx": coc},
            images={"layer_img": layer.color, "state_img": layer.state},
            buffers=buffers,
            uniforms=_limits(cut) | reach,
        )
        yield

    def _all_seen(self, size: tuple[int, int]) -> moderngl.Buffer:
        """Masks with nothing hidden, to start each layer from; made once a size."""
        if self._all is None or self._all[0] != size:
            if self._all is not None:
                self._all[1].release()
            self._all = (size, self._ctx.buffer(reserve=self.bits_bytes(size)))
            self._all_program.dispatch(
                (groups_for(max(_words(size)), 64), self._DIRECTIONS),
                buffers={1: self._all[1]},
                uniforms={"size": size},
            )
        return self._all[1]


def _words(size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Words of the masks along each direction, as lib/hidden.lib.glsl counts them."""
    width, height = size
    down = groups_for(height, 32)
    diagonal = (width + height) * down
    return height * groups_for(width, 32), width * down, diagonal, diagonal


class CocFillPass:
    """Extends a layer's circle of confusion beyond its content, and softens its silhouettes."""

    _SYSTEM = LineSystem("lib/fill_system.lib.glsl")

    def __init__(self, solver: LineSolver) -> None:
        self._solver = solver

    def steps(
        self,
        state: moderngl.Texture,
        cut: LayerCut,
        axis_scales: tuple[float, float],
        rows: moderngl.Texture,
        out_coc: moderngl.Texture,
    ) -> Iterator[None]:
        """`rows` (two channels) is scratch; `out_coc` gets a diameter everywhere."""
        uniforms = {"kappa": 1.0, "is_near": cut.is_before_focus}
        along_rows = Bindings(
            {"state_tx": state}, {"out_rows_img": rows}, uniforms | {"axis_scale": axis_scales[0]}
        )
        along_columns = Bindings(
            {"state_tx": state, "rows_tx": rows},
            {"out_coc_img": out_coc},
            uniforms | {"axis_scale": axis_scales[1]},
        )
        yield from self._solver.steps(self._SYSTEM, "rows", state.size, along_rows)
        yield from self._solver.steps(self._SYSTEM, "columns", state.size, along_columns)


class CompositePass:
    """A blurred layer over what is behind it."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._program = ComputeProgram(ctx, "composite.comp.glsl")

    def run(self, layer: moderngl.Texture, is_farthest: bool, color: moderngl.Texture) -> None:
        """Put the blurred `layer` over `color`, far to near."""
        self._program.dispatch(
            tiles(layer.size),
            textures={"layer_tx": layer},
            images={"out_color_img": color},
            uniforms={"is_farthest": is_farthest},
        )


class LimitsPass:
    """No negative light, alpha in 0..1."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._program = ComputeProgram(ctx, "limits.comp.glsl")

    def run(self, color: moderngl.Texture, is_opaque: bool) -> None:
        """Limit `color` in place; `is_opaque` makes alpha exactly 1."""
        self._program.dispatch(
            tiles(color.size), images={"color_img": color}, uniforms={"is_opaque": is_opaque}
        )
