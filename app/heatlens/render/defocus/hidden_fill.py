"""Guess what nearer layers hide of a layer."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

from heatlens.render.defocus.layer_cuts import LayerCut
from heatlens.render.defocus.layer_passes import Layer, limit_uniforms
from heatlens.render.defocus.line_solver import Axis, Bindings, LineSolver, LineSystem
from heatlens.render.defocus.pixel_list import OF_BOTH, WHOLE_LIST, Slices, clear_list
from heatlens.render.defocus.tile_mask import VisiblePass, VisiblePixels
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.resources import Buffer, StorageBuffer, Texture
from heatlens.render.gpu.shader_constants import LINE_NODE, WORD_GROUP

_Textures = dict[str, Texture]
_LINE_STEPS = 107  # steps of a line along the longer side of a picture
_MEASURED_STEPS = 8.0  # distance over which a line is measured


def line_step_px(size: tuple[int, int]) -> int:
    """Return the unit of lengths along the lines of a layer of `size`, in pixels."""
    return math.ceil(max(size) / _LINE_STEPS)


@dataclass(frozen=True)
class Steadiness:
    """The memory for how steady rows and columns are, in nodes: R each.

    A row has a node for each `LINE_NODE` pixels across, a column for as many down.
    """

    rows: Texture
    columns: Texture

    @staticmethod
    def sizes(size: tuple[int, int]) -> tuple[tuple[int, int], tuple[int, int]]:
        """Return the sizes of both textures for a layer of `size`."""
        width, height = size
        return (groups_for(width, LINE_NODE), height), (width, groups_for(height, LINE_NODE))

    @property
    def textures(self) -> dict[str, Texture]:
        """The textures by their names in the fill of hidden pixels."""
        return {"rows_steadiness_tx": self.rows, "columns_steadiness_tx": self.columns}


@dataclass(frozen=True)
class Ends:
    """Which pixels of a layer the guess may use (lib/entering.lib.glsl).

    coc  signed, in pixels of the picture
    cut  of the layer
    are_entered  pixels of a surface that is passing into the layer are used gradually; the layer
                 then has the size of the picture
    """

    coc: Texture
    cut: LayerCut
    are_entered: bool = False

    @property
    def textures(self) -> dict[str, Texture]:
        """The texture by its name in the shaders."""
        return {"coc_tx": self.coc}

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms by their names in the shaders."""
        return limit_uniforms(self.cut)


# Recursive sums of all pixels along a line, in place of samples behind the two ends of each hidden
# pixel, which changed from pixel to pixel: hidden bars had rims ragged by 2 to 4 px. Nodes cost a
# quarter of a solution for every second pixel and measure as well.
class SteadinessPass:
    """Measures rows and columns by the variance of all that is visible of them."""

    SYSTEM = LineSystem("lib/steadiness_system.lib.glsl")
    ENTERED_SYSTEM = replace(SYSTEM, defines=(("ENTERED", 1),))

    def __init__(self, solver: LineSolver) -> None:
        self._solver = solver

    def steps(
        self,
        color: Texture,
        size: tuple[int, int],
        bits: StorageBuffer,
        ends: Ends,
        out: Steadiness,
    ) -> Iterator[None]:
        """Write to `out` the logarithms of the weights of lines of a layer of `size`.

        `color` is that of the layer, before the guess; `bits` has its visible pixels, or if the
        `ends` are entered all pixels in its active tiles. The steps are short.
        """
        system = self.ENTERED_SYSTEM if ends.are_entered else self.SYSTEM
        measured_nodes = _MEASURED_STEPS * line_step_px(size) / LINE_NODE
        axes: tuple[tuple[Axis, Texture], ...] = ("rows", out.rows), ("columns", out.columns)
        for (axis, image), nodes in zip(axes, out.sizes(size), strict=True):
            bindings = Bindings(
                {"layer_tx": color} | ends.textures,
                {"out_steadiness_img": image},
                {"kappa": measured_nodes**2, "layer_size": size} | ends.uniforms,
                {"bits_block": bits},
            )
            yield from self._solver.steps(system, axis, nodes, bindings)


@dataclass(frozen=True)
class HiddenScratch:
    """The scratch memory of the hidden fill.

    visible  which pixels are visible
    blocks  list of blocks to fill, of size `list_bytes` of the picture
    cost    RGBA of a pixel for each block of 2 x 2: how much the visible pixels at both ends
            differ, one direction in each channel
    match   RGBA in the same size: how the brightness of listed surfaces differs from that of
            visible ones; None unless fragment lists are matched to the picture
    lines   how steady rows and columns are; None for a layer that does not follow them
    """

    visible: VisiblePixels
    blocks: Buffer
    cost: Texture
    match: Texture | None = None
    lines: Steadiness | None = None

    @property
    def lists(self) -> dict[str, Buffer]:
        """The storage blocks with the blocks of pixels to fill, and with the visible pixels."""
        return self.visible.buffers | {"two_lists_block": self.blocks}


# How far off an end of a line counts, in steps of a line, and the power with which a line counts by
# its ends: before a farther layer, content shows as shapes, and a hidden bar takes both its ends
# over a long way; else the nearest end decides.
_NEAR_STEPS, _NEAR_STEPS_OF_SHAPES = 1 / 3, 1.5
_NEAR_POWER, _NEAR_POWER_OF_SHAPES = 0.25, 0.5


# Color follows the direction whose two ends are most alike; only the coc is diffused. The paper
# fills color by diffusion too, but along rows and columns that does not join a stripe that a wire
# interrupts. Tried and worse: no fill behind the focus, with the blurred color divided by the
# blurred coverage instead (a fence: FLIP .091 -> .094, .077 -> .083). Deep behind a silhouette,
# where the ends are far away, 2 x 2 pixels share one guess.
class HiddenFillPass:
    """Guesses hidden colors: continues visible structures behind nearer layers."""

    def __init__(self, ctx: Device, solver: LineSolver) -> None:
        self._steadiness = SteadinessPass(solver)
        self._visible = VisiblePass(ctx)
        self._rims, self._blocks, self._cost, self._fill = (
            ComputeProgram(ctx, f"defocus/hidden_{name}.comp.glsl")
            for name in ("rims", "blocks", "cost", "fill")
        )
        self._slices = Slices(ctx)

    def steps(
        self,
        layer: Layer,
        pixels: Buffer,
        scratch: HiddenScratch,
        reach_px: int,
        ends: Ends,
        around: Texture | None = None,
        shape_share: float = 0.0,
        each_pixel: bool = False,
    ) -> Iterator[None]:
        """Fill the hidden `pixels` of `layer` in place, in short steps.

        Hidden pixels more than `reach_px` from any visible pixel of the layer stay empty. `around`
        is that of `UnmixedPicture`, for a layer that may hold highlights. If `scratch` has lines,
        the guess behind wide things follows rows and columns, with `shape_share` of a plan. With
        `each_pixel`, pixels far from visible ones are guessed one by one too. If the `ends`
        are entered, there is a second round, in which pixels known in part are ends as well.
        """
        uniforms = ends.uniforms | {"reach_px": reach_px, "layer_size": layer.size}
        uniforms["line_step_px"] = line_step_px(layer.size)
        lines = scratch.lines
        fill_uniforms = {} if lines is None else _near_uniforms(shape_share)
        mark = partial(self._visible.mark, layer.color, layer.size, layer.mask, scratch.visible)
        mark()
        yield
        self._clear_rims(layer, scratch)
        if ends.are_entered:
            mark(are_hidden_visible=True)
        if lines is not None:
            yield from self._steadiness.steps(
                layer.color, layer.size, scratch.visible.bits, ends, lines
            )
        for is_second in (False, True) if ends.are_entered else (False,):
            if ends.are_entered:
                uniforms["is_second_round"] = is_second
                mark()
            self._list_blocks(layer, pixels, scratch, each_pixel)
            yield
            yield from self._guess(layer, scratch, ends, around, uniforms, fill_uniforms)

    def _guess(
        self,
        layer: Layer,
        scratch: HiddenScratch,
        ends: Ends,
        around: Texture | None,
        uniforms: dict[str, object],
        fill_uniforms: dict[str, object],
    ) -> Iterator[None]:
        """Guess the listed blocks of `layer`, in short steps; see `steps`."""
        info_textures: _Textures = {} if layer.list_info is None else {"listed_tx": layer.list_info}
        match_inputs, out_match, match_textures = _match_textures(layer, scratch)
        variant = {"MATCHED": bool(match_textures), "LINES": scratch.lines is not None}
        variant["ENTERED"] = ends.are_entered
        fill = self._fill.version(
            LISTS=bool(info_textures), HIGHLIGHTS=around is not None, **variant
        )
        for slice_uniforms in self._slices.of(layer.size):
            self._cost.version(**variant).dispatch(
                scratch.blocks,
                textures={"layer_tx": layer.color} | match_inputs | ends.textures,
                images={"cost_img": scratch.cost} | out_match,
                buffers=scratch.lists,
                uniforms=uniforms | slice_uniforms,
            )
            yield
        textures = {"cost_tx": scratch.cost} | ends.textures
        textures |= {} if around is None else {"around_tx": around}
        textures |= {"state_tx": layer.state} | info_textures | match_textures
        textures |= {} if scratch.lines is None else scratch.lines.textures
        for slice_uniforms in self._slices.of(layer.size):
            fill.dispatch(
                scratch.blocks,
                offset=OF_BOTH,
                textures=textures,
                images={"layer_img": layer.color, "out_state_img": layer.state},
                buffers=scratch.lists,
                uniforms=uniforms | fill_uniforms | slice_uniforms,
            )
            yield

    def _clear_rims(self, layer: Layer, scratch: HiddenScratch) -> None:
        """Clear what was measured of visible blocks beside hidden ones."""
        width, height = layer.size
        invocations = groups_for(width, 32) * groups_for(height, 2)
        self._rims.version(MATCHED=scratch.match is not None).dispatch(
            (groups_for(invocations, WORD_GROUP), 1),
            images={"out_cost_img": scratch.cost} | _match_textures(layer, scratch)[1],
            buffers={"bits_block": scratch.visible.bits, "tile_mask_block": layer.mask.words},
            uniforms={"layer_size": layer.size} | layer.mask.uniforms,
        )

    def _list_blocks(
        self, layer: Layer, pixels: Buffer, scratch: HiddenScratch, each_pixel: bool
    ) -> None:
        """List the blocks of the hidden `pixels` to fill."""
        clear_list(scratch.blocks)
        self._blocks.version(EACH_PIXEL=each_pixel).dispatch(
            pixels,
            textures={"layer_tx": layer.color},
            buffers={
                "pixel_list_block": pixels,
                "two_lists_block": scratch.blocks,
                "tile_mask_block": layer.mask.words,
            },
            uniforms=WHOLE_LIST
            | layer.mask.uniforms
            | {"slices": self._slices.count(layer.size), "layer_size": layer.size},
        )


def _near_uniforms(shape_share: float) -> dict[str, object]:
    """Return the uniforms for how the ends of lines count, with the `shape_share` of a plan."""
    return {
        "near_steps": _NEAR_STEPS + shape_share * (_NEAR_STEPS_OF_SHAPES - _NEAR_STEPS),
        "near_power": _NEAR_POWER + shape_share * (_NEAR_POWER_OF_SHAPES - _NEAR_POWER),
    }


def _match_textures(layer: Layer, scratch: HiddenScratch) -> tuple[_Textures, _Textures, _Textures]:
    """Return the inputs of the brightness match, its output, and the textures to read it from.

    All are empty if nothing is matched.
    """
    if layer.list_info is None or scratch.match is None:
        return {}, {}, {}
    inputs = {"listed_tx": layer.list_info, "state_tx": layer.state}
    return inputs, {"out_match_img": scratch.match}, {"match_tx": scratch.match}
