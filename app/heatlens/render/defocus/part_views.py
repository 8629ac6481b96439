"""Blur what each part of the lens sees, where surfaces of different blur overlap.

The lens is cut into parts of equal area. The view of each part is assembled from the known
surfaces, so that they hide each other correctly, and diffused by the small disc of that part. The
mean of all views replaces the layers near the edges of such surfaces: behind the focus with views
of what is behind it, and around wide near surfaces with views of all depths.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.shot.settings import LAYERS_MAX
from heatlens.render.defocus.blur_pass import BlurPass, BlurTargets, Diffusion
from heatlens.render.defocus.far_guess import WORD_BYTES
from heatlens.render.defocus.kernels import Kernel
from heatlens.render.defocus.layer_cuts import Cut, LayerCut
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.lens_parts import lens_parts
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.overlap_zones import OverlapZone, OverlapZones, PartSurfaces
from heatlens.render.defocus.pixel_list import PixelBands
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.device import Buffer, Device, StorageBuffer, Texture, TextureArray
from heatlens.render.gpu.program import ComputeProgram, pixel_groups

FAR_FROM_PX = 1.5  # coc, in pixels at full size, from which a surface belongs to the far field
_SOFTNESS = 0.2  # half width of the transition at that cut, as a share of its coc
_LINK_BYTES = 12  # bytes for each surface in lib/part_link.lib.glsl
_PIXEL_BYTES = 24  # bytes for the two surfaces of each pixel in lib/pixel_surface.lib.glsl
# The layer in front of the focus, for the fill of its coc, which only asks on which side it is.
_IN_FRONT = LayerCut(Cut(-math.inf, 0.0), Cut(-FAR_FROM_PX, 0.0), is_before_focus=True)
# Known share of a pixel from which views are used. Where views of all depths do not know what is
# behind a near surface, that surface alone would be too dark or too light: hair before a wall left
# dark specks (FLIP of a crowd .0265, with these limits .0241).
_PARTLY_KNOWN: dict[str, object] = {"known_from": 0.0, "known_to": 1.0}
_WHOLLY_KNOWN: dict[str, object] = {"known_from": 0.9, "known_to": 1.0}
_NO_PART = np.zeros((1, 4))  # stands for a part in the call that begins the sum


def with_far_cut(cuts: list[LayerCut], proxy: float) -> list[LayerCut]:
    """Return the layers, far to near, with an additional cut where the far field begins.

    `proxy` is the scale of the picture. If that makes too many layers, the new cut replaces its
    neighbor: the farther one, because the far field blurs what lies behind the cut by itself, or
    the nearer one where none is farther.
    """
    at_px = FAR_FROM_PX * proxy
    cut = Cut(at_px, at_px * _SOFTNESS)
    index = next((i for i, layer in enumerate(cuts) if layer.near.at_px < at_px), None)
    if index is None:  # everything is farther
        return [*cuts[:-1], replace(cuts[-1], near=cut)]
    # The layer with the cut becomes two; behind and in front of them the layers stay.
    farther, nearer = replace(cuts[index], near=cut), replace(cuts[index], far=cut)
    behind, in_front = cuts[:index], cuts[index + 1 :]
    if behind and farther.far.at_px < 2 * at_px:  # too close to the next cut, which it replaces
        behind, farther = behind[:-1], replace(behind[-1], near=cut)
    if len(behind) + 2 + len(in_front) > LAYERS_MAX:
        if behind:
            behind, farther = behind[:-1], replace(farther, far=behind[-1].far)
        else:
            nearer, in_front = replace(nearer, near=in_front[0].near), in_front[1:]
    return [*behind, farther, nearer, *in_front]


@dataclass(frozen=True)
class PartViews:
    """The mean view of all parts of the lens.

    total     RGBA: rgb times the known share of the pixel, and that share; the mean of all parts
    zone      where the view is used in place of layers
    is_whole  the view shows all depths, and not only what is behind the focus
    """

    total: Texture
    zone: OverlapZone
    is_whole: bool = False


@dataclass(frozen=True)
class _FrontMemory:
    """The memory for the pixels taken apart, and for what a part sees in front of the focus.

    pixels  the surfaces of each pixel (part_pixels.comp.glsl), the same for all parts
    view   RGBA, rgb times coverage, a coverage; then the same, blurred
    state  RG, diameter of the part's disc in pixels and coverage, as that of a `Layer`
    coc    that diameter, extended beyond the surfaces
    rows   scratch memory of `CocFillPass`
    """

    pixels: Buffer
    view: Texture
    state: Texture
    coc: Texture
    rows: tuple[Buffer, Buffer]

    @staticmethod
    def of(size: tuple[int, int], scratch: Scratch) -> "_FrontMemory":
        """Return the memory for a view of the size of the picture."""
        row_bytes = CocFillPass.rows_bytes(size)
        return _FrontMemory(
            scratch.buffer("pixel surfaces", _PIXEL_BYTES * size[0] * size[1]),
            scratch.texture("front view", size, 4),
            scratch.texture("front state", size, 2),
            scratch.texture("front coc", size, 1),
            (
                scratch.buffer("front fill diameters", row_bytes),
                scratch.buffer("front fill weights", row_bytes),
            ),
        )


@dataclass(frozen=True)
class _ViewMemory:
    """The memory for the view of one part of the lens, which all parts use in turn.

    view   RGBA of the view; then the same, blurred
    coc    diameter of the part's disc at each pixel, in pixels
    front  what is in front of the focus, if the views show that too
    heads  the last surface in the list of each pixel (part_links.comp.glsl)
    links  for each surface, the previous one of its list
    """

    view: Texture
    coc: Texture
    heads: Buffer
    links: Buffer
    front: _FrontMemory | None

    @staticmethod
    def of(surfaces: PartSurfaces, scratch: Scratch) -> "_ViewMemory":
        """Return the memory for a view of the size of the picture."""
        (width, height), name = surfaces.coc.size, surfaces.name
        return _ViewMemory(
            scratch.texture(f"{name} view", (width, height), 4),
            scratch.texture(f"{name} coc", (width, height), 1),
            scratch.buffer(f"{name} heads", WORD_BYTES * (width + 1) * (height + 1)),
            scratch.buffer(f"{name} links", _LINK_BYTES * surfaces.surface_count),
            _FrontMemory.of((width, height), scratch) if surfaces.is_whole else None,
        )

    @property
    def list_buffers(self) -> dict[str, StorageBuffer]:
        """The lists of the surfaces that have moved to each cell."""
        return {"head_block": self.heads, "link_block": self.links}

    @property
    def surface_buffers(self) -> dict[str, StorageBuffer]:
        """The lists, and the surfaces of the pixels if these are taken apart."""
        if self.front is None:
            return self.list_buffers
        return self.list_buffers | {"pixel_surface_block": self.front.pixels}

    @property
    def drawn_images(self) -> dict[str, Texture]:
        """The outputs of part_view.comp.glsl."""
        images = {"out_view_img": self.view, "out_coc_img": self.coc}
        if self.front is not None:
            images |= {"out_front_img": self.front.view, "out_front_state_img": self.front.state}
        return images

    @property
    def summed_textures(self) -> dict[str, Texture]:
        """The inputs of part_sum.comp.glsl."""
        front = {} if self.front is None else {"front_tx": self.front.view}
        return {"view_tx": self.view} | front


@dataclass(frozen=True)
class _PartBlur:
    """How the view of a part is blurred: its kernel, the shape of the disc, and scratch memory."""

    kernel: Kernel
    disc: DiscShape
    poles: TextureArray

    def of(self, view: Texture, coc: Texture) -> tuple[Diffusion, BlurTargets]:
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
        self._ctx, self._blur, self._bands = ctx, blur, PixelBands(ctx)
        self._coc_fill = coc_fill
        self._zones = OverlapZones(ctx)
        self._programs: dict[tuple[str, bool, bool], ComputeProgram] = {}

    def _program(self, name: str, is_whole: bool = False, positions: int = 1) -> ComputeProgram:
        """Return the program part_`name`, which is built when it is first used.

        With several `positions`, the part of the lens varies over the picture.
        """
        key = name, is_whole, positions > 1
        if key not in self._programs:
            defines = {"ALL_DEPTHS": 1} if is_whole else {}
            defines |= {"PART_VARIES": 1} if positions > 1 else {}
            self._programs[key] = ComputeProgram(
                self._ctx, f"defocus/part_{name}.comp.glsl", defines
            )
        return self._programs[key]

    def steps(
        self,
        surfaces: PartSurfaces,
        optics: Optics,
        parts: int,
        kernel: Kernel,
        poles: TextureArray,
        scratch: Scratch,
    ) -> Steps[PartViews | None]:
        """Diffuse the view of each of the `parts` of the lens; return the mean view and its zone.

        `kernel` is the disc of a part, and `poles` is scratch memory for the blur. Return None if
        surfaces of different blur overlap nowhere, so that there is no zone.
        """
        zone = self._zones.find(surfaces, optics, parts, scratch)
        yield surfaces.pass_name
        if zone is None:
            scratch.end_pass(surfaces.pass_name)
            return None
        memory = _ViewMemory.of(surfaces, scratch)
        total = scratch.texture(f"{surfaces.name} sum", surfaces.coc.size, 4)
        blurring = _PartBlur(kernel, optics.disc, poles)
        for _ in self._take_pixels_apart(surfaces, memory):
            yield surfaces.pass_name
        for _ in self._add_view(memory, zone, total, None):  # begins the sum
            yield surfaces.pass_name
        for part in lens_parts(optics.disc, surfaces.coc.size, parts):
            for steps in (
                self._draw_view(surfaces, zone, part, memory),
                self._blur_view(memory, zone, blurring),
                self._add_view(memory, zone, total, part),
            ):
                for _ in steps:
                    yield surfaces.pass_name
        yield scratch.end_pass(surfaces.pass_name)
        return PartViews(total, zone, surfaces.is_whole)

    def _take_pixels_apart(self, surfaces: PartSurfaces, memory: _ViewMemory) -> Iterator[None]:
        """Write the surfaces of each pixel for views of all depths; do nothing for other views."""
        if surfaces.fragments is None or memory.front is None:
            return
        yield from self._bands.run(
            self._program("pixels"),
            surfaces.coc.size,
            textures=surfaces.fragments.textures(),
            buffers={"pixel_surface_block": memory.front.pixels},
        )

    def _draw_view(
        self,
        surfaces: PartSurfaces,
        zone: OverlapZone,
        part: NDArray[np.float64],
        memory: _ViewMemory,
    ) -> Iterator[None]:
        """Write the view of one part of the lens, and the diameters of the discs of that part."""
        uniforms = surfaces.uniforms | zone.tiles.uniforms | _part_uniforms(part)
        inputs = {
            "textures": surfaces.textures,
            "buffers": surfaces.lists.buffers | zone.buffers | memory.surface_buffers,
        }
        links, view = (
            self._program(name, surfaces.is_whole, len(part)) for name in ("links", "view")
        )
        yield from self._bands.run(links, surfaces.coc.size, uniforms, **inputs)
        yield from self._order_lists(surfaces.coc.size, memory)
        if surfaces.is_whole:
            uniforms |= {"front_px": -FAR_FROM_PX}
        inputs |= {"images": memory.drawn_images}
        yield from self._bands.run(view, surfaces.coc.size, uniforms, **inputs)

    def _order_lists(self, size: tuple[int, int], memory: _ViewMemory) -> Iterator[None]:
        """Put the surfaces in the list of each cell in order, near to far."""
        cells = size[0] + 1, size[1] + 1
        yield from self._bands.run(
            self._program("order"), cells, {"cells": cells}, buffers=memory.list_buffers
        )

    # What is in front of the focus is blurred as a layer of its own, because its blur spreads over
    # what is in focus, where the diffusion of one picture would stop.
    def _blur_view(
        self, memory: _ViewMemory, zone: OverlapZone, blurring: "_PartBlur"
    ) -> Iterator[None]:
        """Blur the view of one part of the lens by the disc of that part."""
        yield from self._blur.steps(*blurring.of(memory.view, memory.coc), zone.tiles)
        if (front := memory.front) is None:
            return
        yield from self._coc_fill.steps(
            front.state,
            _IN_FRONT,
            blurring.disc.spreads,
            front.rows,
            front.coc,
            zone.tiles,
        )
        yield from self._blur.steps(*blurring.of(front.view, front.coc), zone.tiles)

    def _add_view(
        self,
        memory: _ViewMemory,
        zone: OverlapZone,
        total: Texture,
        part: NDArray[np.float64] | None,
    ) -> Iterator[None]:
        """Add the blurred view of a part to the sum; if `part` is None, begin the sum."""
        width, height = total.size
        positions = _NO_PART if part is None else part
        return self._bands.run(
            self._program("sum", memory.front is not None, len(positions)),
            (width + 1, height + 1),  # it also empties the lists of the cells between pixels
            _part_uniforms(positions) | zone.tiles.uniforms | {"is_first": part is None},
            textures=memory.summed_textures,
            images={"sum_img": total},
            buffers=zone.buffers | {"head_block": memory.heads},
        )

    def over(self, field: PartViews, out: Texture) -> None:
        """Write the mean view over its zones of `out`, which holds the layers blurred so far."""
        self._program("over").dispatch(
            pixel_groups(out.size),
            textures={"sum_tx": field.total, "zone_tx": field.zone.blocks},
            images={"out_color_img": out},
            uniforms=_WHOLLY_KNOWN if field.is_whole else _PARTLY_KNOWN,
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


def _part_uniforms(part: NDArray[np.float64]) -> dict[str, object]:
    """Return the uniform of lib/lens_part.lib.glsl for a part (positions, 4) of `lens_parts`."""
    positions = [tuple(position) for position in part]
    return {"lens_part": positions if len(positions) > 1 else positions[0]}
