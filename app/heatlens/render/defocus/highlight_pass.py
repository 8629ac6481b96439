"""Highlights: pixels brighter than their surroundings are removed and drawn as discs."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from heatlens.render.defocus.blur_pass import BlurPass, BlurTargets, Diffusion
from heatlens.render.defocus.cutout_pass import SharpPart
from heatlens.render.defocus.kernels import named_kernel
from heatlens.render.defocus.listed_fragments import (
    ListedFragments,
    list_buffers,
    list_uniforms,
)
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import PixelBands, Slices, clear_list, list_bytes
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.draw_target import DrawTarget
from heatlens.render.gpu.framebuffer import Blend, Primitive
from heatlens.render.gpu.program import (
    ComputeProgram,
    DrawProgram,
    VertexArray,
    blocks_for,
    groups_for,
    pixel_groups,
)
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.shader_constants import HIGHLIGHT_BLOCK, HIGHLIGHT_GROUP, HIGHLIGHT_LEVELS
from heatlens.render.gpu.textures import OpeningTextures

SPRITES_MAX = 4096  # largest number of discs in a picture
SMALL_SPRITES_MAX = 8192  # the same if together they are small (highlight_plan.comp.glsl)
_AREA_MAX = 24.0  # pixels drawn per pixel of the picture: hundreds of discs a third as wide
_SURROUNDINGS_PX = 16.0  # smallest diameter of the surroundings of a pixel
_SPRITE_BYTES = 48  # bytes of a disc in the list
_PIXELS_A_BAND = 1 << 17  # drawn in a step, because hundreds of discs may overlap there
_NODES_A_DISC = 4  # at least
_NODES_MOST = 1 << 22  # the numbers of nodes are kept as floats
_DISCS_A_GROUP = 64  # PIXELS_PER_GROUP of lib/list_slice.lib.glsl
PLAN_BYTES = 4 * (9 + 2 * HIGHLIGHT_LEVELS)  # bytes of `Plan`, which highlight_plan writes


def block_count(size: tuple[int, int]) -> int:
    """Return how many blocks of 8 x 8 pixels cover a picture."""
    return groups_for(size[0], HIGHLIGHT_BLOCK) * groups_for(size[1], HIGHLIGHT_BLOCK)


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


@dataclass(frozen=True)
class Surroundings:
    """Scratch memory to measure the surroundings of a pixel, all of half the picture's size.

    luminance  RGBA
    coc        R, in the corner of the texture
    targets    of the diffusion; without lists into `luminance` itself
    """

    luminance: Texture
    coc: Texture
    targets: BlurTargets


@dataclass(frozen=True)
class ListsWithoutHighlights:
    """Fragment lists, and memory for the same lists without their highlights.

    with_highlights  the lists as they were
    diffuse_words    the words of the lists without them
    """

    with_highlights: ListedFragments
    diffuse_words: Buffer

    @property
    def lists_to_diffuse(self) -> ListedFragments:
        """The lists whose light is diffused with the layers."""
        return self.with_highlights.with_words(self.diffuse_words)


@dataclass(frozen=True)
class WithoutHighlights:
    """A picture split into its highlights and other light.

    diffuse     RGBA, the light to diffuse
    highlights  RGBA, the light to draw as discs and its signed coc; written only where `lit` is set
    lit         a bit for each pixel that has light to draw (lib/lit_bits.lib.glsl)
    around      R of half the size, the luminance of the surroundings
    lists       the same for fragment lists; None without lists
    """

    diffuse: Texture
    highlights: Texture
    lit: Buffer
    around: Texture
    lists: ListsWithoutHighlights | None = None

    @staticmethod
    def lit_bytes(size: tuple[int, int]) -> int:
        """Return the bytes of `lit` for a picture."""
        return block_count(size) * HIGHLIGHT_BLOCK**2 // 8

    @property
    def buffers(self) -> dict[str, Buffer]:
        """The storage blocks of the shaders that take highlights out or put them back."""
        lit, lists = {"lit_block": self.lit}, self.lists
        return lit if lists is None else lit | {"diffuse_fragment_block": lists.diffuse_words}


# Highlights are taken out of the picture, to be drawn as discs: FLIP .107 -> .050 in a still life
# with lamps. Diffused, a lamp 300 times as bright as the wall would show the few per cent of ripple
# that any short sum of exponentials has. Only what outshines most of its surroundings is a
# highlight; bright surfaces are diffused. Surroundings are measured at half size, with clipped
# light, because a lamp must not raise the level that it is compared with.
class HighlightSplitPass:
    """Splits a picture into its highlights and the light to diffuse."""

    def __init__(self, ctx: Device, blur: BlurPass) -> None:
        self._blur = blur
        self._luminance = ComputeProgram(ctx, "defocus/highlight_luminance.comp.glsl")
        self._split = ComputeProgram(ctx, "defocus/highlight_split.comp.glsl")
        self._bands = PixelBands(ctx)

    def steps(
        self,
        color: Texture,
        coc: Texture,
        optics: Optics,
        scratch: Surroundings,
        out: WithoutHighlights,
        has_positions: bool = False,
    ) -> Iterator[None]:
        """Split `color` and the colors of the lists into the textures and buffers of `out`.

        The luminance is measured at half size, then diffused to that of the surroundings of each
        pixel. What is brighter than its surroundings is a highlight. With `has_positions` the
        position of each light in its pixel is known, see `HighlightListPass`.
        """
        lists = out.lists
        source_lists = None if lists is None else lists.with_highlights
        luminance, half_coc, targets = scratch.luminance, scratch.coc, scratch.targets
        yield from self._bands.run(
            self._luminance.version(LISTS=lists is not None),
            luminance.size,
            list_uniforms(source_lists),
            side=2,
            textures={"color_tx": color, "coc_tx": coc},
            images={"out_luminance_img": luminance, "out_coc_img": half_coc},
            buffers=list_buffers(source_lists) | {"lit_block": out.lit},
        )
        if lists is not None:
            # The shader takes the highlights out of this copy.
            lists.with_highlights.packed_lists.words.copy_to(lists.diffuse_words)
        heat = named_kernel("heat")
        least_px = _SURROUNDINGS_PX / 2  # in pixels of the picture of half the size
        diffusion = Diffusion(luminance, half_coc, heat, optics.disc.spreads, least_px=least_px)
        yield from self._blur.steps(diffusion, targets)
        yield from self._bands.run(
            self._split.version(LISTS=lists is not None),
            color.size,
            list_uniforms(source_lists)
            | ({} if lists is None else {"has_positions": has_positions}),
            textures={"color_tx": color, "coc_tx": coc, "surroundings_tx": targets.out_color}
            | ({} if lists is None else {"luminance_tx": luminance}),
            images={
                "out_diffuse_img": out.diffuse,
                "out_highlight_img": out.highlights,
                "out_around_img": out.around,
            },
            buffers=list_buffers(source_lists) | out.buffers,
        )


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
        tally_buffers = plan_buffers | {"tally_block": buffers.tally}
        blocks = blocks_for(size, HIGHLIGHT_BLOCK)
        find_uniforms: dict[str, object] = {"picture_size": size}
        clear_list(buffers.blocks)
        block_buffers = {"pixel_list_block": buffers.blocks, "lit_block": split.lit}
        yield from self._bands.run(
            *(self._find, blocks),
            find_uniforms,
            side=HIGHLIGHT_BLOCK,
            group=HIGHLIGHT_GROUP,
            buffers=block_buffers | tally_buffers,
        )
        textures = {"highlight_tx": split.highlights, "positions_tx": positions or split.highlights}
        merge_steps = partial(
            self._run_on_blocks,
            textures=textures | self._openings.of(optics.disc.aperture),
            buffers=tally_buffers | block_buffers | {"sprite_block": buffers.sprite},
            uniforms=optics.disc.uniforms
            | {"has_positions": positions is not None}
            | {"area_max": _AREA_MAX * size[0] * size[1] / enlarged},
        )
        # Count the discs of every level of merging, choose a level, then write the discs of that.
        count = self._count.version(**optics.disc.switches)
        write = self._write.version(**optics.disc.switches)
        yield from merge_steps(count, size)
        self._plan.dispatch((1, 1), buffers=plan_buffers, uniforms=_plan_uniforms(size, blocks))
        yield
        yield from merge_steps(write, size)
        self._put_back(split, buffers, coc)
        yield

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


def _plan_uniforms(size: tuple[int, int], blocks: tuple[int, int]) -> dict[str, object]:
    """Return the uniforms of the plan for a picture of `size` with `blocks` across and down."""
    restore_groups = pixel_groups(size)
    return {
        "blocks": blocks,
        "sprites_max": SPRITES_MAX,
        "small_sprites_max": SMALL_SPRITES_MAX,
        "restore_groups_x": restore_groups[0],
        "restore_groups_y": restore_groups[1],
    }


def nodes_most(size: tuple[int, int]) -> int:
    """Return how many nodes the discs of a picture may have together."""
    return min(max(2 * size[0] * size[1], _NODES_A_DISC * SMALL_SPRITES_MAX), _NODES_MOST)


def nodes_bytes(size: tuple[int, int]) -> int:
    """Return the bytes of the list of nodes for a picture."""
    return list_bytes((nodes_most(size), 1))


@dataclass(frozen=True)
class RayMemory:
    """Scratch memory of the rays from the lens to highlights.

    ranges  RG of the picture's size: range of the coc around each pixel
    nodes   the nodes of discs, and then how much is hidden at each: `nodes_bytes`
    """

    ranges: Texture
    nodes: Buffer


# Rays are traced through the depth of the picture, from points of the lens to each lamp, to find
# whether it is hidden from there; layers do not have that information. They end at the nearest
# surface that any ray to this lamp may meet, which the tiles know: 105 -> 69 ms for the same bits.
# Drawn discs of few pixels leave most lanes of a processor idle, so their rays are traced before
# they are drawn, one pixel of a disc a lane: 6,613 lamps behind leaves, 493 -> 320 ms for the same
# picture, 3,187 small and large ones 564 -> 300 ms.
class HighlightShadowPass:
    """Traces the rays to small discs, to find how much of each highlight is hidden."""

    def __init__(self, ctx: Device) -> None:
        self._find_ranges = ComputeProgram(ctx, "defocus/highlight_ranges.comp.glsl")
        self._bands = PixelBands(ctx)
        self._place = ComputeProgram(ctx, "defocus/highlight_nodes.comp.glsl")
        self._trace = ComputeProgram(ctx, "defocus/highlight_shadow.comp.glsl")
        self._slices, self._openings = Slices(ctx), OpeningTextures(ctx)

    def steps(
        self,
        buffers: HighlightBuffers,
        picture: UnmixedPicture,
        coc_range: Texture,
        optics: Optics,
        out: RayMemory,
    ) -> Iterator[None]:
        """Give each small disc of the list its nodes, and find the hidden share at each.

        `coc_range`, RG of a pixel for each tile, has the least signed coc there, and the greatest
        one of visible surfaces.
        """
        size, lists, plan_buffers = picture.coc.size, picture.lists, {"plan_block": buffers.plan}
        yield from self._bands.run(
            *(self._find_ranges, size),
            textures={"coc_tx": picture.coc, "kind_tx": picture.kind},
            images={"out_ranges_img": out.ranges},
            buffers=plan_buffers,
        )
        uniforms = optics.disc.uniforms | {"nearest_px": optics.nearest_px}
        node_buffers = {"pixel_list_block": out.nodes, "sprite_block": buffers.sprite}
        clear_list(out.nodes)
        self._place.version(**optics.disc.switches).dispatch(
            (groups_for(SMALL_SPRITES_MAX, _DISCS_A_GROUP), 1),
            textures={"coc_range_tx": coc_range},
            buffers=node_buffers | plan_buffers,
            uniforms=uniforms | {"nodes_max": nodes_most(size)},
        )
        yield
        for slice_uniforms in self._slices.of(size):
            self._trace.version(LISTS=lists is not None, **optics.disc.switches).dispatch(
                out.nodes,
                textures=_ray_textures(picture, out) | self._openings.of(optics.disc.aperture),
                buffers=node_buffers | list_buffers(lists),
                uniforms=uniforms | slice_uniforms | list_uniforms(lists),
            )
            yield


def _ray_textures(picture: UnmixedPicture, rays: RayMemory) -> dict[str, Texture]:
    """Return the textures that rays read (lib/highlight_rays.lib.glsl)."""
    return {
        "coc_tx": picture.coc,
        "kind_tx": picture.kind,
        "far_tx": picture.far,
        "near_tx": picture.near,
        "ranges_tx": rays.ranges,
    }


class HighlightDrawPass:
    """Draws the list of discs into the picture."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._program = DrawProgram(ctx, "defocus/highlight_draw")
        self._quads: dict[DrawProgram, tuple[Buffer, VertexArray]] = {}
        self._target = DrawTarget(ctx)
        self._is_drawn_in_bands = is_software(ctx)
        self._openings = OpeningTextures(ctx)

    def steps(
        self,
        buffers: HighlightBuffers,
        picture: UnmixedPicture,
        optics: Optics,
        rays: RayMemory,
        color: Texture,
        sharp: SharpPart | None = None,
    ) -> Iterator[None]:
        """Add every disc of the list to `color`, except where `picture` or `sharp` hides it.

        `color` may be a whole number of times as large as `picture`. `rays` is the output of
        `HighlightShadowPass`.
        On a software rasterizer discs are drawn in bands, so that many large ones do not hold up
        the window.
        """
        width, height = color.size
        rows = max(1, _PIXELS_A_BAND // width) if self._is_drawn_in_bands else height
        for first in range(0, height, rows):
            band = (0, first, width, rows)
            for is_large in (False, True):
                self._draw_band(buffers, picture, optics, rays, color, band, sharp, is_large)
            yield

    def _draw_band(
        self,
        buffers: HighlightBuffers,
        picture: UnmixedPicture,
        optics: Optics,
        rays: RayMemory,
        color: Texture,
        band: tuple[int, int, int, int],
        sharp: SharpPart | None,
        is_large: bool,
    ) -> None:
        """Draw the large discs or all others, but only into `band` (x, y, width, height).

        All state of the device that other draws may have changed is set again.
        """
        has_lists = picture.lists is not None
        program = self._program.version(LISTS=has_lists, LARGE=is_large, **optics.disc.switches)
        quads = self._quads_of(program, buffers.sprite)
        target, enlarged = self._target.around(color), color.width / picture.coc.width
        target.use()
        target.scissor = band
        program.bind(
            textures=_ray_textures(picture, rays)
            | {
                "cutout_tx": picture.color if sharp is None else sharp.light,
                "cutout_coc_tx": picture.coc if sharp is None else sharp.coc,
            }
            | self._openings.of(optics.disc.aperture),
            uniforms=optics.disc.uniforms
            | {"picture_size": picture.coc.size, "nearest_px": optics.nearest_px}
            | {"enlarged": enlarged, "has_cutout": sharp is not None}
            | list_uniforms(picture.lists),
            buffers=list_buffers(picture.lists) | {"pixel_list_block": rays.nodes},
        )
        self._ctx.draw_with(Blend.ADD)
        quads.render_indirect(buffers.plan, Primitive.TRIANGLE_STRIP, 1)
        self._ctx.draw_with()
        target.scissor = None

    def _quads_of(self, program: DrawProgram, sprites: Buffer) -> VertexArray:
        """Return the vertex array of a program for the buffer of discs.

        The latest array of each program is kept, and replaced if the buffer is another one.
        """
        cached = self._quads.get(program)
        if cached is None or cached[0] is not sprites:
            if cached is not None:
                cached[1].release()
            layout = [(sprites, "4f 4f 4f/i", "in_disc", "in_light", "in_nodes")]
            cached = sprites, program.vertex_array(layout)
            self._quads[program] = cached
        return cached[1]
