"""Textures as the passes need them: nearest, clamped, labelled; NumPy in and out."""

from typing import Literal

import moderngl
import numpy as np
import numpy.typing as npt

Storage = Literal["f2", "f4"]
FloatArray = npt.NDArray[np.float32]


def new_texture(
    ctx: moderngl.Context,
    size: tuple[int, int],
    components: int,
    storage: Storage = "f4",
    label: str = "",
) -> moderngl.Texture:
    """A texture of `size` (width, height), read texel by texel, edge-clamped."""
    texture = ctx.texture(size, components, dtype=storage)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    texture.repeat_x = texture.repeat_y = False
    texture.label = label
    return texture


def new_array(
    ctx: moderngl.Context,
    size: tuple[int, int],
    layers: int,
    components: int,
    storage: Storage = "f4",
) -> moderngl.TextureArray:
    """`layers` images of `size` behind one sampler."""
    array = ctx.texture_array((*size, layers), components, dtype=storage)
    array.filter = (moderngl.NEAREST, moderngl.NEAREST)
    array.repeat_x = array.repeat_y = False
    return array


def upload(texture: moderngl.Texture, pixels: FloatArray) -> None:
    """Write `pixels` (H, W) or (H, W, C), float32, into a float32 texture of that size."""
    texture.write(np.ascontiguousarray(pixels, np.float32).data.cast("B"))


def download(texture: moderngl.Texture) -> FloatArray:
    """The pixels of a texture as float32 (H, W) or (H, W, C), row 0 first."""
    width, height = texture.size
    dtype = np.float16 if texture.dtype == "f2" else np.float32
    pixels = np.frombuffer(texture.read(), dtype)
    shape = (height, width) if texture.components == 1 else (height, width, texture.components)
    return pixels.reshape(shape).astype(np.float32)
