"""Memory of the GPU that there is not enough of is said where it is asked for."""

import moderngl
import pytest

from heatlens.base.errors import GpuError
from heatlens.gpu.context import is_software
from heatlens.gpu.textures import TexturePool

FAR_TOO_MUCH = 600 * 10**9


@pytest.mark.parametrize("before", [0, 64])
def test_a_buffer_without_memory_is_refused(ctx: moderngl.Context, before: int) -> None:
    if not is_software(ctx):
        pytest.skip("drivers of GPUs find the memory for a buffer when it is used")
    pool = TexturePool(ctx)
    if before:
        pool.buffer("words", before)
    with pytest.raises(GpuError, match="could not make a buffer of 600000 MB"):
        pool.buffer("words", FAR_TOO_MUCH)
    pool.release()


def test_an_error_of_an_earlier_call_is_not_taken_for_missing_memory(ctx: moderngl.Context) -> None:
    ctx.buffer(reserve=FAR_TOO_MUCH).release()  # leaves OpenGL's error behind
    pool = TexturePool(ctx)
    assert pool.texture("small", (4, 4), 4).size == (4, 4)
    pool.release()
