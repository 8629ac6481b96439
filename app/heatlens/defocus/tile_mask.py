"""Mark the active tiles of a picture (lib/tile_mask.lib.glsl, lib/tile_list.lib.glsl)."""

from dataclasses import dataclass

from heatlens.gpu.program import StorageBuffer, groups_for
from heatlens.gpu.shader_constants import TILE, TILE_LIST_HEAD

TileCount = tuple[int, int]  # across, down


def tile_count(size: tuple[int, int]) -> TileCount:
    """Return how many tiles cover a picture of `size` (width, height)."""
    return groups_for(size[0], TILE), groups_for(size[1], TILE)


def seen_bytes(size: tuple[int, int]) -> int:
    """Return the bytes of a picture's visibility masks, whose lines are whole 32-bit words."""
    return 4 * sum(seen_words(size))


def seen_words(size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the words of the masks along each direction, as lib/hidden.lib.glsl counts them."""
    width, height = size
    down = groups_for(height, 32)
    diagonal = (width + height) * down
    return height * groups_for(width, 32), width * down, diagonal, diagonal


@dataclass(frozen=True)
class TileMask:
    """A word for each tile, row by row; 0 for tiles that are not active.

    rows, columns   the runs of active tiles along both axes (lib/line_segment.lib.glsl)
    """

    words: StorageBuffer
    tiles: TileCount
    rows: StorageBuffer
    columns: StorageBuffer

    @staticmethod
    def bytes_for(size: tuple[int, int]) -> int:
        """Return the bytes of the mask of a picture."""
        across, down = tile_count(size)
        return 4 * across * down

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms of the shader library."""
        return {"tiles_across": self.tiles[0]}


@dataclass(frozen=True)
class TileList:
    """The active tiles of a mask as a list, for passes with one workgroup per tile."""

    words: StorageBuffer

    OF_LAYER = 0  # byte offset in `words` of the workgroup counts for a pass over the layer
    OF_PICTURE = 12  # for a pass over the picture, `reduction` x `reduction` groups per tile

    @staticmethod
    def bytes_for(size: tuple[int, int]) -> int:
        """Return the bytes of a list with room for every tile of a picture."""
        return 4 * TILE_LIST_HEAD + TileMask.bytes_for(size)
