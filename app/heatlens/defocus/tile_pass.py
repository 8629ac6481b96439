"""Find the active tiles of each layer: near its content, and where it is uncovered."""

from dataclasses import dataclass

import moderngl

from heatlens.defocus.fragment_pass import Fragments
from heatlens.defocus.layer_plan import MARGIN_PX, SPREAD, LayerPlan, reach_tiles
from heatlens.defocus.listed_fragments import ListProgram, list_buffers, list_uniforms
from heatlens.defocus.optics import Optics
from heatlens.defocus.pixel_list import Slices
from heatlens.defocus.scratch import Scratch
from heatlens.defocus.tile_mask import TileList, TileMask, tile_count
from heatlens.gpu.program import ComputeProgram, groups_for
from heatlens.gpu.shader_constants import TILE, TILE_GROUP
from heatlens.model.settings import LAYERS_MAX


@dataclass(frozen=True)
class TileContent:
    """The content of each tile: bit l of a word is set if layer l has content; nearest coc."""

    content: moderngl.Buffer
    nearest: moderngl.Buffer
    size: tuple[int, int]  # size of the picture in pixels


class TilePass:
    """Examines the tiles of the picture once, then selects those of each layer."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._layers = ListProgram(ctx, "tile_layers.comp.glsl")
        self._rows = ComputeProgram(ctx, "tile_reach_rows.comp.glsl")
        self._reach = ComputeProgram(ctx, "tile_reach.comp.glsl")
        self._slices = Slices(ctx)

    def look_through(
        self, picture: Fragments, plans: list[LayerPlan], scratch: Scratch
    ) -> TileContent:
        """Find the layers that have content in each tile of the picture."""
        size, need = picture.coc.size, TileMask.bytes_for(picture.coc.size)
        content, nearest = (scratch.buffer(f"tile {name}", need) for name in ("content", "nearest"))
        found = TileContent(content, nearest, size)
        ends = [plan.ends_px for plan in plans]
        lists = picture.lists
        self._layers.version(lists is not None).dispatch(
            _groups(tile_count(size)),
            textures={"coc_tx": picture.coc, "kind_tx": picture.kind, "near_tx": picture.near},
            buffers={"content_block": found.content, "nearest_block": found.nearest}
            | list_buffers(lists),
            uniforms={
                "tiles": tile_count(size),
                "layer_ends_px": ends + [(0.0, 0.0)] * (LAYERS_MAX - len(ends)),
                "layer_count": len(ends),
            }
            | list_uniforms(lists),
        )
        return found

    def find(
        self,
        found: TileContent,
        plans: list[LayerPlan],
        layer: int,
        optics: Optics,
        scratch: Scratch,
    ) -> tuple[TileMask, TileList]:
        """Find the active tiles of one layer, at its size; the next call overwrites them."""
        plan = plans[layer]
        size = plan.size(found.size)
        tiles, need = tile_count(size), TileMask.bytes_for(size)
        tile_px, wider = float(TILE * plan.reduction), max(optics.disc.half_extents)
        listed = TileList(scratch.buffer("tile list", TileList.bytes_for(size)))
        listed.clear(plan.reduction)
        mask = TileMask(scratch.buffer("tile mask", need), tiles)
        between = {
            "distance_block": scratch.buffer("tile distance", need),
            "hider_block": scratch.buffer("tile hider", need),
        }
        reach: dict[str, object] = {
            "tiles": tiles,
            "reach_tiles": reach_tiles(plan, optics.nearest_px, wider, tile_px),
        }
        self._rows.dispatch(
            _groups(tiles),
            buffers=between | {"content_block": found.content, "nearest_block": found.nearest},
            uniforms=reach
            | {
                "picture_tiles": tile_count(found.size),
                "reduction": plan.reduction,
                "layer": layer,
            },
        )
        self._reach.dispatch(
            _groups(tiles),
            buffers=between | {"tile_mask_block": mask.words, "tile_list_block": listed.words},
            uniforms=reach
            | {
                "tile_px": tile_px,
                "spread_px": SPREAD * wider * plan.widest_px,
                "widest_px": plan.widest_px,
                "wider_scale": wider,
                "margin_px": MARGIN_PX,
                "slices": self._slices.count(found.size),
            },
        )
        return mask, listed


def _groups(tiles: tuple[int, int]) -> tuple[int, int]:
    return groups_for(tiles[0], TILE_GROUP), groups_for(tiles[1], TILE_GROUP)
