"""Compute depth of field by gathering: each pixel is the mean of the pixels in its disc."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import moderngl

from heatlens.defocus.optics import Optics
from heatlens.gpu.opening_textures import OpeningTextures
from heatlens.gpu.program import ComputeProgram, groups_for
from heatlens.gpu.program_versions import ProgramVersions
from heatlens.gpu.shader_constants import DISC_RAMP_PX, PIXEL_GROUP

_SAMPLES_PER_STEP = 2**24  # about 0.2 s on a CPU, so that a window can handle input
_LOOPS_MAX = 60_000  # Mesa's software rasteriser stops an invocation's loops after 65535 rounds


@dataclass(frozen=True, slots=True)
class GatherStep:
    """A band of picture rows from `band_start`, and a range of disc rows, both ends included."""

    band_start: int
    band_rows: int
    disc_first: int
    disc_last: int


def disc_reach_px(optics: Optics) -> tuple[int, int]:
    """Return half the size (x, y) of the box around the widest disc of the plate and its rim."""
    radius = (max(abs(optics.nearest_px), abs(optics.farthest_px)) + optics.disc.wider_px) / 2
    x, y = (math.ceil(radius * scale + DISC_RAMP_PX) for scale in optics.disc.half_extents)
    return x, y


def gather_steps(size: tuple[int, int], reach: tuple[int, int]) -> list[GatherStep]:
    """Divide the work into parts of at most `_SAMPLES_PER_STEP` samples if a row of tiles allows.

    A disc wider than the picture costs no more than one that fills it.
    """
    reach_x, reach_y = (min(r, side - 1) for r, side in zip(reach, size, strict=True))
    across = 2 * reach_x + 2
    budget = max(1, _SAMPLES_PER_STEP // (size[0] * PIXEL_GROUP * across))
    disc_rows = max(1, min(2 * reach_y + 1, budget, _LOOPS_MAX // across))
    per_row = size[0] * across * disc_rows
    band_rows = max(1, min(_SAMPLES_PER_STEP // per_row, size[1]) // PIXEL_GROUP) * PIXEL_GROUP
    return [
        GatherStep(start, band_rows, first, min(first + disc_rows - 1, reach_y))
        for start in range(0, size[1], band_rows)
        for first in range(-reach_y, reach_y + 1, disc_rows)
    ]


class GatherPass:
    """Gives each pixel the mean of all pixels within its own circle of confusion.

    A weakness of the method: a blurred foreground keeps a sharp silhouette, because the pixels
    outside it have small discs.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self._programs = ProgramVersions(lambda on: ComputeProgram(ctx, "gather.comp.glsl", on))
        self._openings = OpeningTextures(ctx)

    def steps(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        out_color: moderngl.Texture,
        weight: moderngl.Texture,
    ) -> Iterator[None]:
        """Fill `out_color`, RGBA as `color`; `weight` is scratch, RGBA for shapes not plain."""
        program = self._programs.with_(**optics.disc.switches)
        textures = {"color_tx": color, "coc_tx": coc} | self._openings.of(optics.disc.aperture)
        reach = disc_reach_px(optics)
        parts = gather_steps(color.size, reach)
        first, last = parts[0].disc_first, parts[-1].disc_last
        for part in parts:
            program.dispatch(
                (groups_for(color.size[0], PIXEL_GROUP), groups_for(part.band_rows, PIXEL_GROUP)),
                textures=textures,
                images={"sum_img": out_color, "weight_img": weight},
                uniforms=optics.disc.uniforms
                | {
                    "band_start": part.band_start,
                    "disc_rows": (part.disc_first, part.disc_last),
                    "is_first": part.disc_first == first,
                    "is_last": part.disc_last == last,
                },
            )
            yield
