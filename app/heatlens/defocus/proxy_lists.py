"""Make the fragment lists of a reduced picture from those of the whole one."""

from dataclasses import dataclass
from functools import cached_property

import moderngl
import numpy as np

from heatlens.defocus.listed_fragments import FragmentBuffers
from heatlens.gpu.program import ComputeProgram, pixel_groups
from heatlens.model.lean import LEVEL

FRAGMENT_BYTES = 12
_MORE_A_PIXEL = 2  # additional fragments per pixel, for pixels without a list among others
# Summed up in one dispatch: llvmpipe ends a loop silently after 65,535 rounds, 256 pixels in each.
_PIXELS_A_SUM = 1 << 22
_SHADER = "proxy_lists.comp.glsl"


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
    ctx: moderngl.Context, whole: FragmentBuffers, size: tuple[int, int]
) -> int:
    """Return the number of fragments to reserve for a reduced picture of `size`."""
    most = int(ctx.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]) // FRAGMENT_BYTES
    return min(whole.words.size // FRAGMENT_BYTES + _MORE_A_PIXEL * size[0] * size[1], most)


class ProxyListsPass:
    """Merges the lists of the pixels that each pixel of a reduced picture covers."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx

    @cached_property
    def _count(self) -> ComputeProgram:
        return ComputeProgram(self._ctx, _SHADER, {"COUNT": 1})

    @cached_property
    def _starts(self) -> ComputeProgram:
        return ComputeProgram(self._ctx, "peel_starts.comp.glsl")

    @cached_property
    def _write(self) -> ComputeProgram:
        return ComputeProgram(self._ctx, _SHADER)

    def run(
        self,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        whole: FragmentBuffers,
        room: ProxyListRoom,
        out_depth: moderngl.Texture,
    ) -> None:
        """Write the lists of a picture of the size of `out_depth` to `room`.

        `out_depth` is the reduced depth in metres. Where a list begins with the visible surface,
        its depth is replaced by that of the nearest fragment.
        """
        groups, size, out = pixel_groups(out_depth.size), out_depth.size, room.held
        textures = {"color_tx": color, "depth_tx": depth}
        read = {"start_block": whole.starts, "fragment_block": whole.words}
        uniforms = _whole_uniforms(whole) | {"size": size, "is_measured": whole.is_measured}
        room.total.write(np.zeros(1, np.uint32))
        counted = read | {"proxy_start_block": out.starts}
        image = {"depth_img": out_depth}
        self._count.dispatch(
            groups, textures=textures, images=image, buffers=counted, uniforms=uniforms
        )
        self._sum_up(room, size[0] * size[1])
        self._write.dispatch(
            groups,
            textures=textures,
            images=image,
            buffers=counted | {"proxy_fragment_block": out.words},
            uniforms=uniforms,
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
