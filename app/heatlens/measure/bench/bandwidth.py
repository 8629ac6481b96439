"""Measure the memory bandwidth of this machine with a shader that copies a picture."""

import moderngl

from heatlens.gpu.context import is_software
from heatlens.gpu.program import ComputeProgram, pixel_groups
from heatlens.gpu.stopwatch import Stopwatch
from heatlens.gpu.textures import new_texture

_BYTES_PER_PIXEL = 32  # rgba32f read and written
_LARGE = (4096, 4096)  # 256 MiB, more than the caches of any GPU
_TRIES = 7


def copy_bytes_per_second(ctx: moderngl.Context, size: tuple[int, int]) -> float:
    """Return the bytes per second of the fastest of several copies; the first copy is not counted.

    A software rasteriser copies a picture of `size`, so that the processor's caches have the same
    effect as on the passes; a GPU copies a large picture.
    """
    size = size if is_software(ctx) else _LARGE
    program = ComputeProgram(ctx, "bandwidth_copy.comp.glsl")
    source, target = (new_texture(ctx, size, 4) for _ in range(2))
    source.write(
        bytes(16 * size[0] * size[1])
    )  # reading memory that was never written would be too fast
    seconds = [_copy_seconds(program, source, target) for _ in range(_TRIES + 1)]
    for thing in (program, source, target):
        thing.release()
    return _BYTES_PER_PIXEL * size[0] * size[1] / min(seconds[1:])


def _copy_seconds(
    program: ComputeProgram, source: moderngl.Texture, target: moderngl.Texture
) -> float:
    stopwatch = Stopwatch(source.ctx, on=True)
    with stopwatch.measure("copy"):
        program.dispatch(
            pixel_groups(source.size),
            textures={"color_tx": source},
            images={"out_color_img": target},
        )
    return stopwatch.times["copy"].seconds
