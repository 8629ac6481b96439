"""Buffers of wgpu, whose memory is a multiple of four bytes."""

from typing import Any

import wgpu

from heatlens.render.gpu.resources import Buffer, Data
from heatlens.render.gpu.wgpu.recorder import Recorder
from heatlens.render.gpu.wgpu.textures import bytes_of

_BUFFER_USAGE = (
    wgpu.BufferUsage.COPY_SRC
    | wgpu.BufferUsage.COPY_DST
    | wgpu.BufferUsage.STORAGE
    | wgpu.BufferUsage.INDIRECT
    | wgpu.BufferUsage.VERTEX
    | wgpu.BufferUsage.INDEX
)


_SMALL_BYTES = 1024  # what is written without a submit: heads of lists, arguments of draws


class WgBuffer(Buffer):
    """A buffer of wgpu, whose memory is a multiple of four bytes."""

    def __init__(self, recorder: Recorder, size: int, fills_nan: bool) -> None:
        self._recorder, self.size, self._fills_nan = recorder, size, fills_nan
        self._make()

    def _make(self) -> None:
        self.raw: Any = self._recorder.device.create_buffer(
            size=max(16, -(-self.size // 16) * 16), usage=_BUFFER_USAGE
        )
        if self._fills_nan:
            self.fill_with_nan()

    def write(self, data: Data, offset: int = 0) -> None:
        content = bytes_of(data)
        rest = len(content) % 4
        if rest:  # wgpu writes words: the bytes after the last one stay as they were
            end = offset + len(content)
            after = self.read(4 - rest, end) if end + 4 - rest <= self.raw.size else bytes(4 - rest)
            content = memoryview(bytes(content) + after)
        if len(content) <= _SMALL_BYTES and offset % 4 == 0:
            self._recorder.record_write(self.raw, offset, content)
            return
        self._recorder.submit()  # what is recorded comes before
        self._recorder.device.queue.write_buffer(self.raw, offset, content)

    def read(self, size: int = -1, offset: int = 0) -> bytes:
        wanted = self.size - offset if size < 0 else size
        if not wanted:
            return b""
        first = offset // 4 * 4
        end = -(-(offset + wanted) // 4) * 4
        self._recorder.submit()
        data = self._recorder.device.queue.read_buffer(self.raw, first, end - first)
        return bytes(data[offset - first : offset - first + wanted])

    def clear(self) -> None:
        self._recorder.encoder().clear_buffer(self.raw)

    def orphan(self, size: int = -1) -> None:
        if size >= 0 and size != self.size:
            self._recorder.destroy_after_use(self.raw)
            self.size = size
            self._make()
        elif self._fills_nan:
            self.fill_with_nan()

    def copy_to(self, other: Buffer) -> None:
        assert isinstance(other, WgBuffer)
        size = -(-self.size // 4) * 4
        self._recorder.encoder().copy_buffer_to_buffer(self.raw, 0, other.raw, 0, size)

    def fill_with_nan(self) -> None:
        self._recorder.submit()
        self._recorder.device.queue.write_buffer(self.raw, 0, b"\xff" * self.raw.size)

    def release(self) -> None:
        self._recorder.destroy_after_use(self.raw)
