"""Trace rays from the lens to highlights, to find how much of each is hidden."""

from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.render.defocus.highlights.highlight_list import SMALL_SPRITES_MAX, HighlightBuffers
from heatlens.render.defocus.listed_fragments import list_buffers, list_uniforms
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import PixelBands, Slices, clear_list, list_bytes
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.textures import OpeningTextures

_NODES_A_DISC = 4  # at least
_NODES_MOST = 1 << 22  # the numbers of nodes are kept as floats
_DISCS_A_GROUP = 64  # PIXELS_PER_GROUP of lib/list_slice.lib.glsl


def nodes_most(size: tuple[int, int]) -> int:
    """Return how many nodes the discs of a picture may have together."""
    return min(max(2 * size[0] * size[1], _NODES_A_DISC * SMALL_SPRITES_MAX), _NODES_MOST)


def nodes_bytes(size: tuple[int, int]) -> int:
    """Return the bytes of the list of nodes for a picture."""
    return list_bytes((nodes_most(size), 1))


@dataclass(frozen=True)
class RayMemory:
    """Scratch memory of the rays from the lens to highlights.

    ranges  RG of the picture's size: range of the coc around each pixel
    edges   R of the same size: kind and edge of each pixel (lib/edge_word.lib.glsl)
    nodes   the nodes of discs, and then how much is hidden at each: `nodes_bytes`
    """

    ranges: Texture
    edges: Texture
    nodes: Buffer


# Rays are traced through the depth of the picture, from points of the lens to each lamp, to find
# whether it is hidden from there; layers do not have that information. They end at the nearest
# surface that any ray to this lamp may meet, which the tiles know: 105 -> 69 ms for the same bits.
# Drawn discs of few pixels leave most lanes of a processor idle, so their rays are traced before
# they are drawn, one pixel of a disc a lane: 6,613 lamps behind leaves, 493 -> 320 ms for the same
# picture, 3,187 small and large ones 564 -> 300 ms.
class HighlightShadowPass:
    """Traces the rays to small discs, to find how much of each highlight is hidden."""

    def __init__(self, ctx: Device) -> None:
        self._find_ranges = ComputeProgram(ctx, "defocus/highlight_ranges.comp.glsl")
        self._bands = PixelBands(ctx)
        self._place = ComputeProgram(ctx, "defocus/highlight_nodes.comp.glsl")
        self._trace = ComputeProgram(ctx, "defocus/highlight_shadow.comp.glsl")
        self._slices, self._openings = Slices(ctx), OpeningTextures(ctx)

    def steps(
        self,
        buffers: HighlightBuffers,
        picture: UnmixedPicture,
        coc_range: Texture,
        optics: Optics,
        out: RayMemory,
    ) -> Iterator[None]:
        """Give each small disc of the list its nodes, and find the hidden share at each.

        `coc_range`, RG of a pixel for each tile, has the least signed coc there, and the greatest
        one of visible surfaces.
        """
        size, lists, plan_buffers = picture.coc.size, picture.lists, {"plan_block": buffers.plan}
        yield from self._bands.run(
            *(self._find_ranges, size),
            textures={"coc_tx": picture.coc, "kind_tx": picture.kind}
            | {"far_tx": picture.far, "near_tx": picture.near},
            images={"out_ranges_img": out.ranges, "out_edges_img": out.edges},
            buffers=plan_buffers,
        )
        uniforms = optics.disc.uniforms | {"nearest_px": optics.nearest_px}
        node_buffers = {"pixel_list_block": out.nodes, "sprite_block": buffers.sprite}
        clear_list(out.nodes)
        self._place.version(**optics.disc.switches).dispatch(
            (groups_for(SMALL_SPRITES_MAX, _DISCS_A_GROUP), 1),
            textures={"coc_range_tx": coc_range},
            buffers=node_buffers | plan_buffers,
            uniforms=uniforms | {"nodes_max": nodes_most(size)},
        )
        yield
        for slice_uniforms in self._slices.of(size):
            self._trace.version(LISTS=lists is not None, **optics.disc.switches).dispatch(
                out.nodes,
                textures=ray_textures(picture, out) | self._openings.of(optics.disc.aperture),
                buffers=node_buffers | list_buffers(lists),
                uniforms=uniforms | slice_uniforms | list_uniforms(lists),
            )
            yield


def ray_textures(picture: UnmixedPicture, rays: RayMemory) -> dict[str, Texture]:
    """Return the textures that rays read (lib/highlight_rays.lib.glsl)."""
    return {
        "coc_tx": picture.coc,
        "kind_tx": picture.kind,
        "ranges_tx": rays.ranges,
        "edges_tx": rays.edges,
    }
