"""Make the textures of passes (nearest, clamped, labeled), and move NumPy data in and out.

Storage buffers can be divided into equal parts that are bound like separate buffers.
"""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from heatlens.core.base.errors import GpuError
from heatlens.core.model.lens.aperture import Aperture
from heatlens.render.gpu.device import Device, DeviceError
from heatlens.render.gpu.resources import Buffer, BufferPart, Sampling, Texture, TextureArray

Storage = Literal["f2", "f4", "u4"]
FloatArray = npt.NDArray[np.float32]
_BAND_BYTES = 16 << 20  # uploaded at a time, which takes a few milliseconds
_OPENINGS_MAX = 4  # enough for four looks side by side


@contextmanager
def _tell_missing_memory(ctx: Device, resource: str) -> Iterator[None]:
    """Raise GpuError if the device refuses a resource; moderngl ignores failed allocations."""
    reason = ctx.error  # of an earlier call, which would be taken for missing memory
    try:
        yield
        reason = ctx.error
    except DeviceError as error:
        reason = error.reason
    if reason:
        raise GpuError(
            f"{ctx.library} could not make {resource} ({reason}). "
            "A smaller --proxy needs less memory."
        )


def new_texture(
    ctx: Device, size: tuple[int, int], components: int, storage: Storage = "f4", label: str = ""
) -> Texture:
    """Make a texture of `size` (width, height), read texel by texel, edge-clamped."""
    with _tell_missing_memory(ctx, f"a {size[0]}x{size[1]} texture"):
        texture = ctx.texture(size, components, dtype=storage)
    texture.sampling = Sampling.NEAREST
    texture.repeats = False
    texture.label = label
    return texture


def new_array(
    ctx: Device, size: tuple[int, int], layers: int, components: int, storage: Storage = "f4"
) -> TextureArray:
    """Make an array texture of `layers` images of `size`."""
    with _tell_missing_memory(ctx, f"{layers} layers of {size[0]}x{size[1]}"):
        array = ctx.texture_array((*size, layers), components, dtype=storage)
    array.sampling = Sampling.NEAREST
    array.repeats = False
    return array


def new_buffer(ctx: Device, size_bytes: int) -> Buffer:
    """Make a storage buffer. Raises GpuError if there is no memory for it."""
    with _tell_missing_memory(ctx, f"a buffer of {size_bytes / 1e6:.0f} MB"):
        buffer = ctx.buffer(reserve=size_bytes)
    return buffer


def enlarge(ctx: Device, buffer: Buffer, size_bytes: int) -> None:
    """Give a buffer `size_bytes` of new memory. Raises GpuError if there is none."""
    with _tell_missing_memory(ctx, f"a buffer of {size_bytes / 1e6:.0f} MB"):
        buffer.orphan(size_bytes)


def upload(texture: Texture, pixels: FloatArray) -> None:
    """Write `pixels` (H, W) or (H, W, C), float32, into a float32 texture of that size."""
    texture.write(np.ascontiguousarray(pixels, np.float32).data.cast("B"))


def upload_steps(texture: Texture, pixels: FloatArray) -> Iterator[None]:
    """Write `pixels` as `upload` does, band by band, so that a window can answer in between."""
    width, height = texture.size
    rows = max(1, _BAND_BYTES // max(1, 4 * texture.components * width))
    pixels = np.ascontiguousarray(pixels, np.float32)
    for row in range(0, height, rows):
        band = pixels[row : row + rows]
        texture.write(band.data.cast("B"), viewport=(0, row, width, len(band)))
        yield


def download(texture: Texture) -> FloatArray:
    """Return the pixels of a float texture as (H, W) or (H, W, C) float32, row 0 first."""
    width, height = texture.size
    shape = (height, width) if texture.components == 1 else (height, width, texture.components)
    pixels = np.empty(shape, np.float16 if texture.dtype == "f2" else np.float32)
    texture.read_into(pixels.data.cast("B"))
    return pixels.astype(np.float32, copy=False)


class TexturePool:
    """Textures by name, made on first use and again only if their size or type changes."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._textures: dict[str, tuple[tuple[object, ...], Texture]] = {}
        self._arrays: dict[str, tuple[tuple[object, ...], TextureArray]] = {}
        self._buffers: dict[str, Buffer] = {}

    def texture(
        self, name: str, size: tuple[int, int], components: int, storage: Storage = "f4"
    ) -> Texture:
        """Return the texture called `name`; its contents are whatever was last written."""
        kind = (size, components, storage)
        if name in self._textures and self._textures[name][0] == kind:
            return self._textures[name][1]
        if name in self._textures:
            self._textures[name][1].release()
        self._textures[name] = (kind, new_texture(self._ctx, size, components, storage, name))
        return self._textures[name][1]

    def array(
        self,
        name: str,
        size: tuple[int, int],
        layers: int,
        components: int,
        storage: Storage = "f4",
    ) -> TextureArray:
        """Return the array called `name`, `layers` deep."""
        kind = (size, layers, components, storage)
        if name in self._arrays and self._arrays[name][0] == kind:
            return self._arrays[name][1]
        if name in self._arrays:
            self._arrays[name][1].release()
        self._arrays[name] = (kind, new_array(self._ctx, size, layers, components, storage))
        return self._arrays[name][1]

    def buffer(self, name: str, size_bytes: int) -> Buffer:
        """Return the storage buffer called `name`, at least `size_bytes` large."""
        if name not in self._buffers:
            self._buffers[name] = new_buffer(self._ctx, size_bytes)
        elif self._buffers[name].size < size_bytes:
            enlarge(self._ctx, self._buffers[name], size_bytes)
        return self._buffers[name]

    def release(self, kept: Collection[str] = ()) -> None:
        """Delete all textures and buffers but those with a name in `kept`."""
        for kinds in (self._textures, self._arrays):
            for name in kinds.keys() - set(kept):
                kinds.pop(name)[1].release()
        for name in self._buffers.keys() - set(kept):
            self._buffers.pop(name).release()


class OpeningTextures:
    """Textures for lib/opening_image.lib.glsl, of the most recently used openings."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._textures: dict[object, Texture] = {}

    def of(self, aperture: Aperture) -> dict[str, Texture]:
        """Return the textures by their names in the shader; none for an opening without an image.

        Raises LensError if the file of the image was not read.
        """
        grid = aperture.grid
        if grid is None:
            return {}
        key = (aperture.aperture_image, aperture.blade_rotation_deg)
        texture = self._textures.pop(key, None)
        if texture is None:
            side = len(grid.sums)
            texture = new_texture(self._ctx, (side, side), 1, "u4", "opening")
            texture.write(np.ascontiguousarray(grid.sums, np.uint32).tobytes())
        self._textures[key] = texture  # the latest is last
        while len(self._textures) > _OPENINGS_MAX:
            self._textures.pop(next(iter(self._textures))).release()
        return {"aperture_image_tx": texture}

    def release(self) -> None:
        """Release everything on the GPU."""
        for texture in self._textures.values():
            texture.release()
        self._textures.clear()


_PART_ALIGNMENT = 256  # every driver can bind a part that begins at a multiple of this


@dataclass(frozen=True)
class BufferParts:
    """A buffer as parts of `part_bytes` each."""

    whole: Buffer
    part_bytes: int

    @staticmethod
    def bytes_for(least_bytes: int) -> int:
        """Return the size of a part of at least `least_bytes`, as drivers can bind it."""
        return -(-least_bytes // _PART_ALIGNMENT) * _PART_ALIGNMENT

    @property
    def words(self) -> int:
        """The number of 32-bit words of a part."""
        return self.part_bytes // 4

    def __getitem__(self, index: int) -> BufferPart:
        return BufferPart(self.whole, first=index * self.part_bytes, size=self.part_bytes)
