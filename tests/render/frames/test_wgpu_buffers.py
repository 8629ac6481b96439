"""Buffers of wgpu hold what was written into them, in the order of the calls."""

from collections.abc import Iterator

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
