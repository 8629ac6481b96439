"""Count the depths of a picture, in dioptres, relative to a tilted or split focus plane."""

import numpy as np

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import CocLine
from heatlens.core.model.focus.focus_offset import FocusOffset
from heatlens.core.model.value_bins import BINS, ValueBins, bin_step
from heatlens.render.defocus.listed_fragments import (
    FragmentBuffers,
    ListedFragments,
    list_buffers,
)
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Texture

_CACHED_RESULTS = 4  # results in the cache, because the focus moves more often than the tilt


class FocusOffsetSurvey:
    """Counts the dioptres of a picture less what a tilt or a split adds at each pixel."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._program: ComputeProgram | None = None
        self._cached_bins: dict[tuple[ValueBins, FocusOffset], ValueBins] = {}

    def bins(
        self,
        depth: Texture,
        fragments: FragmentBuffers | None,
        bins: ValueBins,
        focus_offset: FocusOffset,
    ) -> ValueBins:
        """Return the bins of the picture's dioptres less what `focus_offset` adds at each pixel.

        `depth` is in meters; `fragments` are the lists of the plate, None without lists. `bins` are
        those of the same picture without an offset, and are returned if the offset is level.
        """
        if focus_offset.is_level:
            return bins
        key = bins, focus_offset
        if key not in self._cached_bins:
            recent = list(self._cached_bins.items())[1 - _CACHED_RESULTS :]
            self._cached_bins = {
                **dict(recent),
                key: self._count_bins(depth, fragments, bins, focus_offset),
            }
        return self._cached_bins[key]

    def _count_bins(
        self,
        depth: Texture,
        fragments: FragmentBuffers | None,
        bins: ValueBins,
        focus_offset: FocusOffset,
    ) -> ValueBins:
        """Count the tilted dioptres of all pixels and fragments on the GPU, and wait for it."""
        least, most = focus_offset.dioptre_limits(Box(0, 0, *depth.size))
        low, high = bins.low - most, bins.high - least
        line = CocLine(0.0, 1.0, focus_offset)  # gives dioptres, not pixels
        lists = None if fragments is None else ListedFragments(fragments, line)
        uniforms = line.focus_offset_uniforms if lists is None else lists.uniforms
        bins_per_dioptre = 1.0 / max(bin_step(low, high), 1e-30)
        counts = self._ctx.buffer(reserve=4 * BINS)
        counts.clear()
        self._program = self._program or ComputeProgram(
            self._ctx, "defocus/focus_offset_bins.comp.glsl"
        )
        self._program.version(LISTS=lists is not None).dispatch(
            pixel_groups(depth.size),
            textures={"depth_tx": depth},
            buffers={"count_block": counts} | list_buffers(lists),
            uniforms=uniforms | {"low_dioptres": low, "bins_per_dioptre": bins_per_dioptre},
        )
        in_bins = np.frombuffer(counts.read(), np.uint32).astype(np.int64)
        counts.release()
        return ValueBins(low, high, in_bins)
