"""Textures, buffers and framebuffers of OpenGL.

Textures and buffers have moderngl's own bound methods as attributes (`use`, `bind_image`,
`bind_storage`), because a method that calls these would take a tenth of the time of a frame.
"""

from collections.abc import Sequence
from typing import Any

import moderngl

from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import (
    Area,
    Buffer,
    Data,
    DepthBuffer,
    Sampling,
    Texture,
    Texture3D,
    TextureArray,
)

# All bits set: NaN in float16 and float32, the largest number in unsigned integers.
_BYTE = b"\xff"
_SIZES = {"f1": 1, "f2": 2, "f4": 4, "i1": 1, "i2": 2, "i4": 4, "u1": 1, "u2": 2, "u4": 4}
_FILTERS = {
    Sampling.NEAREST: (moderngl.NEAREST, moderngl.NEAREST),
    Sampling.LINEAR: (moderngl.LINEAR, moderngl.LINEAR),
    Sampling.MIPMAPPED: (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR),
}
_SAMPLINGS = {filter_: sampling for sampling, filter_ in _FILTERS.items()}


class _GlSampled:
    """The common properties and methods of the three kinds of textures."""

    _axes: tuple[str, ...] = ("repeat_x", "repeat_y")

    def __init__(self, raw: Any) -> None:
        self.raw, self.use, self.bind_image = raw, raw.use, getattr(raw, "bind_to_image", None)
        self.size, self.components, self.dtype = raw.size, raw.components, raw.dtype
        self.width, self.height, *_ = raw.size
        self._repeats = True

    @property
    def is_released(self) -> bool:
        return isinstance(self.raw.mglo, moderngl.InvalidObject)

    @property
    def label(self) -> str:
        """The name that debuggers show."""
        return str(self.raw.label or "")

    @label.setter
    def label(self, words: str) -> None:
        self.raw.label = words

    @property
    def sampling(self) -> Sampling:
        """How a shader samples the texture between its texels."""
        return _SAMPLINGS[self.raw.filter]

    @sampling.setter
    def sampling(self, sampling: Sampling) -> None:
        self.raw.filter = _FILTERS[sampling]

    @property
    def repeats(self) -> bool:
        """True if the texture is repeated beyond its edge, False if its edge is clamped."""
        return self._repeats

    @repeats.setter
    def repeats(self, repeats: bool) -> None:
        self._repeats = repeats
        for axis in self._axes:
            setattr(self.raw, axis, repeats)

    def write(self, data: Data, viewport: Area | None = None) -> None:
        """Replace the content, or that of an area."""
        self.raw.write(data, viewport=viewport)

    def read(self) -> bytes:
        return bytes(self.raw.read())

    def build_mipmaps(self) -> None:
        self.raw.build_mipmaps()

    def fill_with_nan(self) -> None:
        self.raw.ctx.memory_barrier()  # a GPU may still draw from it
        texels = self.components * _SIZES[self.dtype]
        for side in self.size:
            texels *= side
        self.raw.write(_BYTE * texels)

    def release(self) -> None:
        self.raw.release()


class GlTexture(_GlSampled, Texture):
    """A texture of OpenGL."""

    @property
    def handle(self) -> int:
        """The number of OpenGL, by which ImGui draws it."""
        return int(self.raw.glo)

    def read(self, level: int = 0) -> bytes:
        return bytes(self.raw.read(level=level))

    def read_into(self, data: Data) -> None:
        self.raw.read_into(data)


class GlTextureArray(_GlSampled, TextureArray):
    """An array of textures of OpenGL."""

    def __init__(self, raw: moderngl.TextureArray) -> None:
        super().__init__(raw)
        self.layers = raw.layers


class GlTexture3D(_GlSampled, Texture3D):
    """A texture of OpenGL in three dimensions."""

    _axes = ("repeat_x", "repeat_y", "repeat_z")


class GlBuffer(Buffer):
    """A buffer of OpenGL, filled with NaN whenever it is new if `fills_nan`."""

    def __init__(self, raw: moderngl.Buffer, fills_nan: bool) -> None:
        self.raw, self.bind_storage = raw, raw.bind_to_storage_buffer
        self.size, self._fills_nan = raw.size, fills_nan

    def write(self, data: Data, offset: int = 0) -> None:
        self.raw.write(data, offset=offset)

    def read(self, size: int = -1, offset: int = 0) -> bytes:
        return self.raw.read(size, offset=offset)

    def clear(self) -> None:
        self.raw.clear()

    def orphan(self, size: int = -1) -> None:
        self.raw.orphan(size)
        self.size = self.raw.size
        if self._fills_nan:
            self.fill_with_nan()

    def copy_to(self, other: Buffer) -> None:
        self.raw.ctx.copy_buffer(raw_buffer(other), self.raw, self.size)

    def fill_with_nan(self) -> None:
        self.raw.ctx.memory_barrier()  # a GPU may still draw from it
        self.raw.write(_BYTE * self.size)

    def release(self) -> None:
        self.raw.release()


class GlDepthBuffer(DepthBuffer):
    """A buffer of depths of OpenGL."""

    def __init__(self, raw: moderngl.Renderbuffer) -> None:
        self.raw = raw

    def release(self) -> None:
        self.raw.release()


class GlFramebuffer(Framebuffer):
    """A framebuffer of OpenGL."""

    def __init__(self, raw: moderngl.Framebuffer, colors: Sequence[Texture] = ()) -> None:
        self.raw, self.size, self.color_attachments = raw, raw.size, tuple(colors)
        self._clear = raw.clear

    @property
    def viewport(self) -> Area:
        """The area of the framebuffer that draws write into."""
        return self.raw.viewport

    @viewport.setter
    def viewport(self, area: Area) -> None:
        self.raw.viewport = area

    @property
    def scissor(self) -> Area | None:
        """The only area that is drawn and cleared; None for no limit."""
        return self.raw.scissor

    @scissor.setter
    def scissor(self, area: Area | None) -> None:
        raw: Any = self.raw  # its stub does not know None
        raw.scissor = area

    @property
    def writes_color(self) -> bool:
        """False leaves the colors as they are."""
        mask: Any = self.raw.color_mask
        return any(mask)

    @writes_color.setter
    def writes_color(self, writes: bool) -> None:
        self.raw.color_mask = (writes,) * 4

    @property
    def writes_depth(self) -> bool:
        """False leaves the depths as they are."""
        return self.raw.depth_mask

    @writes_depth.setter
    def writes_depth(self, writes: bool) -> None:
        self.raw.depth_mask = writes

    def use(self) -> None:
        self.raw.use()

    def clear(
        self, red: float = 0.0, green: float = 0.0, blue: float = 0.0, alpha: float = 0.0
    ) -> None:
        self._clear(red, green, blue, alpha)

    def read(self, viewport: Area | None = None, components: int = 3, dtype: str = "f1") -> bytes:
        area: Any = viewport  # its stub does not know None
        return self.raw.read(viewport=area, components=components, dtype=dtype)

    def read_into(self, data: Data, components: int = 3) -> None:
        self.raw.read_into(data, components=components)

    def release(self) -> None:
        self.raw.release()


def raw_buffer(buffer: Buffer) -> moderngl.Buffer:
    """Return the buffer of moderngl that a buffer of this device wraps."""
    assert isinstance(buffer, GlBuffer)
    return buffer.raw
