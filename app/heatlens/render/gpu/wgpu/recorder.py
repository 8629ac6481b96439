"""Record the work of a device, and hand it over when somebody must see the result.

Dispatches that follow each other share one compute pass, and draws into one framebuffer share one
render pass: wgpu itself makes each wait for what it reads. The values of loose uniforms of all
recorded work lie in one buffer, which is written once before the work is handed over. The pipelines
of the work are built on threads while it is recorded: drivers take up to a quarter second for one.
"""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

_UNIFORM_BYTES = 1 << 20  # values of uniforms that are recorded until the work is handed over
_ALIGNMENT = 256  # of the values of one dispatch or draw, and of rows that are read, as WebGPU asks
_KEPT_BYTES = 64 << 20  # a buffer for reading that is larger is not kept for the next time
# A draw of one triangle that fills the picture with the mean of the larger level.
_SMALLER_LEVEL = """
@group(0) @binding(0) var larger: texture_2d<f32>;
@group(0) @binding(1) var linear: sampler;
struct Corner { @builtin(position) position: vec4f, @location(0) at: vec2f }
@vertex fn corner(@builtin(vertex_index) number: u32) -> Corner {
    let at = vec2f(f32(number & 1u), f32(number >> 1u)) * 2.0;
    return Corner(vec4f(at.x * 2.0 - 1.0, 1.0 - at.y * 2.0, 0.0, 1.0), at);
}
@fragment fn mean(corner: Corner) -> @location(0) vec4f {
    return textureSample(larger, linear, corner.at);
}
"""


class _Calls:
    """Calls on an encoder, or on a pass of one, which are made when the work is handed over."""

    def __init__(self) -> None:
        self._calls: list[tuple[str, tuple[Any, ...], dict[str, Any], _Calls]] = []

    def __getattr__(self, name: str) -> Callable[..., "_Calls"]:
        return lambda *args, **words: self._record(name, args, words)

    def _record(self, name: str, args: tuple[Any, ...], words: dict[str, Any]) -> "_Calls":
        """Keep one call. Return what stands for its result: a pass, if it begins one."""
        result = _Calls() if name.startswith("begin_") else self
        self._calls.append((name, args, words, result))
        return result

    def make(self, target: Any) -> None:
        """Make the calls on `target`, and wait for pipelines that are still being built."""
        for name, args, words, result in self._calls:
            ready = [one.result() if isinstance(one, Future) else one for one in args]
            made = getattr(target, name)(*ready, **words)
            if result is not self:
                result.make(made)


class Recorder:
    """The work of one device that is not yet handed over.

    uniforms  the buffer with the values of loose uniforms
    """

    def __init__(self, device: Any) -> None:
        self.device = device
        usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST | wgpu.BufferUsage.COPY_SRC
        self.uniforms: Any = device.create_buffer(size=_UNIFORM_BYTES, usage=usage)
        self._values = bytearray()
        self._encoder: _Calls | None = None
        self._builders = ThreadPoolExecutor(os.cpu_count(), "pipelines")
        self._compute: _Calls | None = None
        self._render: _Calls | None = None
        self._render_key: object = None
        self._to_destroy: list[Any] = []
        self._read_buffer: Any = None
        self._level_pipelines: dict[str, Any] = {}

    def encoder(self) -> Any:
        """Return the encoder, outside of any pass."""
        self._end_pass()
        if self._encoder is None:
            self._encoder = _Calls()
        return self._encoder

    def compute_pass(self) -> Any:
        """Return the current compute pass, or a new one."""
        if self._compute is None:
            self._compute = self.encoder().begin_compute_pass()
        return self._compute

    def render_pass(self, key: object, attachments: dict[str, Any]) -> Any:
        """Return the current render pass if it was begun with the same `key`, or a new one."""
        if self._render is None or self._render_key != key:
            self._render = self.encoder().begin_render_pass(**attachments)
            self._render_key = key
        return self._render

    def place_of(self, values: bytes | bytearray) -> int:
        """Keep the values of one dispatch or draw. Return where they lie in `uniforms`.

        Ask for this before the pass: a full buffer hands the work over.
        """
        place = -(-len(self._values) // _ALIGNMENT) * _ALIGNMENT
        if place + len(values) > _UNIFORM_BYTES:
            self.submit()
            place = 0
        self._values += bytes(place - len(self._values))
        self._values += values
        return place

    def record_write(self, buffer: Any, offset: int, content: memoryview) -> None:
        """Write a few bytes into a buffer, after what is recorded before."""
        place = self.place_of(bytes(content))
        self.encoder().copy_buffer_to_buffer(self.uniforms, place, buffer, offset, len(content))

    def submit(self) -> None:
        """Hand over all that is recorded."""
        if self._encoder is None:
            return
        self._end_pass()
        if self._values:
            self._values += bytes(-len(self._values) % 4)
            self.device.queue.write_buffer(self.uniforms, 0, self._values)
            self._values = bytearray()
        encoder, calls = self.device.create_command_encoder(), self._encoder
        self._encoder = None
        calls.make(encoder)
        self.device.queue.submit([encoder.finish()])
        for one in self._to_destroy:
            one.destroy()
        self._to_destroy.clear()

    @contextmanager
    def texels(
        self, source: dict[str, Any], size: tuple[int, int, int], texel_bytes: int
    ) -> Iterator[npt.NDArray[np.uint8]]:
        """Yield the texels of a part of a texture, (rows, bytes), which end with the block.

        `source` names the texture, its level and the first texel; `size` is that of the part.
        """
        used = size[0] * texel_bytes
        row = -(-used // _ALIGNMENT) * _ALIGNMENT
        rows = size[1] * size[2]
        buffer = self._buffer_to_read(row * rows)
        target = {"buffer": buffer, "offset": 0, "bytes_per_row": row, "rows_per_image": size[1]}
        self.encoder().copy_texture_to_buffer(source, target, size)
        self.submit()
        buffer.map_async("READ_NOSYNC", 0, row * rows).sync_wait()
        mapped = np.frombuffer(buffer.read_mapped(0, row * rows, copy=False), np.uint8)
        try:
            yield mapped.reshape(rows, row)[:, :used]
        finally:
            buffer.unmap()
            if buffer.size > _KEPT_BYTES:
                self._read_buffer = None
                buffer.destroy()

    def _buffer_to_read(self, size: int) -> Any:
        """Return a buffer of at least `size` bytes, kept because new memory costs the most."""
        if self._read_buffer is None or self._read_buffer.size < size:
            if self._read_buffer is not None:
                self._read_buffer.destroy()
            usage = wgpu.BufferUsage.MAP_READ | wgpu.BufferUsage.COPY_DST
            self._read_buffer = self.device.create_buffer(size=size, usage=usage)
        return self._read_buffer

    def build_pipeline(self, build: Callable[..., Any], **words: Any) -> Future[Any]:
        """Begin to build a pipeline, which is set in a pass as if it were there already."""
        return self._builders.submit(build, **words)

    def destroy_after_use(self, resource: Any) -> None:
        """Give the memory of a texture or buffer back, after the recorded work."""
        if self._encoder is None:
            resource.destroy()
        else:
            self._to_destroy.append(resource)

    def finish(self) -> None:
        """Hand the work over and wait until it is done."""
        self.submit()
        # wgpu 0.32 fails in its own call that waits; what is read here comes after the work
        self.device.queue.read_buffer(self.uniforms, 0, 4)

    def release(self) -> None:
        """End the threads that build pipelines."""
        self._builders.shutdown()

    def fill_smaller_levels(self, texture: Any) -> None:
        """Draw each smaller level of a texture from the larger one before it."""
        pipeline = self._level_pipeline(texture.format)
        sampler = self.device.create_sampler(mag_filter="linear", min_filter="linear")
        for layer in range(texture.depth_or_array_layers):
            for level in range(1, texture.mip_level_count):
                larger, smaller = (
                    texture.create_view(
                        dimension="2d",
                        base_mip_level=one,
                        mip_level_count=1,
                        base_array_layer=layer,
                        array_layer_count=1,
                    )
                    for one in (level - 1, level)
                )
                group = self.device.create_bind_group(
                    layout=pipeline.get_bind_group_layout(0),
                    entries=[
                        {"binding": 0, "resource": larger},
                        {"binding": 1, "resource": sampler},
                    ],
                )
                color = {"view": smaller, "load_op": "clear", "store_op": "store"}
                draw = self.encoder().begin_render_pass(color_attachments=[color])
                draw.set_pipeline(pipeline)
                draw.set_bind_group(0, group)
                draw.draw(3)
                draw.end()

    def _level_pipeline(self, format_: str) -> Any:
        """Return the pipeline that draws a smaller level of a texture of this format."""
        if format_ not in self._level_pipelines:
            module = self.device.create_shader_module(code=_SMALLER_LEVEL)
            self._level_pipelines[format_] = self.device.create_render_pipeline(
                layout="auto",
                vertex={"module": module, "entry_point": "corner"},
                fragment={
                    "module": module,
                    "entry_point": "mean",
                    "targets": [{"format": format_}],
                },
                primitive={"topology": "triangle-list"},
            )
        return self._level_pipelines[format_]

    def _end_pass(self) -> None:
        """End the pass that is open."""
        for one in (self._compute, self._render):
            if one is not None:
                one.end()
        self._compute = self._render = self._render_key = None
