"""The pictures that colour a scene's surfaces, as layers of one texture."""

from collections.abc import Sequence

import moderngl
import numpy as np
import numpy.typing as npt
from PIL import Image

_SIDE_MOST_PX = 2048
_BYTES_MOST = 2**29  # of all layers together
_WHITE = np.full((1, 1, 4), 255, np.uint8)


def maps_of(
    ctx: moderngl.Context, images: Sequence[npt.NDArray[np.uint8]]
) -> moderngl.TextureArray:
    """Return `images` (H, W, 4) resampled to the largest size; bilinear, repeated, no mipmaps."""
    images = images or [_WHITE]
    size = layer_size(images)
    layers = np.stack([_resampled(image, size) for image in images])
    maps = ctx.texture_array((*size, len(images)), 4, layers.tobytes())
    maps.filter = (moderngl.LINEAR, moderngl.LINEAR)
    maps.repeat_x = maps.repeat_y = True
    return maps


def layer_size(images: Sequence[npt.NDArray[np.uint8]]) -> tuple[int, int]:
    """Return the (width, height) that holds each image, halved until all fit into memory."""
    height = min(max(image.shape[0] for image in images), _SIDE_MOST_PX)
    width = min(max(image.shape[1] for image in images), _SIDE_MOST_PX)
    while 4 * width * height * len(images) > _BYTES_MOST:
        width, height = max(width // 2, 1), max(height // 2, 1)
    return width, height


def _resampled(image: npt.NDArray[np.uint8], size: tuple[int, int]) -> npt.NDArray[np.uint8]:
    if image.shape[1::-1] == size:
        return image
    channels = [Image.fromarray(np.ascontiguousarray(image[..., i])) for i in range(4)]
    # Channel by channel: Pillow would weight colours by alpha, which is not coverage here.
    resized = [channel.resize(size, Image.Resampling.BILINEAR) for channel in channels]
    return np.stack([np.asarray(channel) for channel in resized], axis=-1)
