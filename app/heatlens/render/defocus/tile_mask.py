"""Mark the active tiles of a picture (lib/tile_mask.lib.glsl, lib/tile_list.lib.glsl).

The runs of active tiles along its lines are what `PartitionSolver` solves.
"""

from dataclasses import dataclass

from heatlens.core.model.shot.settings import LAYERS_MAX
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, blocks_for, groups_for
from heatlens.render.gpu.resources import Buffer, StorageBuffer, Texture
from heatlens.render.gpu.shader_constants import (
    HIDDEN_DIRECTIONS,
    SOLVER_SLOTS,
    TILE,
    TILE_LIST_HEAD,
    WORD_GROUP,
)
from heatlens.render.gpu.textures import BufferParts

TileCount = tuple[int, int]  # across, down


def tile_count(size: tuple[int, int]) -> TileCount:
    """Return how many tiles cover a picture of `size` (width, height)."""
    return blocks_for(size, TILE)


def visibility_words(size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the 32-bit words of the visibility mask along each of four directions.

    A mask has a bit for each pixel, and each of its lines fills whole words. The directions are
    rows, columns and both diagonals, as in lib/hidden.lib.glsl.
    """
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
        """Return the bytes of a list with the capacity for every tile of a picture."""
        return 4 * TILE_LIST_HEAD + TileMask.bytes_for(size)


_ACTIVE_WORD = b"\xff" * 4  # the word of an active tile
_MASKS_MAX = 8  # largest number of masks of whole pictures in the cache
RUN_LEAST = 4  # pixels per invocation, which fit the registers of a GPU
_HEAD_BYTES, _SEGMENT_BYTES = 16, 8


def run_length(length_px: int) -> int:
    """Return how many pixels of a line of `length_px` each invocation of a workgroup solves.

    It is a power of two, the same for all lengths in the same number of tiles.
    """
    run = RUN_LEAST
    while run * SOLVER_SLOTS < -(-length_px // TILE) * TILE:
        run *= 2
    return run


# A workgroup of the partition solver takes a run of active tiles, in as many neighboring lines as
# it has invocations for. Columns then load coalesced, and few invocations are idle. Most tiles of a
# whole line are inactive: NVIDIA H200, film, with whole lines 1280x720 4.6 ms, with runs 3.3 ms;
# 3840x2160 33.2 -> 10.8 ms.
class SegmentPass:
    """Lists the segments of all layers in one dispatch."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/line_segments.comp.glsl")

    @staticmethod
    def bytes_for(size: tuple[int, int]) -> int:
        """Return the bytes of a list: no picture has more segments than tiles."""
        return _HEAD_BYTES + _SEGMENT_BYTES * (TileMask.bytes_for(size) // 4)

    def find(
        self, sizes: list[tuple[int, int]], masks: BufferParts, lists: BufferParts
    ) -> list[TileMask]:
        """Return the masks of layers of these `sizes`, with the runs of their active tiles.

        `masks` has the words of each layer. `lists` is memory with two parts for each layer, one
        for the runs in rows and one for those in columns.
        """
        tiles = [tile_count(size) for size in sizes]
        layers = [
            (*count, *(run_length(length) for length in size))
            for count, size in zip(tiles, sizes, strict=True)
        ]
        self._program.dispatch(
            (2 * len(sizes), 1),
            buffers={"tile_mask_block": masks.whole, "segment_list_block": lists.whole},
            uniforms={
                "layers": (*layers, *((0,) * 4,) * (2 * LAYERS_MAX - len(layers))),
                "tile_words": masks.words,
                "list_words": lists.words,
            },
        )
        return [
            TileMask(words=masks[n], tiles=count, rows=lists[2 * n], columns=lists[2 * n + 1])
            for n, count in enumerate(tiles)
        ]

    def release(self) -> None:
        """Release the program."""
        self._program.release()


@dataclass(frozen=True)
class VisiblePixels:
    """Which pixels of a layer are visible (lib/visible_bits.lib.glsl): `bytes_for` each.

    bits    a bit for each pixel, in four directions
    words   for each word of these, the next ones in its line in which any bit is set
    """

    bits: Buffer
    words: Buffer

    @staticmethod
    def bytes_for(size: tuple[int, int]) -> int:
        """Return the bytes of a picture's masks, in all four directions."""
        return 4 * sum(visibility_words(size))

    @property
    def buffers(self) -> dict[str, Buffer]:
        """The storage blocks of the shader library."""
        return {"bits_block": self.bits, "words_block": self.words}


# Words are written whole, each by the pixels that it stands for: 64 -> 38 ms of a film frame with
# known surfaces, of which 50 were to clear the bits of hidden pixels one by one. With the numbers
# of the next words, no search is longer than two words: guesses took 700 -> 580 ms of that frame.
class VisiblePass:
    """Marks the visible pixels of a layer, to find those nearest to a hidden one."""

    def __init__(self, ctx: Device) -> None:
        self._bits, self._words = (
            ComputeProgram(ctx, f"defocus/visible_{name}.comp.glsl") for name in ("bits", "words")
        )

    def mark(
        self,
        color: Texture,
        size: tuple[int, int],
        mask: TileMask,
        out: VisiblePixels,
        are_hidden_visible: bool = False,
    ) -> None:
        """Mark the pixels of a layer of `size` that are visible in the active tiles of `mask`.

        `color` is that of a `Layer`. With `are_hidden_visible` all pixels in active tiles are.
        """
        words, lines = max(visibility_words(size)), sum(size)  # there are as many diagonals
        self._bits.dispatch(
            (groups_for(words, WORD_GROUP), HIDDEN_DIRECTIONS),
            textures={"layer_tx": color},
            buffers={"bits_block": out.bits, "tile_mask_block": mask.words},
            uniforms=mask.uniforms | {"layer_size": size, "are_hidden_visible": are_hidden_visible},
        )
        self._words.dispatch(
            (groups_for(lines, WORD_GROUP), HIDDEN_DIRECTIONS),
            buffers=out.buffers,
            uniforms={"layer_size": size},
        )


class WholePictures:
    """Masks with all tiles active, of the sizes that were used last."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._segments: SegmentPass | None = None
        self._masks: dict[TileCount, TileMask] = {}
        self._buffers: list[Buffer] = []

    def mask(self, size: tuple[int, int]) -> TileMask:
        """Return the mask of all tiles of a picture of `size`."""
        tiles = tile_count(size)
        if tiles not in self._masks:
            if len(self._masks) >= _MASKS_MAX:
                self._forget()
            self._masks[tiles] = self._make_mask(size)
        return self._masks[tiles]

    def _make_mask(self, size: tuple[int, int]) -> TileMask:
        """Return a new mask with all tiles of a picture of `size` active."""
        self._segments = self._segments or SegmentPass(self._ctx)
        words = self._ctx.buffer(_ACTIVE_WORD * (TileMask.bytes_for(size) // len(_ACTIVE_WORD)))
        part_bytes = BufferParts.bytes_for(SegmentPass.bytes_for(size))
        lists = self._ctx.buffer(reserve=2 * part_bytes)
        self._buffers += words, lists
        masks = BufferParts(words, words.size)
        (mask,) = self._segments.find([size], masks, BufferParts(lists, part_bytes))
        return mask

    def _forget(self) -> None:
        """Release the buffers of all masks."""
        for buffer in self._buffers:
            buffer.release()
        self._buffers.clear()
        self._masks.clear()

    def release(self) -> None:
        """Release the memory."""
        self._forget()
        if self._segments is not None:
            self._segments.release()
            self._segments = None
