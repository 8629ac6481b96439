"""Blur what each part of the lens sees, where surfaces of different blur overlap.

The lens is cut into parts of equal area. The view of each part is assembled from the known
surfaces, so that they hide each other correctly, and diffused by the small disc of that part. The
mean of all views replaces the layers near the edges of such surfaces: behind the focus with views
of what is behind it, and around wide near surfaces with views of all depths.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.render.defocus.blur_pass import BlurPass, BlurTargets, Diffusion, PackedPicture
from heatlens.render.defocus.kernels import Kernel
from heatlens.render.defocus.layer_cuts import FAR_FROM_PX, Cut, LayerCut
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.lens_parts import lens_parts
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.overlap_zones import OverlapZone, OverlapZones, PartSurfaces
from heatlens.render.defocus.part_memory import ViewMemory, sum_memory
from heatlens.render.defocus.pixel_list import TileBands
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import Steps
from heatlens.render.defocus.tile_mask import SegmentPass, TileMask
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import (
    ComputeProgram,
    groups_for,
    pixel_groups,
)
from heatlens.render.gpu.resources import Buffer, Texture, TextureArray
from heatlens.render.gpu.shader_constants import TILE, TILE_GROUP

# The layer in front of the focus, for the fill of its coc, which only asks on which side it is.
_IN_FRONT = LayerCut(Cut(-math.inf, 0.0), Cut(-FAR_FROM_PX, 0.0), is_before_focus=True)
# Known share of a pixel from which views are used. Where views of all depths do not know what is
# behind a near surface, that surface alone would be too dark or too light: hair before a wall left
# dark specks (FLIP of a crowd .0265, with these limits .0241).
_PARTLY_KNOWN: dict[str, object] = {"known_from": 0.0, "known_to": 1.0}
_WHOLLY_KNOWN: dict[str, object] = {"known_from": 0.9, "known_to": 1.0}
_TAIL = 2.0  # a disc of a draft spreads so far, in radii of the disc
_NO_PART = np.zeros((1, 4))  # stands for a part in the call that begins the sum
_PROGRAMS = "surfaces", "links", "view", "order", "masks", "sum", "over", "mix"


@dataclass(frozen=True)
class PartViews:
    """The mean view of all parts of the lens.

    total     RGBA of each pixel, floats: rgb times the known share of the pixel, and that share;
              the mean of all parts
    zone      where the view is used in place of layers
    is_whole  the view shows all depths, and not only what is behind the focus
    """

    total: Buffer
    zone: OverlapZone
    has_all_depths: bool = False


@dataclass(frozen=True)
class _PartBlur:
    """How the view of a part is blurred: its kernel, the shape of the disc, and scratch memory."""

    kernel: Kernel
    disc: DiscShape
    poles: TextureArray

    def of(self, view: PackedPicture, coc: Texture) -> tuple[Diffusion, BlurTargets]:
        """Return the diffusion of a view in place."""
        diffusion = Diffusion(view, coc, self.kernel, self.disc.half_extents)
        return diffusion, BlurTargets(self.poles, view)


# Parts of the lens show surfaces of different blur that overlap. Within one layer, such surfaces
# keep light from each other, and hidden surfaces of that layer are not used; 13 layers were worse
# with two lenses of three. A path-traced forest with known surfaces: FLIP .0843 in layers, .0580 in
# 37 parts. Views that are only moved and averaged, without a blur, need 96 parts and are soft in
# focus. The kernel of a draft is enough for a view, where little overlap is left: the picture
# changes by .0003.
class PartViewsPass:
    """Renders views of the parts of the lens, whose mean replaces layers."""

    def __init__(self, ctx: Device, blur: BlurPass, coc_fill: CocFillPass) -> None:
        self._ctx, self._blur = ctx, blur
        self._tiles = TileBands(ctx)
        self._coc_fill = coc_fill
        self._zones, self._segments = OverlapZones(ctx), SegmentPass(ctx)
        self._programs = {
            name: ComputeProgram(ctx, f"defocus/part_{name}.comp.glsl") for name in _PROGRAMS
        }

    def _program(
        self, name: str, has_all_depths: bool = False, positions: int = 1
    ) -> ComputeProgram:
        """Return the program part_`name`.

        With several `positions`, the part of the lens varies over the picture.
        """
        return self._programs[name].version(ALL_DEPTHS=has_all_depths, PART_VARIES=positions > 1)

    def find_zone(
        self,
        surfaces: PartSurfaces,
        optics: Optics,
        parts: int,
        scratch: Scratch,
        covering: OverlapZone | None = None,
    ) -> OverlapZone | None:
        """Return where the views of `parts` parts replace layers, see `OverlapZones.find`."""
        return self._zones.find(surfaces, optics, parts, scratch, covering)

    def steps(
        self,
        surfaces: PartSurfaces,
        zone: OverlapZone,
        optics: Optics,
        parts: int,
        kernel: Kernel,
        poles: TextureArray,
        scratch: Scratch,
    ) -> Steps[PartViews]:
        """Diffuse the view of each of the `parts` of the lens in `zone`, and return the mean view.

        `kernel` is the disc of a part, and `poles` is scratch memory for the blur.
        """
        memory = ViewMemory.of(surfaces, scratch)
        total = sum_memory(surfaces, scratch)
        blurring = _PartBlur(kernel, optics.disc, poles)
        for _ in self._write_surfaces(surfaces, zone, memory):
            yield surfaces.pass_name
        for _ in self._add_view(memory, zone, total, None):  # begins the sum
            yield surfaces.pass_name
        for part in lens_parts(optics.disc, surfaces.coc.size, parts):
            for steps in (
                self._link_surfaces(surfaces, zone, part, memory),
                self._draw_view(surfaces, zone, part, memory),
                self._blur_view(memory, zone, blurring),
                self._add_view(memory, zone, total, part),
            ):
                for _ in steps:
                    yield surfaces.pass_name
        yield scratch.end_pass(surfaces.pass_name)
        return PartViews(total, zone, surfaces.has_all_depths)

    def _write_surfaces(
        self, surfaces: PartSurfaces, zone: OverlapZone, memory: ViewMemory
    ) -> Iterator[None]:
        """Write the surfaces that the views of all parts show."""
        return self._tiles.run(
            self._program("surfaces", surfaces.has_all_depths),
            zone.listed.moved,
            surfaces.number_uniforms | _front_uniforms(surfaces),
            {
                **surfaces.lists.buffers,
                "link_block": memory.links,
                "limit_block": memory.limits,
            },
            textures=surfaces.textures,
        )

    def _link_surfaces(
        self,
        surfaces: PartSurfaces,
        zone: OverlapZone,
        part: NDArray[np.float64],
        memory: ViewMemory,
    ) -> Iterator[None]:
        """List the surfaces that move to each cell in the view of one part of the lens."""
        yield from self._tiles.run(
            self._program("links", surfaces.has_all_depths, len(part)),
            zone.listed.moved,
            _part_uniforms(part)
            | surfaces.number_uniforms
            | {"reads_across": zone.listed.reads_across},
            surfaces.lists.buffers | memory.list_buffers | {"read_block": zone.listed.reads},
            textures={"coc_tx": surfaces.coc},
        )
        # A cell is the square between four neighboring pixels. With those at the border of the
        # picture there is one more than pixels, across and down.
        width, height = surfaces.coc.size
        cells: dict[str, object] = {"cells": (width + 1, height + 1)}
        order = self._program("order")
        yield from self._tiles.run(order, zone.listed.cells, cells, memory.list_buffers)

    def _draw_view(
        self,
        surfaces: PartSurfaces,
        zone: OverlapZone,
        part: NDArray[np.float64],
        memory: ViewMemory,
    ) -> Iterator[None]:
        """Write the view of one part of the lens, and the diameters of the discs of that part."""
        memory.marks.clear()
        uniforms = _part_uniforms(part) | surfaces.lists.depth_uniforms | _front_uniforms(surfaces)
        return self._tiles.run(
            self._program("view", surfaces.has_all_depths, len(part)),
            zone.listed.drawn,
            uniforms | {"tiles": zone.tiles.tiles},
            memory.list_buffers
            | memory.view_buffers
            | {"mark_block": memory.marks, "limit_block": memory.limits},
            textures={"coc_tx": surfaces.coc},
            images=memory.drawn_images,
        )

    def _find_masks(self, memory: ViewMemory, zone: OverlapZone) -> list[TileMask]:
        """Return the masks of the tiles in which a view, and its front, is blurred."""
        size, tiles = memory.view.size, zone.tiles.tiles
        reach: dict[str, object] = {"reach_tiles": math.ceil(_TAIL * zone.disc_radius_px / TILE)}
        self._program("masks").dispatch(
            (groups_for(tiles[0], TILE_GROUP), groups_for(tiles[1], TILE_GROUP)),
            buffers=zone.buffers | {"mark_block": memory.marks, "mask_block": memory.masks.whole},
            uniforms=zone.tiles.uniforms
            | reach
            | {"tiles": tiles, "mask_words": memory.masks.words},
        )
        return self._segments.find([size, size], memory.masks, memory.segments)

    # What is in front of the focus is blurred as a layer of its own, because its blur spreads over
    # what is in focus, where the diffusion of one picture would stop.
    def _blur_view(
        self, memory: ViewMemory, zone: OverlapZone, blurring: "_PartBlur"
    ) -> Iterator[None]:
        """Blur the view of one part of the lens by the disc of that part."""
        masks = self._find_masks(memory, zone)
        yield from self._blur.steps(*blurring.of(memory.view, memory.coc), masks[0])
        if (front := memory.front) is None:
            return
        yield from self._coc_fill.steps(
            front.state,
            _IN_FRONT,
            blurring.disc.spreads,
            front.rows,
            front.coc,
            masks[1],
        )
        yield from self._blur.steps(*blurring.of(front.view, front.coc), masks[1])

    def _add_view(
        self,
        memory: ViewMemory,
        zone: OverlapZone,
        total: Buffer,
        part: NDArray[np.float64] | None,
    ) -> Iterator[None]:
        """Add the blurred view of a part to the sum; if `part` is None, begin the sum."""
        positions = _NO_PART if part is None else part
        return self._tiles.run(
            self._program("sum", memory.front is not None, len(positions)),
            zone.listed.cells,  # it also empties the lists of the cells between pixels
            _part_uniforms(positions)
            | zone.tiles.uniforms
            | {"is_first": part is None, "picture_size": memory.view.size},
            zone.buffers | memory.view_buffers | {"head_block": memory.heads, "sum_block": total},
        )

    def over(self, field: PartViews, out: Texture) -> None:
        """Write the mean view over its zones of `out`, which holds the layers blurred so far."""
        self._program("over").dispatch(
            pixel_groups(out.size),
            textures={"zone_tx": field.zone.blocks},
            buffers={"sum_block": field.total},
            images={"out_color_img": out},
            uniforms=_WHOLLY_KNOWN if field.has_all_depths else _PARTLY_KNOWN,
        )

    # The picture changes gradually to the one with the far field, as the zones grow. A zone
    # anywhere adds the cut of the far field to the whole picture: without the mix, a slow focus
    # pull jumped by 5 levels when the first zone appeared, also far from the zone.
    def mix(self, without: Texture, field: PartViews, out: Texture) -> None:
        """Mix `out` with the picture without the far field, as far as its zones have grown."""
        self._program("mix").dispatch(
            pixel_groups(out.size),
            textures={"without_tx": without},
            images={"out_color_img": out},
            uniforms={"growth": field.zone.growth},
        )


def _front_uniforms(surfaces: PartSurfaces) -> dict[str, object]:
    """Return the uniform that tells what is in front of the focus, if the views show that."""
    return {"front_px": -FAR_FROM_PX} if surfaces.has_all_depths else {}


def _part_uniforms(part: NDArray[np.float64]) -> dict[str, object]:
    """Return the uniform of lib/lens_part.lib.glsl for a part (positions, 4) of `lens_parts`."""
    positions = [tuple(position) for position in part]
    return {"lens_part": positions if len(positions) > 1 else positions[0]}
