"""Textures of wgpu.

Row 0 comes first in memory and has y = 0, as in OpenGL. wgpu has no textures of three components,
so these have a fourth one, 1, which is left out when they are read.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from itertools import count
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt
import wgpu

from heatlens.render.gpu.resources import (
    Area,
    Data,
    DepthBuffer,
    Sampling,
    Texture,
    Texture3D,
    TextureArray,
)
from heatlens.render.gpu.wgpu.recorder import Recorder

_NUMPY_TYPES = {
    "f1": np.uint8,
    "f2": np.float16,
    "f4": np.float32,
    "u1": np.uint8,
    "u2": np.uint16,
    "u4": np.uint32,
    "i1": np.int8,
    "i2": np.int16,
    "i4": np.int32,
}
_CHANNELS = {1: "r", 2: "rg", 3: "rgba", 4: "rgba"}
_NUMBERS = {"f1": "unorm", "f2": "float", "f4": "float", "u": "uint", "i": "sint"}
_TEXTURE_USAGE = (
    wgpu.TextureUsage.COPY_SRC
    | wgpu.TextureUsage.COPY_DST
    | wgpu.TextureUsage.TEXTURE_BINDING
    | wgpu.TextureUsage.STORAGE_BINDING
)
_DEPTH_USAGE = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING
DEPTH_FORMAT = "depth32float"
# wgpu numbers no textures, so those that ImGui draws get their numbers here; 0 means none
_HANDLES = count(1)
_WITH_HANDLES: "WeakValueDictionary[int, WgTexture]" = WeakValueDictionary()


def format_name(components: int, dtype: str) -> str:
    """Return wgpu's name of a format."""
    bits = 8 * np.dtype(_NUMPY_TYPES[dtype]).itemsize
    return f"{_CHANNELS[components]}{bits}{_NUMBERS.get(dtype) or _NUMBERS[dtype[0]]}"


def bytes_of(data: Data) -> memoryview:
    """Return the bytes of contiguous data, which are not copied."""
    content: Any = data  # the stub of memoryview does not know arrays
    return memoryview(content).cast("B")


class _WgSampled:
    """The common properties and methods of the three kinds of textures.

    view          the whole texture, for sampling
    storage_view  its largest level, for images and framebuffers
    """

    _dimension, _view_dimension = "2d", "2d"

    def __init__(
        self, recorder: Recorder, size: tuple[int, ...], components: int, dtype: str
    ) -> None:
        self._recorder, self.size = recorder, size
        self.components, self.dtype = components, dtype
        self.width, self.height, *_ = size
        self.label, self.sampling, self.repeats = "", Sampling.LINEAR, True
        self.format, self.numpy_type = format_name(components, dtype), _NUMPY_TYPES[dtype]
        self._texel_bytes = np.dtype(self.numpy_type).itemsize * (
            4 if components == 3 else components
        )
        self._make(levels=1)

    def _make(self, levels: int) -> None:
        """Take memory for the texture and its smaller levels."""
        usage = _TEXTURE_USAGE
        if self._dimension == "2d":
            usage |= wgpu.TextureUsage.RENDER_ATTACHMENT
        self.raw: Any = self._recorder.device.create_texture(
            size=(*self.size, 1)[:3],
            format=self.format,
            usage=usage,
            dimension=self._dimension,
            mip_level_count=levels,
        )
        self.view: Any = self.raw.create_view(dimension=self._view_dimension)
        self.storage_view: Any = self.raw.create_view(
            dimension=self._view_dimension, base_mip_level=0, mip_level_count=1
        )
        self._is_released = False

    @property
    def is_released(self) -> bool:
        return self._is_released

    def write(self, data: Data, viewport: Area | None = None) -> None:
        """Replace the content, or that of an area."""
        x, y, width, height = viewport or (0, 0, self.width, self.height)
        depth = (*self.size, 1)[2]
        pixels = self._with_four_components(data)
        self._recorder.submit()  # what is recorded comes before
        self._recorder.device.queue.write_texture(
            {"texture": self.raw, "mip_level": 0, "origin": (x, y, 0)},
            pixels,
            {
                "offset": 0,
                "bytes_per_row": width * self._texel_bytes,
                "rows_per_image": height,
            },
            (width, height, depth),
        )

    def read(self, level: int = 0) -> bytes:
        with self.texels(level=level) as texels:
            return texels.tobytes()

    def read_into(self, data: Data) -> None:
        with self.texels() as texels:
            np.copyto(np.frombuffer(bytes_of(data), self.numpy_type).reshape(texels.shape), texels)

    @contextmanager
    def texels(self, area: Area | None = None, level: int = 0) -> Iterator[npt.NDArray[np.generic]]:
        """Yield the texels of an area, (rows, width, components), which end with the block."""
        whole = (0, 0, max(1, self.width >> level), max(1, self.height >> level))
        x, y, width, height = area or whole
        source = {"texture": self.raw, "mip_level": level, "origin": (x, y, 0)}
        size = width, height, (*self.size, 1)[2]
        with self._recorder.texels(source, size, self._texel_bytes) as rows:
            texels = rows.view(self.numpy_type).reshape(len(rows), width, -1)
            yield texels[..., : self.components]

    def build_mipmaps(self) -> None:
        levels = max(self.width, self.height).bit_length()
        if self.raw.mip_level_count != levels:
            whole, previous = self.read(), self.raw
            self._make(levels)
            self.write(whole)
            previous.destroy()
        self._recorder.fill_smaller_levels(self.raw)

    def fill_with_nan(self) -> None:
        texels = self.components
        for side in self.size:
            texels *= side
        self.write(b"\xff" * (texels * np.dtype(self.numpy_type).itemsize))

    def release(self) -> None:
        if not self._is_released:
            self._is_released = True
            self._recorder.destroy_after_use(self.raw)

    def _with_four_components(self, data: Data) -> Any:
        """Return the data with a fourth component, if the texture has three."""
        if self.components != 3:
            return data
        pixels = np.frombuffer(data, self.numpy_type).reshape(-1, 3)
        return np.insert(pixels, 3, 255 if self.dtype == "f1" else 1, axis=1)


class WgTexture(_WgSampled, Texture):
    """A texture of wgpu."""

    size: tuple[int, int]

    @cached_property
    def handle(self) -> int:
        number = next(_HANDLES)
        _WITH_HANDLES[number] = self
        return number


def texture_of(handle: int) -> WgTexture | None:
    """Return the texture of a handle; None once it was released."""
    texture = _WITH_HANDLES.get(handle)
    return None if texture is None or texture.is_released else texture


class WgTextureArray(_WgSampled, TextureArray):
    """An array of textures of wgpu."""

    size: tuple[int, int, int]
    _view_dimension = "2d-array"

    def __init__(
        self, recorder: Recorder, size: tuple[int, int, int], components: int, dtype: str
    ) -> None:
        super().__init__(recorder, size, components, dtype)
        self.layers = size[2]


class WgTexture3D(_WgSampled, Texture3D):
    """A texture of wgpu in three dimensions."""

    size: tuple[int, int, int]
    _dimension = _view_dimension = "3d"


class WgShadowMap(WgTexture):
    """A texture of depths, which answers comparisons."""

    def __init__(self, recorder: Recorder, size: tuple[int, int]) -> None:
        super().__init__(recorder, size, 1, "f4")
        self.sampling, self.repeats = Sampling.LINEAR, False

    def _make(self, levels: int) -> None:
        self.format = DEPTH_FORMAT
        self.raw = self._recorder.device.create_texture(
            size=(*self.size, 1), format=DEPTH_FORMAT, usage=_DEPTH_USAGE
        )
        self.view = self.storage_view = self.raw.create_view()
        self._is_released = False


class WgDepthBuffer(DepthBuffer):
    """The depths beside the colors of a framebuffer."""

    def __init__(self, recorder: Recorder, size: tuple[int, int]) -> None:
        self._recorder = recorder
        self.raw: Any = recorder.device.create_texture(
            size=(*size, 1), format=DEPTH_FORMAT, usage=_DEPTH_USAGE
        )
        self.storage_view: Any = self.raw.create_view()

    def release(self) -> None:
        self._recorder.destroy_after_use(self.raw)
