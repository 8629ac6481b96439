"""Convert materials with specular colour and glossiness to metalness and roughness.

Both models describe a diffuse colour and a reflection at normal incidence. A reflection that is
stronger than that of glass or paint must come from a metal, which determines the metalness. Source:
Khronos, KHR_materials_pbrSpecularGlossiness and the conversion that its authors published with it.
"""

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.scene.scene import Array

_DIELECTRIC = 0.04  # reflectance of non-metals at normal incidence
_LEAST = 1e-6
_LUMA = np.array([0.299, 0.587, 0.114])
_SIDE_MOST_PX = 2048
_ROWS_AT_ONCE = 256

Pixels = NDArray[np.uint8]


def metal_and_base(diffuse: Array, specular: Array) -> tuple[Array, Array]:
    """Return the metallic share (...,) and the base colour (..., 3) of linear colours (..., 3)."""
    strength = 1.0 - specular.max(axis=-1)
    bright, shine = (np.sqrt((colors * colors) @ _LUMA) for colors in (diffuse, specular))
    b = bright * strength / (1 - _DIELECTRIC) + shine - 2 * _DIELECTRIC
    root = np.sqrt(np.maximum(b * b - 4 * _DIELECTRIC * (_DIELECTRIC - shine), 0.0))
    metal = np.clip((root - b) / (2 * _DIELECTRIC), 0.0, 1.0)
    metal = np.where(shine < _DIELECTRIC, 0.0, metal)
    share = metal[..., None]
    matt = diffuse * (strength / (1 - _DIELECTRIC) / np.maximum(1 - metal, _LEAST))[..., None]
    shiny = (specular - _DIELECTRIC * (1 - share)) / np.maximum(share, _LEAST)
    return metal, np.clip(matt + (shiny - matt) * share * share, 0.0, 1.0)


def converted_pictures(
    diffuse: tuple[Pixels | None, Array], specular: tuple[Pixels | None, Array]
) -> tuple[Pixels, Pixels]:
    """Return a base colour picture, and one with roughness in green and metal in blue.

    Each argument is a picture (H, W, 4), None for white, and its factor (4,): the diffuse colour
    and alpha, and the specular colour and glossiness.
    """
    size = common_size([picture for picture, _ in (diffuse, specular) if picture is not None])
    pictures = [resized(picture, size) for picture, _ in (diffuse, specular)]
    base, rough = np.empty((*size[::-1], 4), np.uint8), np.zeros((*size[::-1], 4), np.uint8)
    for row in range(0, size[1], _ROWS_AT_ONCE):
        rows = slice(row, row + _ROWS_AT_ONCE)
        matt, shiny = (
            _linear(picture[rows]) * factor
            for picture, factor in zip(pictures, (diffuse[1], specular[1]), strict=True)
        )
        metal, color = metal_and_base(matt[..., :3], shiny[..., :3])
        base[rows] = _bytes(np.concatenate([_encoded(color), matt[..., 3:]], axis=-1))
        rough[rows, :, 1], rough[rows, :, 2] = _bytes(1 - shiny[..., 3]), _bytes(metal)
    rough[..., 3] = 255
    return base, rough


def common_size(pictures: list[Pixels]) -> tuple[int, int]:
    """Return the largest width and height, within reason."""
    height, width = (max(p.shape[axis] for p in pictures) for axis in (0, 1))
    return min(width, _SIDE_MOST_PX), min(height, _SIDE_MOST_PX)


def resized(picture: Pixels | None, size: tuple[int, int]) -> Pixels:
    """Return a picture (H, W, 4) at a width and height, white for None."""
    if picture is None:
        return np.full((*size[::-1], 4), 255, np.uint8)
    if picture.shape[1::-1] == size:
        return picture
    channels = [Image.fromarray(np.ascontiguousarray(picture[..., i])) for i in range(4)]
    resized = [channel.resize(size, Image.Resampling.BILINEAR) for channel in channels]
    return np.stack([np.asarray(channel) for channel in resized], axis=-1)


def _linear(picture: Pixels) -> Array:
    """Return linear colours with unchanged alpha, from 0 to 1 (IEC 61966-2-1)."""
    shares = picture / 255.0
    colors = shares[..., :3]
    shares[..., :3] = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    return np.asarray(shares, np.float64)


def _encoded(colors: Array) -> Array:
    curve = 1.055 * np.maximum(colors, 0.0) ** (1 / 2.4) - 0.055
    return np.where(colors <= 0.0031308, 12.92 * colors, curve)


def _bytes(shares: Array) -> Pixels:
    return np.asarray(np.round(np.clip(shares, 0, 1) * 255), np.uint8)
