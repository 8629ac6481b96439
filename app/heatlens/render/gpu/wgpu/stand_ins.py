"""Resources that are bound in place of others.

A small one stands where a program declares an input that it never uses: OpenGL's compilers remove
such inputs, the SPIR-V of a program keeps them. A copy stands for a texture that the program writes
too, and for counts that it may write: wgpu refuses both.
"""

from collections import OrderedDict
from typing import Any

import wgpu

from heatlens.render.gpu.wgpu.recorder import Recorder

_BYTES = 256
_COPIES_KEPT = 8  # textures of different sizes
_FORMATS = {"float": "rgba32float", "uint": "r32uint", "sint": "r32sint", "depth": "depth32float"}


class StandIns:
    """Textures, images and buffers that stand for others, made on first use."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._copies: OrderedDict[tuple[object, ...], tuple[Any, Any]] = OrderedDict()
        self._device = recorder.device
        self._views: dict[tuple[str, str, int], Any] = {}
        self._buffer: Any = None
        self._counts: Any = None

    def texture(self, layout: dict[str, object]) -> Any:
        """Return a texture for this layout of a binding."""
        kind, shape = str(layout["sample_type"]), str(layout["view_dimension"])
        return self._view(_FORMATS[kind], shape, wgpu.TextureUsage.TEXTURE_BINDING)

    def image(self, layout: dict[str, object]) -> Any:
        """Return an image for this layout of a binding."""
        format_, shape = str(layout["format"]), str(layout["view_dimension"])
        return self._view(format_, shape, wgpu.TextureUsage.STORAGE_BINDING)

    def buffer(self) -> Any:
        """Return a buffer of a few bytes."""
        if self._buffer is None:
            self._buffer = self._device.create_buffer(size=_BYTES, usage=wgpu.BufferUsage.STORAGE)
        return self._buffer

    def counts(self) -> Any:
        """Return a buffer into which the counts of a dispatch are copied."""
        if self._counts is None:
            usage = wgpu.BufferUsage.INDIRECT | wgpu.BufferUsage.COPY_DST
            self._counts = self._device.create_buffer(size=16, usage=usage)
        return self._counts

    def copy_of(self, name: str, texture: Any) -> Any:
        """Return a copy of what a texture contains now, for the input of this name."""
        size, format_ = texture.raw.size, texture.format
        key = name, size, format_
        if key not in self._copies:
            usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
            copy = self._device.create_texture(size=size, format=format_, usage=usage)
            self._copies[key] = copy, copy.create_view()
            if len(self._copies) > _COPIES_KEPT:
                self._recorder.destroy_after_use(self._copies.popitem(last=False)[1][0])
        self._copies.move_to_end(key)
        copy, view = self._copies[key]
        self._recorder.encoder().copy_texture_to_texture(
            {"texture": texture.raw}, {"texture": copy}, size
        )
        return view

    def _view(self, format_: str, shape: str, usage: int) -> Any:
        """Return a texture of one texel."""
        key = format_, shape, usage
        if key not in self._views:
            dimension = "3d" if shape == "3d" else "2d"
            texture = self._device.create_texture(
                size=(1, 1, 1), format=format_, usage=usage, dimension=dimension
            )
            self._views[key] = texture.create_view(dimension=shape)
        return self._views[key]
