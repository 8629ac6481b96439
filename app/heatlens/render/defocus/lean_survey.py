"""Count the depths of a picture as a lens that leans blurs them."""

import numpy as np

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import CocLine, Lean
from heatlens.core.model.value_bins import BINS, ValueBins, bin_step
from heatlens.render.defocus.listed_fragments import (
    FragmentBuffers,
    ListedFragments,
    ListProgram,
    list_buffers,
)
from heatlens.render.gpu.device import Device, Texture
from heatlens.render.gpu.program import pixel_groups

_KEPT = 4  # results that are kept, since the focus moves more often than the tilt


class LeanSurvey:
    """Moves the bins of a picture by the dioptres that a tilt or a split adds at each pixel."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._program: ListProgram | None = None
        self._found: dict[tuple[ValueBins, Lean], ValueBins] = {}

    def bins(
        self,
        depth: Texture,
        fragments: FragmentBuffers | None,
        bins: ValueBins,
        lean: Lean,
    ) -> ValueBins:
        """Return the bins of a picture's dioptres less those of `lean`; `bins` are without."""
        if lean.is_level:
            return bins
        key = bins, lean
        if key not in self._found:
            kept = list(self._found.items())[1 - _KEPT :]
            self._found = {**dict(kept), key: self._counted(depth, fragments, bins, lean)}
        return self._found[key]

    def _counted(
        self,
        depth: Texture,
        fragments: FragmentBuffers | None,
        bins: ValueBins,
        lean: Lean,
    ) -> ValueBins:
        least, most = lean.ends(Box(0, 0, *depth.size))
        low, high = bins.low - most, bins.high - least
        line = CocLine(0.0, 1.0, lean)
        lists = None if fragments is None else ListedFragments(fragments, line)
        uniforms = line.lean_uniforms if lists is None else lists.uniforms
        per_step = 1.0 / max(bin_step(low, high), 1e-30)
        counts = self._ctx.buffer(reserve=4 * BINS)
        counts.clear()
        self._program = self._program or ListProgram(self._ctx, "defocus/lean_bins.comp.glsl")
        self._program.version(lists is not None).dispatch(
            pixel_groups(depth.size),
            textures={"depth_tx": depth},
            buffers={"count_block": counts} | list_buffers(lists),
            uniforms=uniforms | {"low": low, "per_step": per_step},
        )
        in_bins = np.frombuffer(counts.read(), np.uint32).astype(np.int64)
        counts.release()
        return ValueBins(low, high, in_bins)
