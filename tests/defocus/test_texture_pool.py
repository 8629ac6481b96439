"""Memory of the GPU that there is not enough of is said where it is asked for."""

from types import SimpleNamespace

import moderngl
import numpy as np
import pytest

from heatlens.base.errors import GpuError
from heatlens.gpu.context import fill_new_with_nan, is_software
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


class Made:
    """Stands in for a buffer that a context makes."""

    size = 4

    def __init__(self, *args: object, **options: object) -> None:
        self.written = b""

    def write(self, data: bytes) -> None:
        self.written = data

    def orphan(self, size: int = -1) -> None:
        self.written = b""


@pytest.mark.parametrize("given", [b"four", memoryview(b"four"), np.zeros(1, np.uint32)])
def test_only_what_has_no_content_is_filled_with_nan(given: object) -> None:
    ctx = SimpleNamespace(texture=Made, texture_array=Made, texture3d=Made, buffer=Made)
    fill_new_with_nan(ctx)
    assert ctx.buffer(given).written == ctx.buffer(data=given).written == b""
    empty = ctx.buffer(reserve=4)
    assert empty.written == b"\xff" * 4
    empty.orphan()
    assert empty.written == b"\xff" * 4
