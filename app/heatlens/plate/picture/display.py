"""The sRGB curve, from scene-linear light to display values and back."""

import numpy as np
from numpy.typing import ArrayLike

from heatlens.plate.plate import FloatImage


def srgb_encoded(linear: ArrayLike) -> FloatImage:
    """Convert linear light of any shape to sRGB values, clamped to 0..1; NaN becomes 0.

    The curve of IEC 61966-2-1: 12.92 x up to 0.0031308, 1.055 x^(1/2.4) - 0.055 above.
    """
    light = np.nan_to_num(np.asarray(linear, dtype=np.float32), nan=0.0, posinf=1.0, neginf=0.0)
    light = np.clip(light, 0.0, 1.0)
    curve = 1.055 * np.power(light, np.float32(1 / 2.4)) - 0.055
    encoded: FloatImage = np.where(light <= 0.0031308, 12.92 * light, curve).astype(np.float32)
    return encoded


def srgb_decoded(encoded: ArrayLike) -> FloatImage:
    """Convert sRGB values of any shape to linear light; the inverse of `srgb_encoded` in 0..1."""
    values = np.asarray(encoded, dtype=np.float32)
    curve = np.power((np.maximum(values, 0.0) + 0.055) / 1.055, np.float32(2.4))
    light: FloatImage = np.where(values <= 0.04045, values / 12.92, curve).astype(np.float32)
    return light
