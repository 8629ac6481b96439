"""Divide the work on pixels into short steps, so that a window can answer in between.

Pictures are divided into bands of rows. Passes that process only some pixels or tiles read these
from lists (lib/pixel_list.lib.glsl, lib/tile_numbers.lib.glsl), which are divided into slices.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.resources import Buffer, StorageBuffer
from heatlens.render.gpu.shader_constants import PIXEL_GROUP, TILE

_GROUPS_MOST = 65535  # workgroups of a dispatch that every driver can run
BAND_PX = 1 << 18  # some ten milliseconds on two busy cores


# On a processor, a band takes about 20 ms. A pass over every pixel of 1280x720 in one piece took
# 100 to 190 ms, during which a window cannot answer. On a GPU each piece costs a dispatch and a
# barrier: a 1920x1080 frame took 166 of them with bands and slices; without them it takes 9, and 15
# for each layer.
class PixelBands:
    """Cuts pictures into bands of rows on a processor; a GPU gets them whole."""

    def __init__(self, ctx: Device) -> None:
        self._uses_bands = is_software(ctx)

    def run(
        self,
        program: ComputeProgram,
        size: tuple[int, int],
        uniforms: dict[str, object] | None = None,
        side: int = 1,
        group: int = PIXEL_GROUP,
        **inputs: Any,
    ) -> Iterator[None]:
        """Run on a picture of `size` invocations, and yield after each band.

        Each invocation has `side` x `side` pixels of the plate, and each workgroup `group` x
        `group` invocations. The shader adds the uniform `first_row` to the row of an invocation.
        """
        width, height = size
        most_rows = BAND_PX // (width * side * side) // group * group
        rows = max(group, most_rows) if self._uses_bands else height
        for first_row in range(0, height, rows):
            groups = groups_for(width, group), groups_for(min(rows, height - first_row), group)
            uniforms = {**(uniforms or {}), "first_row": first_row}
            program.dispatch(groups, uniforms=uniforms, **inputs)
            yield


@dataclass(frozen=True)
class TileNumbers:
    """A list of `count` tiles on the GPU (lib/tile_numbers.lib.glsl)."""

    words: StorageBuffer
    count: int


# A software rasterizer takes some 10 us for a workgroup that returns at once. Views of parts of the
# lens that were drawn on all tiles took 1.2 times as long as on lists of those that are needed.
class TileBands:
    """Runs passes on lists of tiles, in parts on a processor; a GPU gets each list whole."""

    def __init__(self, ctx: Device) -> None:
        self._most_tiles = BAND_PX // TILE**2 if is_software(ctx) else _GROUPS_MOST

    def run(
        self,
        program: ComputeProgram,
        tiles: TileNumbers,
        uniforms: dict[str, object],
        buffers: dict[str, StorageBuffer],
        **inputs: Any,
    ) -> Iterator[None]:
        """Run a workgroup of TILE x TILE invocations for each tile, and yield after each part."""
        inputs["buffers"] = {**buffers, "tile_number_block": tiles.words}
        for first_tile in range(0, tiles.count, self._most_tiles):
            groups = min(tiles.count - first_tile, self._most_tiles)
            program.dispatch((groups, 1), uniforms=uniforms | {"first_tile": first_tile}, **inputs)
            yield


WHOLE_LIST: dict[str, object] = {"list_slice": (0, 1)}  # see lib/list_slice.lib.glsl
# Workgroups x, y, z of the later pass, and a count; three times in lib/two_lists.lib.glsl.
_HEAD = struct.pack("12I", *(0, 1, 1, 0) * 3)
OF_FIRST, OF_SECOND, OF_BOTH = 0, 16, 32  # byte offsets of the workgroups of each list, and of both


def list_bytes(size: tuple[int, int]) -> int:
    """Return the bytes of a list with the capacity for every pixel of a picture."""
    return len(_HEAD) + 4 * size[0] * size[1]


def clear_list(pixels: Buffer) -> None:
    """Empty the list; call this before the pass that appends to it."""
    pixels.write(_HEAD)


class Slices:
    """Divides the work on a list of pixels, so that a window can answer in between.

    A GPU processes a whole list in less than a frame, and gets it in one piece.
    """

    # Pixels of the picture that a slice stands for: some ten milliseconds without a GPU.
    _PIXELS = 1 << 19

    def __init__(self, ctx: Device) -> None:
        self._uses_slices = is_software(ctx)

    def count(self, size: tuple[int, int]) -> int:
        """Return the number of slices for the lists of a picture of `size`; 1 on a GPU."""
        return max(1, -(-size[0] * size[1] // self._PIXELS)) if self._uses_slices else 1

    def of(self, size: tuple[int, int]) -> Iterator[dict[str, object]]:
        """Yield the uniform of each slice, see lib/list_slice.lib.glsl."""
        count = self.count(size)
        for index in range(count):
            yield {"list_slice": (index, count)}
