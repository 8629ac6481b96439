"""Compute depth of field by scattering: each pixel is drawn as its disc, far to near.

Discs are drawn as instanced quads, sorted into bins of depth. Within a bin they add up, because the
discs of one surface share its pixels and do not hide each other; bins are composited. Compositing
discs one by one would let 1/e of what is behind a closed surface through.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.render.defocus.optics import Optics
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.draw_target import DrawTarget
from heatlens.render.gpu.framebuffer import Blend, Primitive
from heatlens.render.gpu.program import (
    ComputeProgram,
    DrawProgram,
    VertexArray,
    groups_for,
    pixel_groups,
)
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.shader_constants import (
    DISC_RAMP_PX,
    ROW_GROUP,
    SCATTER_BINS,
    SCATTER_DISC_SUMS,
    SCATTER_GROWTH,
    SCATTER_MIDDLE,
    SCATTER_STEPS_A_PX,
)
from heatlens.render.gpu.textures import OpeningTextures

_FRAGMENTS_PER_STEP = 2**23  # takes some tenths of a second on a processor

Counts = npt.NDArray[np.uint32]


@dataclass(frozen=True)
class ScatterTargets:
    """The textures in which discs are drawn and composited, all of the picture's size.

    light, cover          RGBA and red: the sums of light and coverage of the discs of one bin
    out_color, out_cover  RGBA and red: the composite of all bins
    offsets               a word for each bin of each row: after the first pass the number of its
                          pixels, then the index in `pixels` at which they begin
    pixels                a word for each pixel of the picture, sorted by bin
    """

    light: Texture
    cover: Texture
    out_color: Texture
    out_cover: Texture
    offsets: Buffer
    pixels: Buffer


def buffer_bytes(size: tuple[int, int]) -> dict[str, int]:
    """Return the bytes of the buffers of `ScatterTargets` for a picture of `size`, by name."""
    return {"offsets": 4 * SCATTER_BINS * size[1], "pixels": 4 * size[0] * size[1]}


def disc_sums(disc: DiscShape) -> npt.NDArray[np.float64]:
    """Return the sum of the coverage of all pixels by small discs, (SCATTER_DISC_SUMS,).

    Their diameters rise from 0 in steps of 1 / SCATTER_STEPS_A_PX pixels.
    """
    diameters = np.arange(SCATTER_DISC_SUMS) / SCATTER_STEPS_A_PX
    return np.array([_disc_sum(disc, d / 2) for d in diameters])


def _disc_sum(disc: DiscShape, radius: float) -> float:
    """Return the sum of the coverage of all pixels by a disc of this radius in pixels."""
    reach_x, reach_y = (int(np.ceil(radius * half + DISC_RAMP_PX)) for half in disc.half_extents)
    y, x = np.mgrid[-reach_y : reach_y + 1, -reach_x : reach_x + 1]
    return float(disc.coverage(x, y, radius, DISC_RAMP_PX).sum())


def bin_starts(counts: Counts) -> Counts:
    """Return where the pixels of each row and bin begin in the sorted list, far bins first.

    `counts` and the result are (rows, SCATTER_BINS).
    """
    far_to_near = counts[:, ::-1].T.astype(np.uint64)  # bins, rows
    flat = far_to_near.ravel()
    starts = (np.cumsum(flat) - flat).reshape(far_to_near.shape)
    return np.ascontiguousarray(starts.T[:, ::-1].astype(np.uint32))


def bin_coc_px(bin_index: int, largest_px: float) -> float:
    """Return the largest |coc| in pixels that a bin can hold; `largest_px` is that of the plate."""
    if bin_index in (0, SCATTER_BINS - 1):
        return largest_px
    return min(largest_px, SCATTER_GROWTH ** abs(bin_index - SCATTER_MIDDLE))


def disc_fragments(coc_px: float, disc: DiscShape, size: tuple[int, int]) -> int:
    """Return how many pixels drawing a disc touches at most: those of its box in the picture."""
    sides = [(coc_px + disc.wider_px) * half + 2 * DISC_RAMP_PX + 1 for half in disc.half_extents]
    across, down = (min(side, most) for side, most in zip(sides, size, strict=True))
    return max(1, int(across * down))


class ScatterPass:
    """Sorts the pixels, draws each bin's discs in parts, and composites the bins."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._count = ComputeProgram(ctx, "defocus/scatter_sort.comp.glsl", {"COUNT": 1})
        self._sort = ComputeProgram(ctx, "defocus/scatter_sort.comp.glsl")
        self._discs = DrawProgram(ctx, "defocus/scatter_draw")
        self._over = ComputeProgram(ctx, "defocus/scatter_over.comp.glsl")
        self._quads: dict[DrawProgram, tuple[Buffer, VertexArray]] = {}
        self._target = DrawTarget(ctx)
        self._openings = OpeningTextures(ctx)
        self._command = ctx.buffer(reserve=16)

    def steps(
        self, color: Texture, coc: Texture, optics: Optics, targets: ScatterTargets
    ) -> Iterator[None]:
        """Fill `targets.out_color`, RGBA as `color`, in steps that are short wherever discs lie."""
        totals = self._sort_pixels(coc, targets)
        yield
        # the bins that hold pixels, far to near
        bins = [int(index) for index in np.flatnonzero(totals)[::-1]]
        sums = [float(value) for value in disc_sums(optics.disc)] if optics.disc.is_plain else []
        largest_px = max(abs(optics.nearest_px), abs(optics.farthest_px))
        textures = {"color_tx": color, "coc_tx": coc} | self._openings.of(optics.disc.aperture)
        inputs = (textures, optics.disc, sums)
        self._target.around(targets.light, targets.cover).clear()
        first = 0
        for bin_index in bins:
            count = int(totals[bin_index])
            fragments = disc_fragments(bin_coc_px(bin_index, largest_px), optics.disc, color.size)
            discs_per_step = max(1, _FRAGMENTS_PER_STEP // fragments)
            for start in range(first, first + count, discs_per_step):
                self._draw(inputs, targets, start, min(discs_per_step, first + count - start))
                yield
            first += count
            self._composite_bin(targets, bin_index == bins[0], bin_index == bins[-1])
            yield

    def _sort_pixels(self, coc: Texture, targets: ScatterTargets) -> Counts:
        """Sort the pixels into `targets.pixels`, far to near; return how many are in each bin.

        A first pass counts the pixels of each bin and row. The counts are replaced by where each
        bin and row begins, and a second pass puts the pixels there. This waits for the GPU.
        """
        rows = coc.size[1]
        groups = (groups_for(rows, ROW_GROUP), 1)
        buffers = {"offset_block": targets.offsets, "pixel_block": targets.pixels}
        self._count.dispatch(groups, textures={"coc_tx": coc}, buffers=buffers)
        count_words = np.frombuffer(targets.offsets.read(4 * SCATTER_BINS * rows), np.uint32)
        counts = count_words.reshape(rows, SCATTER_BINS)
        targets.offsets.write(bin_starts(counts).tobytes())
        self._sort.dispatch(groups, textures={"coc_tx": coc}, buffers=buffers)
        return np.asarray(counts.sum(axis=0), np.uint32)

    def _draw(
        self,
        inputs: tuple[dict[str, Texture], DiscShape, list[float]],
        targets: ScatterTargets,
        first: int,
        count: int,
    ) -> None:
        """Add the discs of `count` sorted pixels, from number `first` on, to the sums of a bin.

        `inputs` are the textures of the picture, the shape of the discs and the table `disc_sums`,
        which is empty for shapes that are not plain. All state that other draws may have changed
        is set again.
        """
        textures, disc, sums = inputs
        program = self._discs.version(**disc.switches)
        quads = self._quads_of(program, targets.pixels)
        uniforms = disc.uniforms | ({"disc_sums": sums} if sums else {})
        self._target.around(targets.light, targets.cover).use()
        program.bind(textures=textures, uniforms=uniforms)
        # vertices, instances, first vertex and first instance
        self._command.write(np.array([4, count, 0, first], np.uint32).tobytes())
        self._ctx.draw_with(Blend.ADD)
        quads.render_indirect(self._command, Primitive.TRIANGLE_STRIP, 1)
        self._ctx.draw_with()

    def _composite_bin(self, targets: ScatterTargets, is_farthest: bool, is_nearest: bool) -> None:
        """Composite the sums of one bin over those of the bins behind it, and clear the sums.

        The farthest bin is the first one, and the nearest one completes the picture.
        """
        self._over.dispatch(
            pixel_groups(targets.light.size),
            images={
                "light_img": targets.light,
                "cover_img": targets.cover,
                "out_color_img": targets.out_color,
                "out_cover_img": targets.out_cover,
            },
            uniforms={"is_farthest": is_farthest, "is_nearest": is_nearest},
        )

    def _quads_of(self, program: DrawProgram, pixels: Buffer) -> VertexArray:
        """Return the vertex array of a program for the sorted pixels.

        The latest array of each program is kept, and replaced if the buffer is another one.
        """
        cached = self._quads.get(program)
        if cached is None or cached[0] is not pixels:
            if cached is not None:
                cached[1].release()
            cached = pixels, program.vertex_array([(pixels, "1u/i", "in_pixel")])
            self._quads[program] = cached
        return cached[1]
