"""Memory of the GPU that there is not enough of is said where it is asked for."""

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Data, Device
from heatlens.render.gpu.textures import TexturePool

FAR_TOO_MUCH = 600 * 10**9


@pytest.mark.parametrize("before", [0, 64])
def test_a_buffer_without_memory_is_refused(ctx: Device, before: int) -> None:
    if not is_software(ctx):
        pytest.skip("drivers of GPUs find the memory for a buffer when it is used")
    pool = TexturePool(ctx)
    if before:
        pool.buffer("words", before)
    with pytest.raises(GpuError, match="could not make a buffer of 600000 MB"):
        pool.buffer("words", FAR_TOO_MUCH)
    pool.release()


def test_an_error_of_an_earlier_call_is_not_taken_for_missing_memory(ctx: Device) -> None:
    ctx.buffer(reserve=FAR_TOO_MUCH).release()  # leaves OpenGL's error behind
    pool = TexturePool(ctx)
    assert pool.texture("small", (4, 4), 4).size == (4, 4)
    pool.release()


@pytest.mark.parametrize("given", [b"four", memoryview(b"four"), np.zeros(1, np.uint32)])
def test_only_what_has_no_content_is_filled_with_nan(
    ctx: Device, given: Data, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ctx, "fills_nan", True)
    for made in (ctx.buffer(given), ctx.buffer(data=given), ctx.texture((1, 1), 4, given)):
        assert made.read() == bytes(memoryview(given).cast("B"))
    empty = ctx.buffer(reserve=4)
    assert empty.read() == b"\xff" * 4
    empty.clear()
    empty.orphan(8)
    assert empty.read() == b"\xff" * 8
    for texture in (ctx.texture((1, 1), 4), ctx.texture_array((1, 1, 1), 4)):
        assert texture.read() == b"\xff" * 4
