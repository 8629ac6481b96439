"""Cut out one depth layer, complete it for the blur, and composite it afterwards."""

from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.render.defocus.layer_cuts import LayerCut
from heatlens.render.defocus.layer_plan import LayerPlan
from heatlens.render.defocus.line_solver import Axis, Bindings, LineSolver, LineSystem
from heatlens.render.defocus.line_steadiness import Steadiness, SteadinessPass, line_step_px
from heatlens.render.defocus.listed_fragments import list_buffers, list_uniforms
from heatlens.render.defocus.pixel_list import OF_BOTH, WHOLE_LIST, Slices, clear_list
from heatlens.render.defocus.tile_mask import TileList, TileMask, tile_count
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for, pixel_groups
from heatlens.render.gpu.resources import Buffer, StorageBuffer, Texture
from heatlens.render.gpu.shader_constants import STRIP_COLUMNS


@dataclass(frozen=True)
class Layer:
    """The pixels of a layer, in its active tiles.

    color  rgb premultiplied by coverage, a = coverage; hidden pixels to fill are marked
    state  r = |coc| in pixels of the layer, g = how much content it has, 0..1
    size   of the layer; if it is smaller than the picture, it is in the corner of the textures
    mask   the active tiles; `tile_list` has the same tiles as a list
    list_info  r = share of the layer known from the pixel's fragment list, g = depth visible
               behind the silhouette, pixels (layer_split.comp.glsl); None without lists
    """

    color: Texture
    state: Texture
    size: tuple[int, int]
    mask: TileMask
    tile_list: TileList
    list_info: Texture | None = None


class LayerSplitPass:
    """Cuts one layer out of the picture."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/layer_split.comp.glsl")
        self._slices = Slices(ctx)

    def steps(
        self, picture: UnmixedPicture, plan: LayerPlan, pixels: Buffer, out: Layer
    ) -> Iterator[None]:
        """Write the layer of `plan` to `out` at the plan's size, in short steps.

        `pixels` becomes the list of the layer's pixels that nearer layers hide.
        """
        clear_list(pixels)
        uniforms = {
            **_limit_uniforms(plan.cut),
            "is_farthest": plan.cut.is_farthest,
            "reduction": plan.reduction,
            "layer_size": out.size,
        }
        lists = picture.lists
        images = {"out_layer_img": out.color, "out_state_img": out.state}
        if lists is not None and out.list_info is not None:
            images["out_listed_img"] = out.list_info
            uniforms |= list_uniforms(lists) | {
                "is_nearest": plan.cut.is_nearest,
                "at_infinity_px": lists.line.at_infinity_px,
            }
        for slice_uniforms in self._slices.of(picture.coc.size):
            self._program.version(REDUCED=plan.reduction > 1, LISTS=lists is not None).dispatch(
                out.tile_list.words,
                offset=TileList.OF_LAYER,
                textures=picture.textures(),
                images=images,
                buffers={"pixel_list_block": pixels, "tile_list_block": out.tile_list.words}
                | list_buffers(lists),
                uniforms=uniforms | slice_uniforms,
            )
            yield


def _limit_uniforms(cut: LayerCut) -> dict[str, object]:
    """Return the uniforms of lib/layer.lib.glsl."""
    return {
        "cut_near_px": (cut.near.at_px, cut.near.half_width_px),
        "cut_far_px": (cut.far.at_px, cut.far.half_width_px),
    }


@dataclass(frozen=True)
class HiddenScratch:
    """The scratch memory of the hidden fill.

    bits    which pixels are visible; at first all are, see `VisibleBitsPass`
    blocks  list of blocks to fill, of size `list_bytes` of the picture
    cost    RGBA of a pixel for each block of 2 x 2: how much the visible pixels at both ends
            differ, one direction in each channel
    match   RGBA in the same size: how the brightness of listed surfaces differs from that of
            visible ones; None unless fragment lists are matched to the picture
    lines   how steady rows and columns are; None for a layer that does not follow them
    """

    bits: StorageBuffer
    blocks: Buffer
    cost: Texture
    match: Texture | None = None
    lines: Steadiness | None = None

    @property
    def lists(self) -> dict[str, StorageBuffer]:
        """The storage blocks with the blocks of pixels to fill, and with the visible pixels."""
        return {"bits_block": self.bits, "two_lists_block": self.blocks}


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
        self._blocks, self._cost, self._fill = (
            ComputeProgram(ctx, f"defocus/hidden_{name}.comp.glsl")
            for name in ("blocks", "cost", "fill")
        )
        self._slices = Slices(ctx)

    def steps(
        self,
        layer: Layer,
        pixels: Buffer,
        scratch: HiddenScratch,
        reach_px: int,
        around: Texture | None = None,
        shape_share: float = 0.0,
        each_pixel: bool = False,
    ) -> Iterator[None]:
        """Fill the hidden `pixels` of `layer` in place, in short steps.

        Hidden pixels more than `reach_px` from any visible pixel of the layer stay empty. `around`
        is that of `UnmixedPicture`, for a layer that may hold highlights. If `scratch` has lines,
        the guess behind wide things follows rows and columns, with `shape_share` of a plan. With
        `each_pixel`, pixels far from visible ones are guessed one by one too.
        """
        info_textures: _Textures = {} if layer.list_info is None else {"listed_tx": layer.list_info}
        match_inputs, out_match, match_textures = _match_textures(layer, scratch)
        cost_images = {"out_cost_img": scratch.cost} | out_match
        self._list_blocks(layer, pixels, scratch, cost_images, each_pixel)
        yield
        fill_buffers = scratch.lists
        has_lines = scratch.lines is not None
        cost = self._cost.version(MATCHED=bool(match_textures), LINES=has_lines)
        fill = self._fill.version(
            LISTS=bool(info_textures), MATCHED=bool(match_textures), LINES=has_lines
        )
        uniforms: dict[str, object] = {
            "reach_px": reach_px,
            "layer_size": layer.size,
            "line_step_px": line_step_px(layer.size),
        }
        line_textures: _Textures = {}
        line_uniforms: dict[str, object] = {}
        if scratch.lines is not None:
            yield from self._steadiness.steps(layer.color, layer.size, scratch.bits, scratch.lines)
            line_textures = scratch.lines.textures
            line_uniforms = _near_uniforms(shape_share)
        for slice_uniforms in self._slices.of(layer.size):
            cost.dispatch(
                scratch.blocks,
                textures={"layer_tx": layer.color} | match_inputs,
                images=cost_images,
                buffers=fill_buffers,
                uniforms=uniforms | slice_uniforms,
            )
            yield
        textures = {"cost_tx": scratch.cost, "around_tx": around or scratch.cost}
        textures |= {"state_tx": layer.state} | info_textures | match_textures | line_textures
        fill_uniforms = uniforms | {"has_highlights": around is not None} | line_uniforms
        for slice_uniforms in self._slices.of(layer.size):
            fill.dispatch(
                scratch.blocks,
                offset=OF_BOTH,
                textures=textures,
                images={"layer_img": layer.color, "out_state_img": layer.state},
                buffers=fill_buffers,
                uniforms=fill_uniforms | slice_uniforms,
            )
            yield

    def _list_blocks(
        self,
        layer: Layer,
        pixels: Buffer,
        scratch: HiddenScratch,
        cost_images: "_Textures",
        each_pixel: bool,
    ) -> None:
        """Mark the hidden `pixels` as not visible, and list the blocks to fill."""
        clear_list(scratch.blocks)
        self._blocks.version(MATCHED=scratch.match is not None, EACH_PIXEL=each_pixel).dispatch(
            pixels,
            textures={"layer_tx": layer.color},
            images=cost_images,
            buffers={
                "bits_block": scratch.bits,
                "pixel_list_block": pixels,
                "two_lists_block": scratch.blocks,
                "tile_mask_block": layer.mask.words,
            },
            uniforms=WHOLE_LIST
            | layer.mask.uniforms
            | {"slices": self._slices.count(layer.size), "layer_size": layer.size},
        )


_Textures = dict[str, Texture]


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


# At a silhouette between surfaces of different blur in one layer, both sides get the blur of the
# nearer one, as a lens shows it: near leaves are soft, and nothing glows into them. Otherwise the
# silhouette would be hard.
class CocFillPass:
    """Extends the coc of a layer beyond its content, so that content spreads with its own blur.

    It also softens the coc at silhouettes within the layer.
    """

    _SYSTEM = LineSystem("lib/fill_system.lib.glsl")

    def __init__(self, solver: LineSolver) -> None:
        self._solver = solver

    def steps(
        self,
        state: Texture,
        cut: LayerCut,
        axis_scales: tuple[float, float],
        rows: tuple[StorageBuffer, StorageBuffer],
        out_coc: Texture,
        mask: TileMask | None = None,
        corner: tuple[int, int] | None = None,
    ) -> Iterator[None]:
        """Write a diameter to every pixel of `out_coc`, or only in the tiles of `mask`.

        `state` is that of a `Layer`. `axis_scales` are the diameters along x and y, relative to the
        coc. `rows` is scratch memory of `rows_bytes` each. `corner` is the size of a layer that
        fills only the corner of the textures.
        """
        size = corner or state.size
        uniforms = {"kappa": 1.0, "is_near": cut.is_before_focus}
        row_buffers = {"rows_diameter_block": rows[0], "rows_weight_block": rows[1]}
        axes: tuple[Axis, Axis] = ("rows", "columns")
        images: tuple[_Textures, ...] = {}, {"out_coc_img": out_coc}
        for axis, out_images, scale in zip(axes, images, axis_scales, strict=True):
            axis_uniforms = uniforms | {"axis_scale": scale}
            bindings = Bindings({"state_tx": state}, out_images, axis_uniforms, row_buffers)
            yield from self._solver.steps(self._SYSTEM, axis, size, bindings, mask)

    @staticmethod
    def rows_bytes(size: tuple[int, int]) -> int:
        """Return the bytes of each buffer between rows and columns of a layer of this size."""
        across = STRIP_COLUMNS * groups_for(size[0], STRIP_COLUMNS)  # lib/strips.lib.glsl
        return 4 * across * 4 * groups_for(size[1], 4)


class CompositePass:
    """Composites a blurred layer, smaller than the picture, over the layers behind it."""

    def __init__(self, ctx: Device) -> None:
        self._over = ComputeProgram(ctx, "defocus/composite.comp.glsl")
        self._begin = ComputeProgram(ctx, "defocus/composite_begin.comp.glsl")

    # Only tiles that the farthest layer leaves are cleared. Clearing the whole picture through a
    # framebuffer took 2.4 of the 10.8 ms of a 3840x2160 frame on an NVIDIA H200.
    def begin(self, farthest: LayerPlan, mask: TileMask, color: Texture) -> None:
        """Make `color` black where the `farthest` layer, the first, will not replace it."""
        self._begin.dispatch(
            tile_count(color.size),
            images={"out_color_img": color},
            buffers={"tile_mask_block": mask.words},
            uniforms=mask.uniforms | {"reduction": farthest.reduction},
        )

    def run(self, blurred: Layer, plan: LayerPlan, behind: Texture, color: Texture) -> None:
        """Composite a `blurred` layer over `color`; the farthest layer replaces it.

        If `plan.share` < 1, `color` holds the picture with this layer at twice the size already,
        and `behind` the picture without the layer: composite over `behind` and cross-fade with
        `color`.
        """
        list_words, mask, is_mixed = blurred.tile_list.words, blurred.mask, plan.share < 1.0
        behind_textures: _Textures = {"behind_tx": behind} if is_mixed else {}
        self._over.version(MIXED=is_mixed).dispatch(
            list_words,
            offset=TileList.OF_PICTURE,
            textures={"layer_tx": blurred.color} | behind_textures,
            images={"out_color_img": color},
            buffers={"tile_list_block": list_words, "tile_mask_block": mask.words},
            uniforms=WHOLE_LIST
            | mask.uniforms
            | {"is_farthest": plan.cut.is_farthest, "reduction": plan.reduction}
            | {"layer_size": blurred.size}
            | ({"share": plan.share} if is_mixed else {}),
        )


class LimitsPass:
    """Removes negative light and limits alpha to 0..1."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/limits.comp.glsl")

    def run(self, color: Texture, is_opaque: bool) -> None:
        """Limit `color` in place; `is_opaque` makes alpha exactly 1."""
        self._program.dispatch(
            pixel_groups(color.size), images={"color_img": color}, uniforms={"is_opaque": is_opaque}
        )
