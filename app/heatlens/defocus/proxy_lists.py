"""Make the fragment lists of a reduced picture from those of the whole one, or from its edges."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import moderngl
import numpy as np

from heatlens.defocus.listed_fragments import FragmentBuffers
from heatlens.gpu.program import ComputeProgram, pixel_groups
from heatlens.model.focus.lean import LEVEL

FRAGMENT_BYTES = 12
_MORE_A_PIXEL = 2  # additional fragments per pixel, for pixels without a list among others
# Summed up in one dispatch: llvmpipe ends a loop silently after 65,535 rounds, 256 pixels in each.
_PIXELS_A_SUM = 1 << 22
_LISTS, _SILHOUETTES = "proxy_lists.comp.glsl", "proxy_silhouettes.comp.glsl"


@dataclass(frozen=True)
class ProxyListRoom:
    """Memory for the lists of a reduced picture.

    held      the lists, valid once `ProxyListsPass` has run
    capacity  number of fragments there is room for; lists beyond it are empty
    total     four bytes of scratch memory
    """

    held: FragmentBuffers
    capacity: int
    total: moderngl.Buffer


def proxy_list_capacity(
    ctx: moderngl.Context, whole: FragmentBuffers | None, size: tuple[int, int]
) -> int:
    """Return the number of fragments to reserve for a reduced picture of `size`."""
    most = int(ctx.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]) // FRAGMENT_BYTES
    pixels = size[0] * size[1]
    if whole is None:
        return min(pixels, most)  # every other pixel at a silhouette
    return min(whole.words.size // FRAGMENT_BYTES + _MORE_A_PIXEL * pixels, most)


class ProxyListsPass:
    """Lists the surfaces that each pixel of a reduced picture covers."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._merging, self._of_silhouettes = _Programs(ctx, _LISTS), _Programs(ctx, _SILHOUETTES)

    @cached_property
    def _starts(self) -> ComputeProgram:
        return ComputeProgram(self._ctx, "peel_starts.comp.glsl")

    def merge(
        self,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        whole: FragmentBuffers,
        room: ProxyListRoom,
        out_depth: moderngl.Texture,
    ) -> None:
        """Merge the lists of the pixels that each pixel of a reduced picture covers, to `room`.

        `out_depth` is the reduced depth in metres. Where a list begins with the visible surface,
        its depth is replaced by that of the nearest fragment.
        """
        read = {"start_block": whole.starts, "fragment_block": whole.words}
        uniforms = _whole_uniforms(whole) | {"is_measured": whole.is_measured}
        textures = {"color_tx": color, "depth_tx": depth}
        self._run(self._merging, textures, read, uniforms, room, out_depth)

    def list_silhouettes(
        self,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        places: moderngl.Texture,
        room: ProxyListRoom,
        out_depth: moderngl.Texture,
    ) -> None:
        """List the two surfaces of each reduced pixel at a silhouette of a plate without lists.

        `places` is the output of `ProxyPass`; highlights have no list. `out_depth` as for `merge`.
        """
        textures = {"color_tx": color, "depth_tx": depth, "places_tx": places}
        self._run(self._of_silhouettes, textures, {}, {}, room, out_depth)

    def _run(
        self,
        programs: "_Programs",
        textures: Mapping[str, moderngl.Texture],
        read: Mapping[str, moderngl.Buffer],
        uniforms: Mapping[str, object],
        room: ProxyListRoom,
        out_depth: moderngl.Texture,
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

    ctx: moderngl.Context
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
