"""Buffers and textures of wgpu hold what was written into them, in the order of the calls."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.render.gpu.wgpu.wgpu_device import WgDevice, headless_device

BYTES = 4000
WRITE = st.integers(0, BYTES // 4 - 1).flatmap(
    lambda word: st.tuples(st.just(4 * word), st.integers(1, BYTES - 4 * word), st.integers(0, 255))
)


@pytest.fixture(scope="module")
def device() -> Iterator[WgDevice]:
    made = headless_device()
    yield made
    made.release()


@settings(max_examples=25)
@given(st.lists(WRITE, max_size=8), st.lists(WRITE, max_size=4))
def test_writes_at_words_and_copies_keep_their_order(device, before, after):
    buffer, copy = device.buffer(bytes(BYTES)), device.buffer(reserve=BYTES)
    expected, in_copy = bytearray(BYTES), b""
    for number, (offset, size, value) in enumerate([*before, *after]):
        if number == len(before):
            buffer.copy_to(copy)
            in_copy = bytes(expected)
        buffer.write(bytes([value]) * size, offset)
        expected[offset : offset + size] = bytes([value]) * size
    assert buffer.read() == expected
    assert not in_copy or copy.read() == in_copy
    buffer.release()
    copy.release()


@pytest.mark.parametrize("components", [1, 3, 4])
def test_area_of_texture_is_that_of_the_whole(device, components):
    pixels = np.arange(7 * 5 * components, dtype=np.float32).reshape(5, 7, components)
    texture = device.texture((7, 5), components, pixels, dtype="f4")
    assert texture.read() == pixels.tobytes()
    whole = np.empty_like(pixels)
    texture.read_into(whole)
    assert (whole == pixels).all()
    target = device.framebuffer([texture])
    for x, y, width, height in ((0, 0, 7, 5), (2, 1, 3, 4), (6, 4, 1, 1), (5, 3, 9, 9)):
        data = target.read((x, y, width, height), components, dtype="f4")
        assert data == pixels[y : y + height, x : x + width].tobytes()
    assert target.read((7, 0, 1, 1), components, dtype="f4") == b""
    texture.release()
