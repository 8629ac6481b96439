"""Blur a plate by methods other than diffusion, for comparison."""

import math
from collections.abc import Iterator
from functools import cached_property

import moderngl

from heatlens.defocus.gather_pass import GatherPass
from heatlens.defocus.optics import Optics
from heatlens.defocus.pyramid_pass import PyramidPass, level_places, pyramid_size
from heatlens.defocus.scatter_pass import ScatterPass, ScatterTargets, buffer_bytes
from heatlens.defocus.scratch import Scratch


class OtherMethods:
    """The methods; each takes RGBA and signed coc, and writes RGBA to the texture "blurred".

    Alpha is blurred as a fourth colour. Programs are built when a method is first used.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
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
        self, color: moderngl.Texture, coc: moderngl.Texture, optics: Optics, scratch: Scratch
    ) -> Iterator[None]:
        """Blur by `GatherPass`."""
        if optics.disc.is_plain:
            weight = scratch.texture("gather weight", color.size, 1)
        else:
            weight = scratch.texture("gather weights", color.size, 4)
        out = scratch.texture("blurred", color.size, 4)
        return self._gather.steps(color, coc, optics, out, weight)

    def scatter(
        self, color: moderngl.Texture, coc: moderngl.Texture, optics: Optics, scratch: Scratch
    ) -> Iterator[None]:
        """Blur by `ScatterPass`."""
        size = color.size
        sizes = buffer_bytes(size)
        targets = ScatterTargets(
            scratch.texture("bin light", size, 4),
            scratch.texture("bin cover", size, 1),
            scratch.texture("blurred", size, 4),
            scratch.texture("scatter cover", size, 1),
            scratch.buffer("scatter places", sizes["place"]),
            scratch.buffer("scatter order", sizes["pixel"]),
        )
        return self._scatter.steps(color, coc, optics, targets)

    def pyramid(
        self, color: moderngl.Texture, coc: moderngl.Texture, optics: Optics, scratch: Scratch
    ) -> Iterator[None]:
        """Blur by `PyramidPass`."""
        all_levels = level_places(color.size, math.inf)  # enough for every lens
        levels = scratch.texture("pyramid", pyramid_size(all_levels), 4)
        out = scratch.texture("blurred", color.size, 4)
        return self._pyramid.steps(color, coc, optics, levels, out)
