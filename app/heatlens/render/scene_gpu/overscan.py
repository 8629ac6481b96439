"""Draw a scene with a margin around the frame, because a lens blurs the margin into the picture."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.value_bins import ValueBins
from heatlens.render.defocus.optics import Optics
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Buffer, Texture

# Margin as a share of the width. Discs wider than twice this share are rare; for them the border of
# a picture is a guess.
MARGIN_SHARE_MAX = 0.1
_STEP_PX = 8  # the margin is a multiple of this, because shares of it must be whole pixels
# The shares of the margin that are used: only a few, because a new size needs new textures.
_MARGIN_SHARES = (0.0, 0.25, 0.5, 1.0)
# A picture of at most this many pixels, margin included, is blurred at twice its size: small discs
# become rounder, and the share of each pixel that they cover more exact.
_FINE_PIXELS_MOST = 1_600_000
_FINE = 2
_SOFT_RIM_PX = 1.0  # how much larger the discs of a diffusion are than those of a lens


def margin_px(ctx: Device, size: tuple[int, int]) -> int:
    """Return the width in pixels of the margin on every side of a picture; 0 if it does not fit."""
    steps = max(1, round(MARGIN_SHARE_MAX * size[0] / _STEP_PX))
    margin = _STEP_PX * steps
    return margin if _fits(ctx, *add_margin(size, margin)) else 0


def texels_per_pixel(ctx: Device, size: tuple[int, int]) -> int:
    """Return how many pixels, along each axis, are drawn and blurred for one of a picture."""
    width, height = (_FINE * side for side in add_margin(size, margin_px(ctx, size)))
    is_small = width * height <= _FINE_PIXELS_MOST
    return _FINE if is_small and _fits(ctx, width, height) else 1


def _fits(ctx: Device, width: int, height: int) -> bool:
    """Return whether textures and lists for a picture of this size fit this GPU."""
    side = ctx.limits.texture_side_px
    words = ctx.limits.storage_block_bytes // 4
    return max(width, height) <= side and width * height < words


def add_margin(size: tuple[int, int], margin_px: int) -> tuple[int, int]:
    """Return the size of a picture with a margin on every side."""
    return size[0] + 2 * margin_px, size[1] + 2 * margin_px


@dataclass(frozen=True, eq=False)
class Overscan:
    """A scene's pinhole picture with a margin on every side.

    color      RGBA
    depth      R, planar meters
    margin_px  the margin's width, in pixels of the picture
    ring_m     (fine * margin_px, 2) nearest and farthest depth in each ring of pixels of the
               textures around the frame, from inside
    bins       dioptres of the whole picture with its margin
    fine       pixels of the textures across each pixel of the picture
    picture_textures  color and depth in the pixels of the picture, if the textures are finer
    """

    color: Texture
    depth: Texture
    margin_px: int
    ring_m: NDArray[np.float32]
    bins: ValueBins
    fine: int = 1
    picture_textures: tuple[Texture, Texture] | None = None

    def needed_px(self, optics: Optics) -> int:
        """Return how many pixels of the margin blur into the frame through a lens."""
        assert optics.line is not None
        if not self.margin_px:
            return 0
        # signed coc of the nearest and the farthest surface in each ring
        ends = optics.line.at_infinity_px + optics.line.per_dioptre_px / self.ring_m
        size = (side // self.fine - self.margin_px for side in self.color.size)
        focus_offsets = optics.line.focus_offset_limits_px(
            Box(-self.margin_px, -self.margin_px, *size)
        )
        ends = np.concatenate([ends + focus_offset for focus_offset in focus_offsets], axis=1)
        widest_px = np.abs(ends).max(axis=1) + optics.disc.wider_px
        reach_px = max(optics.disc.half_extents) * widest_px / 2 + _SOFT_RIM_PX
        distance_px = np.arange(1, len(self.ring_m) + 1) / self.fine
        reaching_rings = np.flatnonzero(reach_px >= distance_px)
        return math.ceil(distance_px[reaching_rings[-1]]) if len(reaching_rings) else 0

    def used_px(self, optics: Optics) -> int:
        """Return the margin to use: `needed_px` rounded up to one of a few widths."""
        least_px = self.needed_px(optics)
        return next(
            px
            for px in (round(share * self.margin_px) for share in _MARGIN_SHARES)
            if px >= least_px
        )

    def box_with_margin(self, margin_px: int) -> Box:
        """Return the box of the frame with a margin of `margin_px`, in the pixels of `color`.

        `margin_px` is in pixels of the picture, and at most that of the overscan.
        """
        skipped_px = self.fine * (self.margin_px - margin_px)
        return Box(
            skipped_px, skipped_px, self.color.width - skipped_px, self.color.height - skipped_px
        )

    @property
    def in_picture_pixels(self) -> "Overscan":
        """The same overscan with one texture pixel for each pixel of the picture."""
        if self.picture_textures is None:
            return self
        color, depth = self.picture_textures
        rings_m = self.ring_m.reshape(-1, self.fine, 2)
        wider_m = np.stack([rings_m[..., 0].min(axis=1), rings_m[..., 1].max(axis=1)], axis=1)
        return replace(
            self, color=color, depth=depth, ring_m=wider_m, fine=1, picture_textures=None
        )


class RingSurvey:
    """Finds the range of depths in each ring of pixels around a frame, `Overscan.ring_m`."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "scene_gpu/overscan_rings.comp.glsl")
        self._ctx = ctx
        self._rings: Buffer | None = None

    def of(self, depth: Texture, margin_px: int) -> NDArray[np.float32]:
        """Return (margin_px, 2) nearest and farthest meters of each ring of `depth`."""
        if not margin_px:
            return np.zeros((0, 2), np.float32)
        start = np.tile(np.array([0xFFFFFFFF, 0], np.uint32), margin_px)
        rings = self._buffer(start.nbytes)
        rings.write(start)
        self._program.dispatch(
            pixel_groups(depth.size),
            textures={"depth_tx": depth},
            buffers={"ring_block": rings},
            uniforms={"margin_px": margin_px},
        )
        ends = np.frombuffer(rings.read(start.nbytes), np.uint32)
        return ends.view(np.float32).reshape(-1, 2)

    def _buffer(self, size_bytes: int) -> Buffer:
        """Return the buffer for the rings, enlarged if it is too small."""
        if self._rings is None or self._rings.size < size_bytes:
            if self._rings is not None:
                self._rings.release()
            self._rings = self._ctx.buffer(reserve=size_bytes)
        return self._rings

    def release(self) -> None:
        """Release everything on the GPU."""
        self._program.release()
        if self._rings is not None:
            self._rings.release()
