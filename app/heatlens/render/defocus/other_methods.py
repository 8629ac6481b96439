"""Blur a plate by methods other than diffusion, for comparison.

Gathering takes for each pixel the mean of the pixels in its disc. A pyramid of ever smaller
pictures is read at the level of the blur: Burt and Adelson 1983 make the levels, Williams 1983
reads between them.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.scatter_pass import ScatterPass, ScatterTargets, buffer_bytes
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for, pixel_groups
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.shader_constants import DISC_RAMP_PX, PIXEL_GROUP, PYRAMID_LEVELS_MAX
from heatlens.render.gpu.textures import OpeningTextures

LevelRect = tuple[int, int, int, int]  # corner x, y and size x, y

_SAMPLES_PER_STEP = 2**24  # about 0.2 s on a CPU, so that a window can handle input
_LOOPS_MAX = 60_000  # Mesa's software rasterizer stops an invocation's loops after 65535 rounds


@dataclass(frozen=True, slots=True)
class GatherStep:
    """A band of picture rows from `band_start`, and a range of disc rows, both ends included."""

    band_start: int
    band_rows: int
    disc_first: int
    disc_last: int


def disc_reach_px(optics: Optics) -> tuple[int, int]:
    """Return half the size (x, y), in pixels, of the box around the plate's widest disc and rim."""
    radius = (max(abs(optics.nearest_px), abs(optics.farthest_px)) + optics.disc.wider_px) / 2
    x, y = (math.ceil(radius * scale + DISC_RAMP_PX) for scale in optics.disc.half_extents)
    return x, y


def gather_steps(size: tuple[int, int], reach: tuple[int, int]) -> list[GatherStep]:
    """Divide the work into steps of at most `_SAMPLES_PER_STEP` samples, if a row of tiles allows.

    `size` is that of the picture, and `reach` that of `disc_reach_px`. Each step gathers some rows
    of the disc for a band of picture rows. A disc wider than the picture costs no more than one
    that fills it.
    """
    reach_x, reach_y = (min(r, side - 1) for r, side in zip(reach, size, strict=True))
    across = 2 * reach_x + 2  # samples in a row of the disc
    budget = max(1, _SAMPLES_PER_STEP // (size[0] * PIXEL_GROUP * across))
    disc_rows = max(1, min(2 * reach_y + 1, budget, _LOOPS_MAX // across))
    per_row = size[0] * across * disc_rows
    band_rows = max(1, min(_SAMPLES_PER_STEP // per_row, size[1]) // PIXEL_GROUP) * PIXEL_GROUP
    return [
        GatherStep(band_start, band_rows, disc_first, min(disc_first + disc_rows - 1, reach_y))
        for band_start in range(0, size[1], band_rows)
        for disc_first in range(-reach_y, reach_y + 1, disc_rows)
    ]


class GatherPass:
    """Gives each pixel the mean of all pixels within its own circle of confusion.

    A weakness of the method: a blurred foreground keeps a sharp silhouette, because the pixels
    outside it have small discs.
    """

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/gather.comp.glsl")
        self._openings = OpeningTextures(ctx)

    def steps(
        self, color: Texture, coc: Texture, optics: Optics, out_color: Texture, weight: Texture
    ) -> Iterator[None]:
        """Fill `out_color`, RGBA as `color`; `weight` is scratch, RGBA for shapes not plain."""
        program = self._program.version(**optics.disc.switches)
        textures = {"color_tx": color, "coc_tx": coc} | self._openings.of(optics.disc.aperture)
        reach = disc_reach_px(optics)
        work_steps = gather_steps(color.size, reach)
        first, last = work_steps[0].disc_first, work_steps[-1].disc_last
        for work_step in work_steps:
            program.dispatch(
                (
                    groups_for(color.size[0], PIXEL_GROUP),
                    groups_for(work_step.band_rows, PIXEL_GROUP),
                ),
                textures=textures,
                images={"sum_img": out_color, "weight_img": weight},
                uniforms=optics.disc.uniforms
                | {
                    "band_start": work_step.band_start,
                    "disc_rows": (work_step.disc_first, work_step.disc_last),
                    "is_first": work_step.disc_first == first,
                    "is_last": work_step.disc_last == last,
                },
            )
            yield


def level_variance(level: int) -> float:
    """Return the variance, in pixels^2 along each axis, of a level that is read linearly.

    See pyramid_read.comp.glsl.
    """
    return (4.0**level - 1) / 2


def layout_levels(size: tuple[int, int], widest_px: float) -> list[LevelRect]:
    """Return the rectangles of levels 1, 2, .. in one texture, enough for discs of `widest_px`.

    The first is on the left, all others in a column beside it. A level has one pixel more than half
    of the level below, for interpolation; below 2 pixels it would not shrink.
    """
    rects: list[LevelRect] = []
    width, height = size
    x = y = 0
    while len(rects) < PYRAMID_LEVELS_MAX and level_variance(len(rects)) < widest_px**2 / 16:
        if rects and max(width, height) <= 2:
            break
        width, height = width // 2 + 1, height // 2 + 1
        rects.append((x, y, width, height))
        x, y = (width, 0) if len(rects) == 1 else (x, y + height)
    return rects


def pyramid_size(rects: list[LevelRect]) -> tuple[int, int]:
    """Return the size of the texture that contains all levels, at least a pixel."""
    width = max((x + width for x, _, width, _ in rects), default=1)
    return width, max((y + height for _, y, _, height in rects), default=1)


def widest_px(optics: Optics) -> float:
    """Return the diameter of the plate's largest disc in pixels, along its shorter axis."""
    return max(abs(optics.nearest_px), abs(optics.farthest_px)) * min(optics.disc.spreads)


class PyramidPass:
    """Makes the levels, then reads each pixel from two of them, whatever the blur.

    Sharp pixels bleed into blurred neighbors, because the pyramid ignores depth.
    """

    def __init__(self, ctx: Device) -> None:
        self._reduce = ComputeProgram(ctx, "defocus/pyramid_reduce.comp.glsl")
        self._read = ComputeProgram(ctx, "defocus/pyramid_read.comp.glsl")

    def steps(
        self, color: Texture, coc: Texture, optics: Optics, pyramid: Texture, out_color: Texture
    ) -> Iterator[None]:
        """Fill `out_color`, RGBA as `color`; `pyramid` holds the levels of `layout_levels`."""
        rects = layout_levels(color.size, widest_px(optics))
        source, source_rect = color, (0, 0, *color.size)
        for rect in rects:
            self._reduce.dispatch(
                pixel_groups(rect[2:]),
                textures={"source_tx": source},
                images={"out_img": pyramid},
                uniforms={"source_rect": source_rect, "out_rect": rect},
            )
            source, source_rect = pyramid, rect
            yield
        self._read.dispatch(
            pixel_groups(color.size),
            textures={"color_tx": color, "pyramid_tx": pyramid, "coc_tx": coc},
            images={"out_color_img": out_color},
            uniforms={
                "aperture_axes": optics.disc.spreads,
                "level_rects": rects + [(0, 0, 1, 1)] * (PYRAMID_LEVELS_MAX - len(rects)),
                "levels": len(rects),
            },
        )
        yield


class OtherMethods:
    """The methods; each takes RGBA and signed coc, and writes RGBA to the texture "blurred".

    Alpha is blurred as a fourth color. Programs are built when a method is first used.
    """

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx

    @cached_property
    def _gather(self) -> GatherPass:
        return GatherPass(self._ctx)

    @cached_property
    def _scatter(self) -> ScatterPass:
        return ScatterPass(self._ctx)

    @cached_property
    def _pyramid(self) -> PyramidPass:
        return PyramidPass(self._ctx)

    def gather(
        self, color: Texture, coc: Texture, optics: Optics, scratch: Scratch
    ) -> Iterator[None]:
        """Blur by `GatherPass`, in short steps, into the texture "blurred" of `scratch`."""
        if optics.disc.is_plain:
            weight = scratch.texture("gather weight", color.size, 1)
        else:
            weight = scratch.texture("gather weights", color.size, 4)
        out = scratch.texture("blurred", color.size, 4)
        return self._gather.steps(color, coc, optics, out, weight)

    def scatter(
        self, color: Texture, coc: Texture, optics: Optics, scratch: Scratch
    ) -> Iterator[None]:
        """Blur by `ScatterPass`, in short steps, into the texture "blurred" of `scratch`."""
        size = color.size
        sizes = buffer_bytes(size)
        targets = ScatterTargets(
            light=scratch.texture("bin light", size, 4),
            cover=scratch.texture("bin cover", size, 1),
            out_color=scratch.texture("blurred", size, 4),
            out_cover=scratch.texture("scatter cover", size, 1),
            offsets=scratch.buffer("scatter offsets", sizes["offsets"]),
            pixels=scratch.buffer("scatter order", sizes["pixels"]),
        )
        return self._scatter.steps(color, coc, optics, targets)

    def pyramid(
        self, color: Texture, coc: Texture, optics: Optics, scratch: Scratch
    ) -> Iterator[None]:
        """Blur by `PyramidPass`, in short steps, into the texture "blurred" of `scratch`."""
        all_levels = layout_levels(color.size, math.inf)  # enough for every lens
        levels = scratch.texture("pyramid", pyramid_size(all_levels), 4)
        out = scratch.texture("blurred", color.size, 4)
        return self._pyramid.steps(color, coc, optics, levels, out)
