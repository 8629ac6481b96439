"""TexturePool reports missing GPU memory where it is requested; NaN fill of new memory."""

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Data
from heatlens.render.gpu.textures import TexturePool

FAR_TOO_MUCH = 600 * 10**9


@pytest.mark.parametrize("before", [0, 64])
def test_pool_buffer_without_memory_raises_gpu_error(ctx: Device, before: int) -> None:
    if not is_software(ctx):
        pytest.skip("drivers of GPUs find the memory for a buffer when it is used")
    pool = TexturePool(ctx)
    if before:
        pool.buffer("words", before)
    with pytest.raises(GpuError, match="could not make a buffer of 600000 MB"):
        pool.buffer("words", FAR_TOO_MUCH)
    pool.release()


@pytest.mark.usefixtures("of_opengl")
def test_pool_texture_ignores_earlier_opengl_error(ctx: Device) -> None:
    ctx.buffer(reserve=FAR_TOO_MUCH).release()  # leaves OpenGL's error behind
    pool = TexturePool(ctx)
    assert pool.texture("small", (4, 4), 4).size == (4, 4)
    pool.release()


@pytest.mark.parametrize("content", [b"four", memoryview(b"four"), np.zeros(1, np.uint32)])
def test_fills_nan_fills_only_memory_without_content(
    ctx: Device, content: Data, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ctx, "fills_nan", True)
    for filled in (ctx.buffer(content), ctx.buffer(data=content), ctx.texture((1, 1), 4, content)):
        assert filled.read() == bytes(memoryview(content).cast("B"))
    empty = ctx.buffer(reserve=4)
    assert empty.read() == b"\xff" * 4
    empty.clear()
    empty.orphan(8)
    assert empty.read() == b"\xff" * 8
    for texture in (ctx.texture((1, 1), 4), ctx.texture_array((1, 1, 1), 4)):
        assert texture.read() == b"\xff" * 4
