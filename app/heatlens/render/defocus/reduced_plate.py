"""Reduce a plate to proxy size, and keep the reduced plate while lens and settings change.

The fragment lists of the reduced picture are made from those of the whole one, or from its edges.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from heatlens.core.model.focus.focus_offset import LEVEL
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.render.defocus.cutout_pass import CutoutTextures
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.plate_passes import ProxyPass, proxy_size
from heatlens.render.defocus.quality import layers_for
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Buffer, Texture

FRAGMENT_BYTES = 12  # bytes of a fragment in a list
_EXTRA_PER_PIXEL = 2  # additional fragments per pixel, for pixels without a list among others
# Summed up in one dispatch: llvmpipe ends a loop silently after 65,535 rounds, 256 pixels in each.
_PIXELS_PER_SUM = 1 << 22


@dataclass(frozen=True)
class ProxyListMemory:
    """Memory for the lists of a reduced picture.

    lists     the lists, valid once `ProxyListsPass` has run
    capacity  largest number of fragments; lists for which there is no memory left are empty
    total     four bytes of scratch memory
    """

    lists: FragmentBuffers
    capacity: int
    total: Buffer


def proxy_list_capacity(
    ctx: Device, full_size: FragmentBuffers | None, size: tuple[int, int]
) -> int:
    """Return the number of fragments to reserve for a reduced picture of `size`."""
    most = ctx.limits.storage_block_bytes // FRAGMENT_BYTES
    pixels = size[0] * size[1]
    if full_size is None:
        return min(pixels, most)  # every other pixel at a silhouette
    return min(full_size.words.size // FRAGMENT_BYTES + _EXTRA_PER_PIXEL * pixels, most)


class ProxyListsPass:
    """Lists the surfaces that each pixel of a reduced picture covers."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._lists = ComputeProgram(ctx, "defocus/proxy_lists.comp.glsl")
        self._silhouettes = ComputeProgram(ctx, "defocus/proxy_silhouettes.comp.glsl")
        self._starts = ComputeProgram(ctx, "defocus/peel_starts.comp.glsl")

    def merge(
        self,
        color: Texture,
        depth: Texture,
        full_size: FragmentBuffers,
        memory: ProxyListMemory,
        out_depth: Texture,
    ) -> None:
        """Merge the lists of the pixels that each pixel of a reduced picture covers, to `memory`.

        `out_depth` is the reduced depth in meters. Where a list begins with the visible surface,
        its depth is replaced by that of the nearest fragment.
        """
        list_inputs = {"start_block": full_size.starts, "fragment_block": full_size.words}
        uniforms = _full_size_uniforms(full_size) | {"is_measured": full_size.is_measured}
        textures = {"color_tx": color, "depth_tx": depth}
        self._run(self._lists, textures, list_inputs, uniforms, memory, out_depth)

    # A reduced pixel can contain two surfaces, such as a wire and the wall behind it. Both are
    # listed, each with its own depth; with one depth they would be blurred alike, and wires would
    # stand sharp before a wall in focus. FLIP between the preview during a drag and the picture at
    # rest: .0684 instead of .0759 over 15 lenses, for 1.07 to 1.15 times the processor time.
    def list_silhouettes(
        self,
        color: Texture,
        depth: Texture,
        positions: Texture,
        memory: ProxyListMemory,
        out_depth: Texture,
    ) -> None:
        """List the two surfaces of each reduced pixel at a silhouette of a plate without lists.

        `positions`, those of the light of highlights, are the output of `ProxyPass`; highlights
        have no list. `out_depth` is as for `merge`.
        """
        textures = {"color_tx": color, "depth_tx": depth, "positions_tx": positions}
        self._run(self._silhouettes, textures, {}, {}, memory, out_depth)

    def _run(
        self,
        program: ComputeProgram,
        textures: Mapping[str, Texture],
        list_inputs: Mapping[str, Buffer],
        uniforms: Mapping[str, object],
        memory: ProxyListMemory,
        out_depth: Texture,
    ) -> None:
        """Count the fragments of each list, sum them up, and write the lists to `memory`.

        `program` has a version that only counts. `out_depth` gives the size of the
        reduced picture, and is changed as `merge` says.
        """
        size = out_depth.size
        count_buffers = {**list_inputs, "proxy_start_block": memory.lists.starts}
        groups, images = pixel_groups(size), {"depth_img": out_depth}
        sized_uniforms = {**uniforms, "size": size}
        memory.total.write(np.zeros(1, np.uint32))
        program.version(COUNT=True).dispatch(
            groups, textures=textures, images=images, buffers=count_buffers, uniforms=sized_uniforms
        )
        self._sum_up(memory, size[0] * size[1])
        write_buffers = count_buffers | {"proxy_fragment_block": memory.lists.words}
        program.dispatch(
            groups, textures=textures, images=images, buffers=write_buffers, uniforms=sized_uniforms
        )

    def _sum_up(self, memory: ProxyListMemory, pixel_count: int) -> None:
        """Replace the length of each list by its start, in parts that every driver can do.

        A start is the number of fragments in all lists before it.
        """
        for first_pixel in range(0, pixel_count, _PIXELS_PER_SUM):
            count = min(_PIXELS_PER_SUM, pixel_count - first_pixel)
            self._starts.dispatch(
                (1, 1),
                buffers={"start_block": memory.lists.starts, "total_block": memory.total},
                uniforms={
                    "first_pixel": first_pixel,
                    "pixel_count": count,
                    "capacity": memory.capacity,
                    "has_end": first_pixel + count == pixel_count,
                },
            )


def _full_size_uniforms(full_size: FragmentBuffers) -> dict[str, object]:
    """Return the uniforms of the lists, with dioptres instead of coc."""
    return {
        "lists_origin": full_size.origin,
        "lists_stride": full_size.stride or full_size.size[0],
        "fragment_line": (0.0, 1.0),
        **LEVEL.uniforms(1.0),
        "is_open": False,
        "is_alpha": False,
    }


_NOTHING_REDUCED = 1.0, False  # the state of `ReducedPlate` without a reduced plate


@dataclass(frozen=True)
class PlateTextures:
    """A plate on the GPU.

    color      RGBA, scene-linear
    depth      meters, or signed coc in pixels for a plate that has no distances
    fragments  the surfaces along the ray of each pixel; None if the plate has no lists
    positions  RGBA, subpixel positions of the light; None if they are not known
    cutout     the part that stays sharp; None if all is blurred
    """

    color: Texture
    depth: Texture
    fragments: FragmentBuffers | None = None
    positions: Texture | None = None
    cutout: CutoutTextures | None = None


class ReducedPlate:
    """The plate at proxy size, in textures that live from picture to picture."""

    def __init__(self, ctx: Device, plate_pass: ProxyPass, lists_pass: ProxyListsPass) -> None:
        self._ctx = ctx
        self._pass = plate_pass
        self._lists_pass = lists_pass
        self._reduced_state = (
            _NOTHING_REDUCED  # scale of the plate that is kept, and whether it has lists
        )

    def steps(
        self, full_size: PlateTextures, optics: Optics, settings: DefocusSettings, scratch: Scratch
    ) -> Steps[PlateTextures]:
        """Return the plate at the scale of `settings`; reduce it only if that was not done before.

        A plate without lists gets some at its silhouettes, if its depth and the method allow it.
        """
        proxy = settings.proxy
        size = proxy_size(full_size.color.size, proxy)
        color = scratch.texture("proxy colour", size, 4)
        depth = scratch.texture("proxy depth", size, 1)
        positions = scratch.texture("proxy positions", size, 4, "f2")
        has_lists = optics.line is not None and layers_for(settings) > 1
        memory = self._allocate_lists(full_size.fragments, size, scratch) if has_lists else None
        cutout = (
            None if full_size.cutout is None else _allocate_cutout(full_size.cutout, size, scratch)
        )
        if self._reduced_state != (proxy, has_lists):
            scale = proxy if optics.line is None else 1.0  # coc in pixels shrinks with the picture
            self._pass.run(full_size.color, full_size.depth, scale, color, depth, positions)
            if memory is not None:
                self._write_lists(full_size, positions, memory, depth)
            if full_size.cutout is not None and cutout is not None:
                for light, out in cutout.lights_of(full_size.cutout):
                    self._pass.run(light, full_size.cutout.depth, scale, out, cutout.depth)
            self._reduced_state = proxy, has_lists
            yield scratch.end_pass("proxy")
        return PlateTextures(
            color, depth, None if memory is None else memory.lists, positions, cutout
        )

    def _write_lists(
        self, full_size: PlateTextures, positions: Texture, memory: ProxyListMemory, depth: Texture
    ) -> None:
        """Write the lists of the reduced plate from those of the plate, or from its silhouettes."""
        if full_size.fragments is None:
            self._lists_pass.list_silhouettes(
                full_size.color, full_size.depth, positions, memory, depth
            )
        else:
            self._lists_pass.merge(
                full_size.color, full_size.depth, full_size.fragments, memory, depth
            )

    def _allocate_lists(
        self, fragments: FragmentBuffers | None, size: tuple[int, int], scratch: Scratch
    ) -> ProxyListMemory:
        """Return the memory for the lists of a reduced picture of `size`."""
        capacity = proxy_list_capacity(self._ctx, fragments, size)
        starts = scratch.buffer("proxy starts", 4 * (size[0] * size[1] + 1))
        words = scratch.buffer("proxy fragments", FRAGMENT_BYTES * capacity)
        # lists made from the silhouettes of the picture itself need not be matched to it
        lists = FragmentBuffers(
            starts,
            words,
            size,
            is_measured=fragments is None or fragments.is_measured,
            is_exact=fragments is None or fragments.is_exact,
        )
        return ProxyListMemory(lists, capacity, scratch.buffer("proxy fragment count", 4))

    def forget(self) -> None:
        """Forget the reduced plate, because the plate's textures have new content."""
        self._reduced_state = _NOTHING_REDUCED


def _allocate_cutout(
    full_size: CutoutTextures, size: tuple[int, int], scratch: Scratch
) -> CutoutTextures:
    """Return memory for a cutout at another size; the rest of its picture is reduced as a plate.

    `lights_of` and the pass of the plate fill it afterwards.
    """
    return replace(
        full_size,
        light=scratch.texture("proxy cutout", size, 4),
        alpha=None if full_size.alpha is None else scratch.texture("proxy cutout alpha", size, 4),
        depth=scratch.texture("proxy cutout depth", size, 1),
        backdrop=None if full_size.backdrop is None else scratch.texture("proxy ground", size, 4),
    )
