"""Cut out one depth layer, complete it for the blur, and composite it afterwards."""

from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.render.defocus.layer_cuts import LayerCut
from heatlens.render.defocus.layer_plan import LayerPlan
from heatlens.render.defocus.line_solver import Axis, Bindings, LineSolver, LineSystem
from heatlens.render.defocus.listed_fragments import list_buffers, list_uniforms
from heatlens.render.defocus.pixel_list import WHOLE_LIST, Slices, clear_list
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
            **limit_uniforms(plan.cut),
            "is_farthest": plan.cut.is_farthest,
            "is_entered": plan.is_entered and picture.lists is None,
            "reduction": plan.reduction,
            "layer_size": out.size,
            **out.mask.uniforms,
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
                | {"tile_mask_block": out.mask.words}
                | list_buffers(lists),
                uniforms=uniforms | slice_uniforms,
            )
            yield


def limit_uniforms(cut: LayerCut) -> dict[str, object]:
    """Return the uniforms of lib/layer.lib.glsl."""
    return {
        "cut_near_px": (cut.near.at_px, cut.near.half_width_px),
        "cut_far_px": (cut.far.at_px, cut.far.half_width_px),
    }


_Textures = dict[str, Texture]


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
