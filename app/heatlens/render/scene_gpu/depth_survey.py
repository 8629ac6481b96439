"""Survey the depths of a drawn picture on the GPU, without reading the picture back."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from heatlens.core.model.value_bins import BINS, ValueBins, bin_step, fill_single_bin
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.shader_constants import WORD_GROUP

_GROUP_PIXELS = 1 << 14  # each group adds its own histogram to the total
_GROUPS_MOST = 128
# Nearest, farthest, farthest finite depth and number of infinite ones, before any pixel. The bits
# of positive floats sort as the floats do, so that depths are compared as whole numbers.
_START = np.array([0xFFFFFFFF, 0, 0, 0], np.uint32)


def _bin_uniforms(low: float, step: float) -> dict[str, object]:
    """Return the uniforms of bins of `step` dioptres, the first of which begins at `low`."""
    return {"low_dioptres": low, "bins_per_dioptre": float(np.float32(1 / step))}


@dataclass(frozen=True, eq=False)
class DepthStatistics:
    """The range of a picture's depths, and the distribution of its dioptres.

    near_m, far_m   least and greatest finite depth; infinite if there is none
    infinite_count  pixels in which nothing was hit
    dioptres        the bins of 1 / depth
    """

    near_m: float
    far_m: float
    infinite_count: int
    dioptres: ValueBins


class DepthSurvey:
    """Two passes over a depth texture, which read back 16 bytes and 16 KB."""

    def __init__(self, ctx: Device) -> None:
        self._bounds_program = ComputeProgram(ctx, "scene_gpu/depth_bounds.comp.glsl")
        self._bins_program = ComputeProgram(ctx, "scene_gpu/depth_bins.comp.glsl")
        self._fragments_program = ComputeProgram(ctx, "scene_gpu/peel_bins.comp.glsl")
        self._bounds = ctx.buffer(reserve=_START.nbytes)
        self._counts = ctx.buffer(reserve=4 * BINS)

    def of(self, depth: Texture) -> DepthStatistics:
        """Return the range and the dioptres of `depth`.

        `depth` is R float32: planar meters above 0 and up to 1e37, +inf where nothing was hit. The
        bins are those of `bins_of(1 / depth)` in NumPy, to the last pixel.
        """
        self._bounds.write(_START)
        groups = min(groups_for(depth.width * depth.height, _GROUP_PIXELS), _GROUPS_MOST), 1
        images = {"depth_img": depth}
        self._bounds_program.dispatch(groups, images=images, buffers={"bounds_block": self._bounds})
        words = np.frombuffer(self._bounds.read(), np.uint32)
        near, far, far_or_zero = words.view(np.float32)[:3]
        low, high = (float(np.float32(1.0) / end) for end in (far, near))
        dioptres = self._bin_dioptres(depth, low, high, groups)
        return DepthStatistics(float(near), float(far_or_zero) or math.inf, int(words[3]), dioptres)

    def _bin_dioptres(
        self, depth: Texture, low: float, high: float, groups: tuple[int, int]
    ) -> ValueBins:
        """Return the bins of the dioptres of `depth`, which range from `low` to `high`."""
        step = bin_step(low, high)
        if not step:
            return fill_single_bin(low, high, depth.width * depth.height)
        self._counts.clear()
        self._count(depth, low, step, groups)
        return ValueBins(low, high, self._read_counts())

    def with_fragments(
        self, depth: Texture, words: Buffer, count: int, nearest: float
    ) -> ValueBins:
        """Return the bins of `depth` and of the `count` fragments in `words`.

        They range from 0 to `nearest` dioptres.
        """
        step = bin_step(0.0, nearest)
        if not step:
            return fill_single_bin(0.0, nearest, depth.width * depth.height + count)
        self._counts.clear()
        groups = min(groups_for(depth.width * depth.height, _GROUP_PIXELS), _GROUPS_MOST), 1
        self._count(depth, 0.0, step, groups)
        self._fragments_program.dispatch(
            (min(groups_for(max(count, 1), WORD_GROUP), _GROUPS_MOST), 1),
            buffers={"fragment_block": words, "count_block": self._counts},
            uniforms={"fragment_count": count, **_bin_uniforms(0.0, step)},
        )
        return ValueBins(low=0.0, high=nearest, counts=self._read_counts())

    def _count(self, depth: Texture, low: float, step: float, groups: tuple[int, int]) -> None:
        """Add the pixels of `depth` to the bins on the GPU, which begin at `low` dioptres.

        `step` is the width of a bin in dioptres, and `groups` the number of workgroups.
        """
        self._bins_program.dispatch(
            groups,
            images={"depth_img": depth},
            buffers={"count_block": self._counts},
            uniforms=_bin_uniforms(low, step),
        )

    def _read_counts(self) -> npt.NDArray[np.int64]:
        """Read the counts of all bins back."""
        return np.frombuffer(self._counts.read(), np.uint32).astype(np.int64)

    def release(self) -> None:
        """Release everything on the GPU."""
        programs = self._bounds_program, self._bins_program, self._fragments_program
        for resource in (*programs, self._bounds, self._counts):
            resource.release()
