"""A device without OpenGL that holds no pictures and records the calls that it gets."""

from typing import Any

import numpy as np

from heatlens.render.gpu.device import Device, Limits
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.linked_program import LinkedArray, LinkedCompute, LinkedDraw
from heatlens.render.gpu.resources import Buffer, Data, Sampling, Texture

BYTES = {"f1": 1, "f2": 2, "f4": 4, "u4": 4}


class RecordedCalls(list[tuple[str, str]]):
    """A list of calls, each as (kind, shader file or label)."""

    def count_of(self, *kinds: str) -> int:
        """Return how many calls are of these kinds."""
        return sum(kind in kinds for kind, _ in self)


class FakeMemory:
    """Base of the fake textures and buffers: a size in bytes, whose content is zeros."""

    is_released, label, sampling, repeats, handle = False, "", Sampling.LINEAR, True, 1
    byte_count: int

    def write(self, data: Data, *_: Any, **__: Any) -> None:
        assert memoryview(data).nbytes <= self.byte_count

    def read(self, size: int = -1, offset: int = 0) -> bytes:
        return bytes(self.byte_count if size < 0 else size)

    def read_into(self, data: Data, *_: Any, **__: Any) -> None:
        memoryview(data)[:] = bytes(memoryview(data).nbytes)

    def release(self) -> None:
        self.is_released = True

    def nothing(self, *_: Any, **__: Any) -> None:
        """Accept any call and do nothing."""

    build_mipmaps = fill_with_nan = clear = copy_to = nothing


class FakeTexture(FakeMemory, Texture):
    """A texture of any kind."""

    def __init__(self, size: tuple[int, ...], components: int, dtype: str) -> None:
        self.size, self.components, self.dtype = size, components, dtype  # type: ignore[assignment]
        (self.width, self.height), self.layers = size[:2], size[-1]
        self.byte_count = int(np.prod(size)) * components * BYTES[dtype]


class FakeBuffer(FakeMemory, Buffer):
    """A buffer."""

    def __init__(self, size: int) -> None:
        self.orphan(size)

    def orphan(self, size: int = -1) -> None:
        self.size = self.byte_count = self.size if size < 0 else size


class FakeFramebuffer(FakeMemory, Framebuffer):
    """A framebuffer."""

    def __init__(self, calls: RecordedCalls, colors: Any) -> None:
        self.color_attachments = tuple(colors)
        self.size = colors[0].size if colors else (1, 1)
        self.byte_count = 16 * self.size[0] * self.size[1]
        self.clear = lambda *_, **__: calls.append(("clear", ""))  # type: ignore[method-assign]

    use = FakeMemory.nothing


class FakeProgram(LinkedCompute, LinkedDraw, LinkedArray):
    """A program and its vertices in one."""

    def __init__(self, calls: RecordedCalls, source: Any) -> None:
        self._calls, self._file = calls, source.files[0]

    def bind(self, *inputs: Any) -> None:
        self._calls.append(("bind", self._file))

    def run(self, groups: tuple[int, ...]) -> None:
        assert all(count > 0 for count in groups)
        self._calls.append(("dispatch", self._file))

    def run_indirect(self, groups: Buffer, offset: int) -> None:
        assert offset + 12 <= groups.size
        self._calls.append(("indirect", self._file))

    def vertex_array(self, *_: Any) -> "FakeProgram":
        return self

    def render(self, *_: Any) -> None:
        self._calls.append(("draw", self._file))

    render_indirect = render
    release = FakeMemory.nothing


class FakeDevice(FakeMemory, Device):
    """A device that claims to be a GPU."""

    library, name, vendor, version = "lists", "a list", "nobody", "1"
    is_software, error = False, ""
    limits = Limits(16384, 1 << 30, 1024)

    def __init__(self) -> None:
        self.calls, self.made_bytes, self.byte_count = RecordedCalls(), 0, 0

    def texture(self, size: Any, components: int, data: Any = None, dtype: str = "f1") -> Any:
        texture = FakeTexture(size, components, dtype)
        self.made_bytes += texture.byte_count
        return texture

    texture_array = texture3d = texture

    def shadow_map(self, size: tuple[int, int]) -> Any:
        return self.texture(size, 1, dtype="f4")

    depth_buffer = shadow_map

    def buffer(self, data: Any = None, reserve: int = 0) -> Any:
        buffer = FakeBuffer(reserve if data is None else memoryview(data).nbytes)
        self.made_bytes += buffer.size
        return buffer

    def framebuffer(self, colors: Any = (), depth: Any = None) -> Any:
        return FakeFramebuffer(self.calls, colors)

    def simple_framebuffer(self, size: tuple[int, int]) -> Any:
        return FakeFramebuffer(self.calls, [self.texture(size, 4)])

    def compute_program(self, source: Any) -> Any:
        return FakeProgram(self.calls, source)

    def draw_program(self, vertex: Any, fragment: Any) -> Any:
        return FakeProgram(self.calls, fragment)

    def draw_with(self, *_: Any, **__: Any) -> None:
        self.calls.append(("state", ""))

    timer = None  # type: ignore[assignment]  # there is nothing to measure
    finish = make_current = copy_framebuffer = FakeMemory.nothing  # type: ignore[assignment]
