"""Merge highlights into a bounded list of discs."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from heatlens.render.defocus.highlights.highlight_split import WithoutHighlights, block_count
from heatlens.render.defocus.listed_fragments import list_buffers, list_uniforms
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import PixelBands, Slices, clear_list, list_bytes
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, blocks_for, groups_for, pixel_groups
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.shader_constants import HIGHLIGHT_BLOCK, HIGHLIGHT_GROUP, HIGHLIGHT_LEVELS
from heatlens.render.gpu.textures import OpeningTextures

SPRITES_MAX = 4096  # largest number of discs in a picture
SMALL_SPRITES_MAX = 8192  # the same if together they are small (highlight_plan.comp.glsl)
_AREA_MAX = 24.0  # pixels drawn per pixel of the picture: hundreds of discs a third as wide
_SPRITE_BYTES = 48  # bytes of a disc in the list
PLAN_BYTES = 4 * (9 + 2 * HIGHLIGHT_LEVELS)  # bytes of `Plan`, which highlight_plan writes


@dataclass(frozen=True)
class HighlightBuffers:
    """Scratch memory of the highlight passes. Levels are those at which highlights are merged.

    tally   how many discs each block of pixels has, for each level
    plan    the chosen level and the arguments of later dispatches (highlight_plan.comp.glsl)
    row     how many discs each row of blocks has, for each level; then where its discs begin
    sprite  the list of discs
    blocks  the list of blocks that hold highlights
    """

    tally: Buffer
    plan: Buffer
    row: Buffer
    sprite: Buffer
    blocks: Buffer

    @staticmethod
    def sizes(size: tuple[int, int]) -> dict[str, int]:
        """Return the bytes of each buffer for a picture."""
        blocks = block_count(size)
        return {
            "tally": 4 * HIGHLIGHT_LEVELS * blocks,
            "plan": PLAN_BYTES,
            "row": 4 * HIGHLIGHT_LEVELS * groups_for(size[1], HIGHLIGHT_BLOCK),
            "sprite": _SPRITE_BYTES * SMALL_SPRITES_MAX,
            "blocks": list_bytes((blocks, 1)),
        }


# Highlights are merged in blocks, at several levels, because drawing needs a limit, in discs and in
# area. The plan takes the finest level that fits. Before bright surfaces are put back, lamps are
# merged as far as their discs allow: a street at night, with large lamps among sparks, FLIP .0271
# -> .0253. Small discs may be more, because lamps of 16 px behind leaves had dotted rims where they
# were merged. Merging runs only on listed blocks that hold light (102 -> 21 ms with 1,600 discs).
# It writes the discs in the order of the picture, in whatever order the invocations run.
class HighlightListPass:
    """Merges highlights into a bounded list of discs, in the order of the picture."""

    def __init__(self, ctx: Device) -> None:
        sprites = "defocus/highlight_sprites.comp.glsl"
        self._find = ComputeProgram(ctx, "defocus/highlight_blocks.comp.glsl")
        count = {"COUNT": 1}
        if not is_software(ctx):  # a GPU waits for the slowest invocation
            count["LEVELS_AT_ONCE"] = HIGHLIGHT_LEVELS
        self._count = ComputeProgram(ctx, sprites, count)
        self._plan = ComputeProgram(ctx, "defocus/highlight_plan.comp.glsl")
        self._write = ComputeProgram(ctx, sprites)
        self._restore = ComputeProgram(ctx, "defocus/highlight_restore.comp.glsl")
        self._bands, self._slices = PixelBands(ctx), Slices(ctx)
        self._openings = OpeningTextures(ctx)

    def steps(
        self,
        split: WithoutHighlights,
        optics: Optics,
        buffers: HighlightBuffers,
        coc: Texture,
        positions: Texture | None = None,
        enlarged: int = 1,
    ) -> Iterator[None]:
        """Fill the list of discs in `buffers`; put highlights back if there are too many.

        They will be drawn in a target that is `enlarged` times as large. `coc` is the signed coc of
        the picture. `positions`, RGBA of the picture's size, has the position of each light in its
        pixel; None if it is not known.
        """
        size = split.highlights.size
        plan_buffers = {"plan_block": buffers.plan, "row_block": buffers.row}
        block_buffers = plan_buffers | {
            "tally_block": buffers.tally,
            "pixel_list_block": buffers.blocks,
            "lit_block": split.lit,
        }
        clear_list(buffers.blocks)
        yield from self._find_blocks(size, block_buffers)
        textures = {"highlight_tx": split.highlights, "positions_tx": positions or split.highlights}
        merge_steps = partial(
            self._run_on_blocks,
            textures=textures | self._openings.of(optics.disc.aperture),
            buffers=block_buffers | {"sprite_block": buffers.sprite},
            uniforms=optics.disc.uniforms
            | {"has_positions": positions is not None}
            | {"area_max": _AREA_MAX * size[0] * size[1] / enlarged},
        )
        # Count the discs of every level of merging, choose a level, then write the discs of that.
        count = self._count.version(**optics.disc.switches)
        write = self._write.version(**optics.disc.switches)
        yield from merge_steps(count, size)
        self._plan.dispatch((1, 1), buffers=plan_buffers, uniforms=_plan_uniforms(size))
        yield
        yield from merge_steps(write, size)
        self._put_back(split, buffers, coc)
        yield

    def _find_blocks(self, size: tuple[int, int], buffers: dict[str, Buffer]) -> Iterator[None]:
        """List the blocks of a picture of `size` that hold light."""
        find_uniforms: dict[str, object] = {"picture_size": size}
        return self._bands.run(
            *(self._find, blocks_for(size, HIGHLIGHT_BLOCK)),
            find_uniforms,
            side=HIGHLIGHT_BLOCK,
            group=HIGHLIGHT_GROUP,
            buffers=buffers,
        )

    def _run_on_blocks(
        self,
        program: ComputeProgram,
        size: tuple[int, int],
        buffers: dict[str, Buffer],
        uniforms: dict[str, object],
        **inputs: Any,
    ) -> Iterator[None]:
        """Run `program` on the listed blocks of a picture of `size`, in slices."""
        for slice_uniforms in self._slices.of(size):
            program.dispatch(
                buffers["pixel_list_block"],
                buffers=buffers,
                uniforms=uniforms | slice_uniforms,
                **inputs,
            )
            yield

    def _put_back(self, split: WithoutHighlights, buffers: HighlightBuffers, coc: Texture) -> None:
        """Add the highlights to the diffuse light again, if the plan says that they are too many.

        The plan holds the number of workgroups at its byte 20; it is 0 if nothing is put back.
        """
        lists, textures = split.lists, {"highlight_tx": split.highlights}
        source_lists = None if lists is None else lists.with_highlights
        plan_buffers = {"tally_block": buffers.tally, "plan_block": buffers.plan}
        self._restore.version(LISTS=lists is not None).dispatch(
            buffers.plan,
            offset=20,
            textures=textures if lists is None else textures | {"coc_tx": coc},
            images={"diffuse_img": split.diffuse},
            buffers=list_buffers(source_lists) | split.buffers | plan_buffers,
            uniforms=list_uniforms(source_lists),
        )


def _plan_uniforms(size: tuple[int, int]) -> dict[str, object]:
    """Return the uniforms of the plan for a picture of `size`."""
    restore_groups = pixel_groups(size)
    return {
        "blocks": blocks_for(size, HIGHLIGHT_BLOCK),
        "sprites_max": SPRITES_MAX,
        "small_sprites_max": SMALL_SPRITES_MAX,
        "restore_groups_x": restore_groups[0],
        "restore_groups_y": restore_groups[1],
    }
