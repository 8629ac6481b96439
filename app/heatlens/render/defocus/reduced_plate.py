"""Reduce a plate to proxy size, and keep the reduced plate while lens and settings change.

The fragment lists of the reduced picture are made from those of the whole one, or from its edges.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from heatlens.core.model.focus.coc import LEVEL
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.render.defocus.cutout_pass import CutoutTextures
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.plate_passes import ProxyPass, proxy_size
from heatlens.render.defocus.quality import layers_for
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.device import Buffer, Device, Texture
from heatlens.render.gpu.program import ComputeProgram, pixel_groups

FRAGMENT_BYTES = 12
_MORE_A_PIXEL = 2  # additional fragments per pixel, for pixels without a list among others
# Summed up in one dispatch: llvmpipe ends a loop silently after 65,535 rounds, 256 pixels in each.
_PIXELS_A_SUM = 1 << 22
_LISTS, _SILHOUETTES = "defocus/proxy_lists.comp.glsl", "defocus/proxy_silhouettes.comp.glsl"


@dataclass(frozen=True)
class ProxyListRoom:
    """Memory for the lists of a reduced picture.

    held      the lists, valid once `ProxyListsPass` has run
    capacity  number of fragments there is room for; lists beyond it are empty
    total     four bytes of scratch memory
    """

    held: FragmentBuffers
    capacity: int
    total: Buffer


def proxy_list_capacity(ctx: Device, whole: FragmentBuffers | None, size: tuple[int, int]) -> int:
    """Return the number of fragments to reserve for a reduced picture of `size`."""
    most = ctx.limits.storage_block_bytes // FRAGMENT_BYTES
    pixels = size[0] * size[1]
    if whole is None:
        return min(pixels, most)  # every other pixel at a silhouette
    return min(whole.words.size // FRAGMENT_BYTES + _MORE_A_PIXEL * pixels, most)


class ProxyListsPass:
    """Lists the surfaces that each pixel of a reduced picture covers."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._merging, self._of_silhouettes = _Programs(ctx, _LISTS), _Programs(ctx, _SILHOUETTES)

    @cached_property
    def _starts(self) -> ComputeProgram:
        return ComputeProgram(self._ctx, "defocus/peel_starts.comp.glsl")

    def merge(
        self,
        color: Texture,
        depth: Texture,
        whole: FragmentBuffers,
        room: ProxyListRoom,
        out_depth: Texture,
    ) -> None:
        """Merge the lists of the pixels that each pixel of a reduced picture covers, to `room`.

        `out_depth` is the reduced depth in metres. Where a list begins with the visible surface,
        its depth is replaced by that of the nearest fragment.
        """
        read = {"start_block": whole.starts, "fragment_block": whole.words}
        uniforms = _whole_uniforms(whole) | {"is_measured": whole.is_measured}
        textures = {"color_tx": color, "depth_tx": depth}
        self._run(self._merging, textures, read, uniforms, room, out_depth)

    # A pixel of a small picture that holds a wire and the wall behind it had one depth, so that
    # both were blurred alike and wires stood sharp before a wall in focus. Listing both surfaces
    # lowered the FLIP between the preview during a drag and the picture at rest from .0759 to .0684
    # over 15 lenses, for 1.07 to 1.15 times the processor time.
    def list_silhouettes(
        self,
        color: Texture,
        depth: Texture,
        places: Texture,
        room: ProxyListRoom,
        out_depth: Texture,
    ) -> None:
        """List the two surfaces of each reduced pixel at a silhouette of a plate without lists.

        `places` is the output of `ProxyPass`; highlights have no list. `out_depth` as for `merge`.
        """
        textures = {"color_tx": color, "depth_tx": depth, "places_tx": places}
        self._run(self._of_silhouettes, textures, {}, {}, room, out_depth)

    def _run(
        self,
        programs: "_Programs",
        textures: Mapping[str, Texture],
        read: Mapping[str, Buffer],
        uniforms: Mapping[str, object],
        room: ProxyListRoom,
        out_depth: Texture,
    ) -> None:
        """Count the fragments of each list, sum them up, and write the lists to `room`."""
        size, counted = out_depth.size, {**read, "proxy_start_block": room.held.starts}
        groups, image = pixel_groups(size), {"depth_img": out_depth}
        sized = {**uniforms, "size": size}
        room.total.write(np.zeros(1, np.uint32))
        programs.count.dispatch(
            groups, textures=textures, images=image, buffers=counted, uniforms=sized
        )
        self._sum_up(room, size[0] * size[1])
        written = counted | {"proxy_fragment_block": room.held.words}
        programs.write.dispatch(
            groups, textures=textures, images=image, buffers=written, uniforms=sized
        )

    def _sum_up(self, room: ProxyListRoom, pixel_count: int) -> None:
        """Replace the length of each list by its start, in parts that every driver can do."""
        for first in range(0, pixel_count, _PIXELS_A_SUM):
            count = min(_PIXELS_A_SUM, pixel_count - first)
            self._starts.dispatch(
                (1, 1),
                buffers={"start_block": room.held.starts, "total_block": room.total},
                uniforms={
                    "first_pixel": first,
                    "pixel_count": count,
                    "capacity": room.capacity,
                    "has_end": first + count == pixel_count,
                },
            )


@dataclass(frozen=True)
class _Programs:
    """The two builds of a shader that makes lists, compiled on first use."""

    ctx: Device
    shader: str

    @cached_property
    def count(self) -> ComputeProgram:
        return ComputeProgram(self.ctx, self.shader, {"COUNT": 1})

    @cached_property
    def write(self) -> ComputeProgram:
        return ComputeProgram(self.ctx, self.shader)


def _whole_uniforms(whole: FragmentBuffers) -> dict[str, object]:
    """Return the uniforms of the lists, with dioptres instead of coc."""
    return {
        "lists_origin": whole.origin,
        "lists_stride": whole.stride or whole.size[0],
        "fragment_line": (0.0, 1.0),
        **LEVEL.uniforms(1.0),
        "is_open": False,
        "is_alpha": False,
    }


_NOTHING_HELD = 1.0, False


@dataclass(frozen=True)
class PlateTextures:
    """A plate on the GPU.

    color      RGBA, scene-linear
    depth      metres, or signed coc in pixels for a plate that has no distances
    fragments  the surfaces along the ray of each pixel; None if the plate has no lists
    places     RGBA, subpixel positions of the light; None if they are not known
    cutout     what is kept from the blur; None if all is blurred
    """

    color: Texture
    depth: Texture
    fragments: FragmentBuffers | None = None
    places: Texture | None = None
    cutout: CutoutTextures | None = None


class ReducedPlate:
    """The plate at proxy size, in textures that live from picture to picture."""

    def __init__(self, ctx: Device, plate_pass: ProxyPass, lists_pass: ProxyListsPass) -> None:
        self._ctx = ctx
        self._pass = plate_pass
        self._lists_pass = lists_pass
        self._held = _NOTHING_HELD  # scale of the plate that is kept, and whether it has lists

    def steps(
        self, whole: PlateTextures, optics: Optics, settings: DefocusSettings, scratch: Scratch
    ) -> Steps[PlateTextures]:
        """Return the plate at the scale of `settings`; reduce it only if that has yet to be done.

        A plate without lists gets some at its silhouettes, if its depth and the method allow it.
        """
        proxy = settings.proxy
        size = proxy_size(whole.color.size, proxy)
        color = scratch.texture("proxy colour", size, 4)
        depth = scratch.texture("proxy depth", size, 1)
        places = scratch.texture("proxy places", size, 4, "f2")
        has_lists = optics.line is not None and layers_for(settings) > 1
        room = self._room(whole.fragments, size, scratch) if has_lists else None
        cutout = None if whole.cutout is None else _cutout_room(whole.cutout, size, scratch)
        if self._held != (proxy, has_lists):
            scale = proxy if optics.line is None else 1.0
            self._pass.run(whole.color, whole.depth, scale, color, depth, places)
            if room is not None:
                self._list(whole, places, room, depth)
            if whole.cutout is not None and cutout is not None:
                for light, out in cutout.lights_of(whole.cutout):
                    self._pass.run(light, whole.cutout.depth, scale, out, cutout.depth)
            self._held = proxy, has_lists
            yield scratch.passed("proxy")
        return PlateTextures(color, depth, None if room is None else room.held, places, cutout)

    def _list(
        self,
        whole: PlateTextures,
        places: Texture,
        room: ProxyListRoom,
        depth: Texture,
    ) -> None:
        if whole.fragments is None:
            self._lists_pass.list_silhouettes(whole.color, whole.depth, places, room, depth)
        else:
            self._lists_pass.merge(whole.color, whole.depth, whole.fragments, room, depth)

    def _room(
        self, fragments: FragmentBuffers | None, size: tuple[int, int], scratch: Scratch
    ) -> ProxyListRoom:
        capacity = proxy_list_capacity(self._ctx, fragments, size)
        starts = scratch.buffer("proxy starts", 4 * (size[0] * size[1] + 1))
        words = scratch.buffer("proxy fragments", FRAGMENT_BYTES * capacity)
        held = FragmentBuffers(
            starts,
            words,
            size,
            is_measured=fragments is None or fragments.is_measured,
            is_exact=fragments is None or fragments.is_exact,
        )
        return ProxyListRoom(held, capacity, scratch.buffer("proxy fragment count", 4))

    def forget(self) -> None:
        """Forget the reduced plate, because the plate's textures have new content."""
        self._held = _NOTHING_HELD


def _cutout_room(whole: CutoutTextures, size: tuple[int, int], scratch: Scratch) -> CutoutTextures:
    """Return a cutout of another size, but with the same rest, which is reduced as a plate is."""
    return replace(
        whole,
        light=scratch.texture("proxy cutout", size, 4),
        alpha=None if whole.alpha is None else scratch.texture("proxy cutout alpha", size, 4),
        depth=scratch.texture("proxy cutout depth", size, 1),
        ground=None if whole.ground is None else scratch.texture("proxy ground", size, 4),
    )
