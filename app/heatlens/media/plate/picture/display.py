"""Curves of stored pictures: sRGB, and the log of cameras, to scene-linear light in Rec.709."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import ocio
from heatlens.media.plate.plate import FloatImage

# The full name, because another version of the library could have another config.
_CONFIG = "studio-config-v2.2.0_aces-v1.3_ocio-v2.4"
_LINEAR = "Linear Rec.709 (sRGB)"


def encode_srgb(linear: ArrayLike) -> FloatImage:
    """Convert linear light of any shape to sRGB values, clamped to 0..1; NaN becomes 0.

    The curve of IEC 61966-2-1: 12.92 x up to 0.0031308, 1.055 x^(1/2.4) - 0.055 above.
    """
    light = np.nan_to_num(np.asarray(linear, dtype=np.float32), nan=0.0, posinf=1.0, neginf=0.0)
    light = np.clip(light, 0.0, 1.0)
    curve = 1.055 * np.power(light, np.float32(1 / 2.4)) - 0.055
    encoded: FloatImage = np.where(light <= 0.0031308, 12.92 * light, curve).astype(np.float32)
    return encoded


def decode_srgb(encoded: ArrayLike) -> FloatImage:
    """Convert sRGB values of any shape to linear light; the inverse of `encode_srgb` in 0..1."""
    values = np.asarray(encoded, dtype=np.float32)
    curve = np.power((np.maximum(values, 0.0) + 0.055) / 1.055, np.float32(2.4))
    light: FloatImage = np.where(values <= 0.04045, values / 12.92, curve).astype(np.float32)
    return light


def decode_camera_log(path: Path, signal: FloatImage, color_space: str) -> FloatImage:
    """Return light (H, W, 3 or 4) of a signal of 0 to 1 in a color space of OpenColorIO.

    Middle gray becomes 0.18; alpha stays. Raises InputError for a gray picture.
    """
    if signal.shape[2] not in (3, 4):
        raise InputError(
            f"{path} is grey, and the log of a camera is for pictures of three colours: give "
            "another --picture-curve."
        )
    light: FloatImage = np.ascontiguousarray(signal, np.float32)
    apply = _linear_processor(color_space).applyRGB if light.shape[2] == 3 else None
    (apply or _linear_processor(color_space).applyRGBA)(light)
    return light


@lru_cache(maxsize=4)
def _linear_processor(color_space: str) -> Any:
    """Return the processor of OpenColorIO from a color space to linear Rec.709."""
    config = ocio().Config.CreateFromBuiltinConfig(_CONFIG)
    return config.getProcessor(color_space, _LINEAR).getDefaultCPUProcessor()
