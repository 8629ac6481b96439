"""List the tiles on which the views through parts of the lens are drawn."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.render.defocus.pixel_list import TileNumbers
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.gpu.resources import StorageBuffer
from heatlens.render.gpu.shader_constants import FAR_BLOCK, TILE


@dataclass(frozen=True)
class ViewTiles:
    """The tiles on which the passes of a view run.

    drawn   those in which the view is needed
    moved   those whose surfaces may move there
    cells   those of the cells around the pixels of the view (part_links.comp.glsl)
    reads   for each tile of cells, bits for the tiles of pixels that read it (part_links.comp.glsl)
    reads_across  how many tiles of cells are in a row
    """

    drawn: TileNumbers
    moved: TileNumbers
    cells: TileNumbers
    reads: StorageBuffer
    reads_across: int


def list_tiles(
    needed: NDArray[np.bool_], moved_px: float, name: str, scratch: Scratch
) -> ViewTiles:
    """Return lists of the `needed` tiles, of those within `moved_px` and of those of their cells.

    Pixels have cells at their right and below them too, so that there is a tile more.
    """
    moved, reads = needed, _reads_of(needed)
    margin = math.ceil((moved_px + 1) / TILE)  # a surface counts in the pixels around its position
    for axis in (0, 1):
        moved = np.moveaxis(_near_along(np.moveaxis(moved, axis, 0), margin, 1), 0, axis)
    marked = needed, moved, reads > 0
    memory = scratch.parts(f"{name} tile lists", len(marked) + 1, 4 * reads.size)
    numbers = [columns + (rows << 16) for rows, columns in map(np.nonzero, marked)]
    lists = [array.astype(np.uint32).tobytes() for array in (*numbers, reads)]
    memory.whole.write(b"".join(words.ljust(memory.part_bytes, b"\0") for words in lists))
    drawn, moved_there, cells = (
        TileNumbers(memory[n], len(array)) for n, array in enumerate(numbers)
    )
    return ViewTiles(drawn, moved_there, cells, memory[len(marked)], reads.shape[1])


def _reads_of(needed: NDArray[np.bool_]) -> NDArray[np.uint32]:
    """Return for each tile of cells (rows, columns) the bits of part_links.comp.glsl."""
    bits = np.pad(needed, 1).astype(np.uint32)
    before = bits[1:, :-1] << 1 | bits[:-1, 1:] << 2 | bits[:-1, :-1] << 3
    return np.asarray(bits[1:, 1:] | before, np.uint32)


def tiles_near(blocks: NDArray[np.bool_], margin_px: float) -> NDArray[np.bool_]:
    """Return which tiles (rows, columns) have one of the marked `blocks` within `margin_px`."""
    for axis in (0, 1):
        margin, side = math.ceil(margin_px / FAR_BLOCK), TILE // FAR_BLOCK
        blocks = _near_along(np.moveaxis(blocks, axis, 0), margin, side)
        blocks = np.moveaxis(blocks, 0, axis)
    return blocks


def _near_along(blocks: NDArray[np.bool_], margin: int, side: int) -> NDArray[np.bool_]:
    """Return for each tile along the first axis whether a marked block is within `margin` blocks.

    A tile has `side` blocks along that axis. The second axis stays in blocks.
    """
    # How many marked blocks lie before each block: a range has one if its ends differ.
    counts_before = np.concatenate([np.zeros((1, blocks.shape[1]), int), blocks.cumsum(axis=0)])
    first_blocks = np.arange(0, len(blocks), side)
    low, high = (
        np.clip(first_blocks + offset, 0, len(blocks)) for offset in (-margin, side + margin)
    )
    return np.asarray(counts_before[high] > counts_before[low])
