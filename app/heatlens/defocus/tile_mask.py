"""Which tiles of a picture are worked on (lib/tile_mask.lib.glsl, lib/tile_list.lib.glsl)."""

import struct
from dataclasses import dataclass

import moderngl

from heatlens.gpu.program import groups_for
from heatlens.gpu.shader_constants import TILE

_LIST_HEAD = struct.Struct("7I")  # workgroups x, y, z of both passes; count
_ALL = b"\xff" * 4  # a word: its tile is worked on
TileCount = tuple[int, int]  # across, down


def tile_count(size: tuple[int, int]) -> TileCount:
    """Return how many tiles cover a picture of `size` (width, height)."""
    return groups_for(size[0], TILE), groups_for(size[1], TILE)


@dataclass(frozen=True)
class TileMask:
    """A word a tile, row by row; 0: nothing is to be done there."""

    words: moderngl.Buffer
    tiles: TileCount

    @staticmethod
    def bytes_for(size: tuple[int, int]) -> int:
        """Return the bytes of the words for a picture."""
        across, down = tile_count(size)
        return 4 * across * down

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms as the shaders take them."""
        return {"tiles_across": self.tiles[0]}


@dataclass(frozen=True)
class TileList:
    """The tiles of a mask one by one, for passes with a workgroup a tile."""

    words: moderngl.Buffer

    OF_LAYER = 0  # where the workgroups stand of a pass over the layer, as bytes into `words`,
    OF_PICTURE = 12  # and of one over the picture, `reduction` times `reduction` to a tile

    @staticmethod
    def bytes_for(size: tuple[int, int]) -> int:
        """Return the bytes of a list that can hold every tile of a picture."""
        return _LIST_HEAD.size + TileMask.bytes_for(size)

    def clear(self, reduction: int) -> None:
        """Empty the list; before the pass that appends to it."""
        self.words.write(_LIST_HEAD.pack(0, 1, 1, 0, reduction, reduction, 0))


class WholePictures:
    """Masks of every tile of a picture, made once a size."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._words = ctx.buffer(_ALL)

    def mask(self, size: tuple[int, int]) -> TileMask:
        """Return all tiles of a picture of `size`."""
        need = TileMask.bytes_for(size)
        if self._words.size < need:
            self._words.orphan(need)
            self._words.write(_ALL * (need // len(_ALL)))
        return TileMask(self._words, tile_count(size))

    def release(self) -> None:
        """Give the memory back."""
        self._words.release()
