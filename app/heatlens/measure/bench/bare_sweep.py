"""Two bare Thomas sweeps over a picture, the reference for a frame with one layer of heat."""

import moderngl
import numpy as np

from heatlens.base.errors import GpuError
from heatlens.defocus.kernels import named_kernel
from heatlens.gpu.program import ComputeProgram, groups_for
from heatlens.gpu.shader_constants import ROW_GROUP
from heatlens.gpu.textures import FloatArray, new_texture, upload


class BareSweeps:
    """Sweeps rows, then columns, with precomputed conductances; owns all its GPU objects."""

    def __init__(self, ctx: moderngl.Context, color: FloatArray, coc_px: FloatArray) -> None:
        """Upload `color` (H, W, 4) and `coc_px` (H, W), diameters of either sign, to the GPU."""
        size = (coc_px.shape[1], coc_px.shape[0])
        _check_scratch_fits(ctx, size)
        self._size = size
        self._program = ComputeProgram(ctx, "bare_sweep.comp.glsl")
        self._color, self._rows, self.out = (new_texture(ctx, size, 4) for _ in range(3))
        self._conductances = [new_texture(ctx, size, 1) for _ in range(2)]
        self._scratch = {
            block: ctx.buffer(reserve=per_pixel * size[0] * size[1])
            for block, per_pixel in (("bare_weight_block", 4), ("bare_part_block", 16))
        }
        upload(self._color, color)
        for axis, texture in enumerate(self._conductances):
            upload(texture, conductances(coc_px, along=1 - axis))

    def run(self) -> None:
        """Write the diffused picture to `out`."""
        self._sweep((1, 0), self._conductances[0], self._color, self._rows)
        self._sweep((0, 1), self._conductances[1], self._rows, self.out)

    def _sweep(
        self,
        axis: tuple[int, int],
        conductance: moderngl.Texture,
        color: moderngl.Texture,
        out_color: moderngl.Texture,
    ) -> None:
        length, lines = self._size if axis == (1, 0) else self._size[::-1]
        self._program.dispatch(
            (groups_for(lines, ROW_GROUP), 1),
            images={
                "conductance_img": conductance,
                "color_img": color,
                "out_color_img": out_color,
            },
            buffers=self._scratch,
            uniforms={"axis": axis, "line_count": lines, "line_length": length},
        )

    def release(self) -> None:
        """Delete all GPU objects."""
        for texture in (self._color, self._rows, self.out, *self._conductances):
            texture.release()
        for buffer in self._scratch.values():
            buffer.release()
        self._program.release()


def conductances(coc_px: FloatArray, along: int) -> FloatArray:
    """Return the heat conductance of each pixel to the next `along` an axis; 0 at a line's end."""
    diameter = np.moveaxis(np.abs(coc_px), along, -1)
    result = np.zeros(diameter.shape, np.float32)
    narrower = np.minimum(diameter[..., :-1], diameter[..., 1:])
    result[..., :-1] = named_kernel("heat").poles[0].real * narrower**2
    return np.ascontiguousarray(np.moveaxis(result, -1, along))


def _check_scratch_fits(ctx: moderngl.Context, size: tuple[int, int]) -> None:
    need = 16 * size[0] * size[1]
    limit = int(ctx.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"])
    if need > limit:
        raise GpuError(
            f"The bare sweeps of {size[0]}x{size[1]} need a storage block of {need / 2**20:.0f} "
            f"MiB; this OpenGL takes {limit / 2**20:.0f}. Give --bare a smaller --size."
        )
