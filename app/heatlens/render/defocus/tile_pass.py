"""Find the active tiles of each layer: near its content, and where it is uncovered."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

from heatlens.core.model.shot.settings import LAYERS_MAX
from heatlens.render.defocus.layer_cuts import NEARER_THAN_ALL, LayerCut
from heatlens.render.defocus.layer_plan import MARGIN_PX, SPREAD, LayerPlan, reach_tiles
from heatlens.render.defocus.listed_fragments import list_buffers, list_uniforms
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import Slices
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.tile_mask import (
    SegmentPass,
    TileList,
    TileMask,
    tile_count,
)
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.shader_constants import TILE, TILE_GROUP
from heatlens.render.gpu.textures import BufferParts


@dataclass(frozen=True)
class TileContent:
    """What each tile of the picture contains.

    content    a word for each tile, with bit l set if layer l has content there
    coc_range  RG of a pixel for each tile: the least signed coc there in pixels, and the greatest
               one of visible surfaces
    size       width and height of the picture in pixels
    """

    content: Buffer
    coc_range: Texture
    size: tuple[int, int]


@dataclass(frozen=True)
class LayerTiles:
    """The active tiles of a layer, as a mask and as a list."""

    mask: TileMask
    tile_list: TileList


class TilePass:
    """Examines the tiles of the picture once, then selects those of each layer."""

    def __init__(self, ctx: Device) -> None:
        rows = {} if is_software(ctx) else {"ROWS_AT_ONCE": TILE}
        self._layers = ComputeProgram(ctx, "defocus/tile_layers.comp.glsl", rows)
        self._rows = ComputeProgram(ctx, "defocus/tile_reach_rows.comp.glsl")
        self._reach = ComputeProgram(ctx, "defocus/tile_reach.comp.glsl")
        self._segments = SegmentPass(ctx)
        self._slices = Slices(ctx)

    def find_content(
        self, picture: UnmixedPicture, plans: list[LayerPlan], scratch: Scratch
    ) -> TileContent:
        """Find the layers that have content in each tile of the picture."""
        size = picture.coc.size
        layers = scratch.buffer("tile content", TileMask.bytes_for(size))
        coc_range = scratch.texture("tile coc range", tile_count(size), 2)
        content = TileContent(layers, coc_range, size)
        lists = picture.lists
        self._layers.version(LISTS=lists is not None).dispatch(
            _groups(tile_count(size)),
            textures={"coc_tx": picture.coc, "kind_tx": picture.kind, "near_tx": picture.near},
            images={"out_coc_range_img": content.coc_range},
            buffers={"content_block": content.content} | list_buffers(lists),
            uniforms={"tiles": tile_count(size), "cuts_px": _cuts_px([plan.cut for plan in plans])}
            | list_uniforms(lists),
        )
        return content

    def find_active(
        self, content: TileContent, plans: list[LayerPlan], optics: Optics, scratch: Scratch
    ) -> list[LayerTiles]:
        """Find the active tiles of every layer, at its size; `plans` are far to near.

        A tile is active if the layer can be visible there.
        """
        mask_bytes, list_bytes = TileMask.bytes_for(content.size), TileList.bytes_for(content.size)
        masks = scratch.parts("tile mask", len(plans), mask_bytes)
        lists = scratch.parts("tile list", len(plans), list_bytes)
        self._write_masks(content, plans, optics, masks, lists, scratch)
        segments = scratch.parts(
            "line segments", 2 * len(plans), SegmentPass.bytes_for(content.size)
        )
        layer_masks = self._segments.find(
            [plan.size(content.size) for plan in plans], masks, segments
        )
        return [
            LayerTiles(mask, tile_list=TileList(lists[n])) for n, mask in enumerate(layer_masks)
        ]

    # A tile is active only where all nearer layers are open within reach; elsewhere every ray to it
    # ends in nearer layers. A test whether one nearer layer alone covers the tile left too many
    # tiles active: with known surfaces a film frame took 2.4 s of processor, now 1.7 s.
    def _write_masks(
        self,
        content: TileContent,
        plans: list[LayerPlan],
        optics: Optics,
        masks: BufferParts,
        lists: BufferParts,
        scratch: Scratch,
    ) -> None:
        """Write the masks and lists of active tiles of all layers: by rows, then by columns."""
        wider_scale = max(optics.disc.half_extents)
        groups = (*_groups(tile_count(content.size)), len(plans))
        # For each tile and layer: the distance in its row to the next with content, the nearest
        # coc that hides it, and the distance to the next tile in which the layer is open.
        scratch_buffers = {
            f"{name}_block": scratch.buffer(f"tile {name}", len(plans) * masks.part_bytes)
            for name in ("distance", "hider", "hole")
        } | {"tile_list_block": lists.whole}
        shared_uniforms = _plan_uniforms(plans, content.size, optics) | {
            "tile_words": masks.words,
            "list_words": lists.words,
        }
        reaches = [reach_tiles(plan, optics.nearest_px, wider_scale, float(TILE)) for plan in plans]
        self._rows.dispatch(
            groups,
            textures={"coc_range_tx": content.coc_range},
            buffers=scratch_buffers | {"content_block": content.content},
            uniforms=shared_uniforms | {"hole_reach": max(reaches)},
        )
        reach_uniforms = shared_uniforms | {
            "layer_px": _pad_layers(
                [(SPREAD * wider_scale * p.widest_px, p.widest_px) for p in plans]
            ),
            "wider_scale": wider_scale,
            "margin_px": MARGIN_PX,
            "layer_count": len(plans),
            "slices": self._slices.count(content.size),
        }
        buffers = scratch_buffers | {"tile_mask_block": masks.whole}
        self._reach.dispatch(groups, buffers=buffers, uniforms=reach_uniforms)


def _tiles_of(plan: LayerPlan, size: tuple[int, int], optics: Optics) -> tuple[int, int, int, int]:
    """Return tiles across and down, reach in tiles and reduction of a layer, for the shader.

    See `layer_tiles` in lib/tile_reach.lib.glsl.
    """
    tile_px, wider_scale = float(TILE * plan.reduction), max(optics.disc.half_extents)
    reach = reach_tiles(plan, optics.nearest_px, wider_scale, tile_px)
    return (*tile_count(plan.size(size)), reach, plan.reduction)


def _cuts_px(layers: list[LayerCut]) -> tuple[tuple[float, ...], ...]:
    """Return four signed coc in pixels for each cut between layers (tile_layers.comp.glsl).

    Up to the first there is only the nearer layer, up to the second it covers in full; from the
    third on the farther layer covers in full, from the fourth on it is alone. Unused cuts are
    nearer than everything.
    """
    cuts = [a.near for a, b in pairwise(layers) if a != b]
    # The nearer layer covers in full a little before the middle of the transition, the farther one
    # from the middle on: KNOWN and COVERS of lib/layer.lib.glsl.
    ends = [
        (at - half, at - 0.1 * half, at, at + half)
        for at, half in ((cut.at_px, cut.half_width_px) for cut in cuts)
    ]
    return (*ends, *((NEARER_THAN_ALL.at_px,) * 4,) * (LAYERS_MAX - 1 - len(ends)))


def _layer_numbers(layers: list[LayerCut]) -> tuple[int, ...]:
    """Return the number of each layer; two sizes of the same layer have the same number."""
    is_new = [a != b for a, b in pairwise(layers)]
    numbers = (0, *accumulate(is_new))
    return (*numbers, *(0,) * (2 * LAYERS_MAX - len(numbers)))


def _plan_uniforms(
    plans: list[LayerPlan], size: tuple[int, int], optics: Optics
) -> dict[str, object]:
    """Return the uniforms that describe the layers of a picture of this size, in pixels."""
    return {
        "layer_tiles": _pad_layers([_tiles_of(plan, size, optics) for plan in plans]),
        "layer_number": _layer_numbers([plan.cut for plan in plans]),
        "picture_tiles": tile_count(size),
    }


def _pad_layers(values: Sequence[tuple[float, ...]]) -> tuple[tuple[float, ...], ...]:
    """Return values of layers as a uniform array, padded to all layers at two sizes each."""
    return (*values, *((0,) * len(values[0]),) * (2 * LAYERS_MAX - len(values)))


def _groups(tiles: tuple[int, int]) -> tuple[int, int]:
    """Return the workgroups for a pass with one invocation per tile."""
    return groups_for(tiles[0], TILE_GROUP), groups_for(tiles[1], TILE_GROUP)
