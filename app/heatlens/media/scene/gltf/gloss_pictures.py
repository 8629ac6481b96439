"""Convert the colors of glossy materials to base color, metal and roughness."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.media.scene.scene import Array

Pixels = NDArray[np.uint8]


_DIELECTRIC = 0.04  # reflectance of non-metals at normal incidence
_DIVISOR_LEAST = 1e-6
_LUMA = np.array([0.299, 0.587, 0.114])
_SIDE_MOST_PX, _ROWS_AT_ONCE = 2048, 256


def convert_specular(diffuse: Array, specular: Array) -> tuple[Array, Array]:
    """Return the metallic share (...,) and the base color (..., 3) of a glossy material.

    `diffuse` and `specular` are its linear colors (..., 3).
    """
    diffuse_strength = 1.0 - specular.max(axis=-1)
    diffuse_light, specular_light = (
        np.sqrt((colors * colors) @ _LUMA) for colors in (diffuse, specular)
    )
    # The coefficient of the quadratic equation for the metallic share in the conversion that
    # Khronos published.
    b = diffuse_light * diffuse_strength / (1 - _DIELECTRIC) + specular_light - 2 * _DIELECTRIC
    root = np.sqrt(np.maximum(b * b - 4 * _DIELECTRIC * (_DIELECTRIC - specular_light), 0.0))
    metal = np.clip((root - b) / (2 * _DIELECTRIC), 0.0, 1.0)
    metal = np.where(specular_light < _DIELECTRIC, 0.0, metal)
    share = metal[..., None]
    matt_color = (
        diffuse
        * (diffuse_strength / (1 - _DIELECTRIC) / np.maximum(1 - metal, _DIVISOR_LEAST))[..., None]
    )
    shiny_color = (specular - _DIELECTRIC * (1 - share)) / np.maximum(share, _DIVISOR_LEAST)
    return metal, np.clip(matt_color + (shiny_color - matt_color) * share * share, 0.0, 1.0)


def convert_gloss_pictures(
    diffuse: tuple[Pixels | None, Array], specular: tuple[Pixels | None, Array]
) -> tuple[Pixels, Pixels]:
    """Return a base color picture, and one with roughness in green and metal in blue.

    Each argument is a picture (H, W, 4), None for white, and its factor (4,): the diffuse color
    and alpha, and the specular color and glossiness.
    """
    size = common_size([picture for picture, _ in (diffuse, specular) if picture is not None])
    pictures = [resize_picture(picture, size) for picture, _ in (diffuse, specular)]
    base_color, roughness_metal = (
        np.empty((*size[::-1], 4), np.uint8),
        np.zeros((*size[::-1], 4), np.uint8),
    )
    for row in range(0, size[1], _ROWS_AT_ONCE):
        rows = slice(row, row + _ROWS_AT_ONCE)
        matt, shiny = (
            _decode_srgb(picture[rows]) * factor
            for picture, factor in zip(pictures, (diffuse[1], specular[1]), strict=True)
        )
        metal, color = convert_specular(matt[..., :3], shiny[..., :3])
        base_color[rows] = _convert_to_bytes(
            np.concatenate([_encode_srgb(color), matt[..., 3:]], axis=-1)
        )
        roughness_metal[rows, :, 1], roughness_metal[rows, :, 2] = (
            _convert_to_bytes(1 - shiny[..., 3]),
            _convert_to_bytes(metal),
        )
    roughness_metal[..., 3] = 255
    return base_color, roughness_metal


def common_size(pictures: list[Pixels]) -> tuple[int, int]:
    """Return the largest width and height, within reason."""
    height, width = (max(p.shape[axis] for p in pictures) for axis in (0, 1))
    return min(width, _SIDE_MOST_PX), min(height, _SIDE_MOST_PX)


def resize_picture(picture: Pixels | None, size: tuple[int, int]) -> Pixels:
    """Return a picture (H, W, 4) at a width and height, white for None."""
    if picture is None:
        return np.full((*size[::-1], 4), 255, np.uint8)
    if picture.shape[1::-1] == size:
        return picture
    channels = [Image.fromarray(np.ascontiguousarray(picture[..., i])) for i in range(4)]
    resized_channels = [channel.resize(size, Image.Resampling.BILINEAR) for channel in channels]
    return np.stack([np.asarray(channel) for channel in resized_channels], axis=-1)


def _decode_srgb(picture: Pixels) -> Array:
    """Return linear colors with unchanged alpha, from 0 to 1 (IEC 61966-2-1)."""
    shares = picture / 255.0
    colors = shares[..., :3]
    shares[..., :3] = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    return np.asarray(shares, np.float64)


def _encode_srgb(colors: Array) -> Array:
    """Return sRGB values of linear colors, both from 0 to 1."""
    curve = 1.055 * np.maximum(colors, 0.0) ** (1 / 2.4) - 0.055
    return np.where(colors <= 0.0031308, 12.92 * colors, curve)


def _convert_to_bytes(shares: Array) -> Pixels:
    """Return values of 0 to 1 as bytes."""
    return np.asarray(np.round(np.clip(shares, 0, 1) * 255), np.uint8)
