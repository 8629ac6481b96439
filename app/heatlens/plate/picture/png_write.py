"""Write scene-linear colour as 8-bit display values: PNG, JPEG or TIFF."""

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.base.errors import InputError
from heatlens.files.atomic_file import write_whole
from heatlens.plate.picture.display import srgb_encoded
from heatlens.plate.plate import FloatImage

_FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".tif": "TIFF", ".tiff": "TIFF"}
EYE_SUFFIXES = tuple(_FORMATS)
Whole = TypeVar("Whole", np.uint8, np.uint16)
_OPTIONS: dict[str, dict[str, object]] = {
    "JPEG": {"quality": 95},
    "TIFF": {"compression": "tiff_adobe_deflate"},
}


def write_png(
    path: str | os.PathLike[str],
    rgba: FloatImage,
    encode: Callable[[FloatImage], FloatImage] = srgb_encoded,
) -> None:
    """Write scene-linear `rgba`, (H, W, 3) or premultiplied (H, W, 4).

    `encode` converts light (H, W, 3) to display values, which are clamped to 0..1. If any pixel is
    not opaque, PNG and TIFF hold alpha with unpremultiplied colour, and JPEG shows the picture over
    black. Raises InputError if the file cannot be written.
    """
    kind = picture_format(path)
    light = _straight(rgba, keep_alpha=kind != "JPEG")
    shown = np.concatenate([encode(light[:, :, :3]), light[:, :, 3:]], axis=2)
    image = Image.fromarray(quantised(shown, np.uint8))
    write_whole(path, encoded_picture(image, kind))


def picture_format(path: str | os.PathLike[str]) -> str:
    """Return PNG, JPEG or TIFF for the suffix of a name. Raises InputError for another suffix."""
    kind = _FORMATS.get(Path(path).suffix.lower())
    if kind is None:
        raise InputError(f"{path}: pictures are written as {', '.join(_FORMATS)}.")
    return kind


def encoded_picture(image: Image.Image, kind: str, **options: object) -> bytes:
    """Return the bytes of a file of the format `kind`; `options` are passed on to Pillow.

    The file is encoded in memory, because Pillow silently cuts it short on a full disk.
    """
    encoded = io.BytesIO()
    image.save(encoded, format=kind, **_OPTIONS.get(kind, {}), **options)
    return encoded.getvalue()


def _straight(rgba: FloatImage, keep_alpha: bool) -> FloatImage:
    """Return light (H, W, 3), or unpremultiplied (H, W, 4) if alpha is kept and not all opaque."""
    rgb = rgba[:, :, :3]
    if not keep_alpha or rgba.shape[2] == 3 or not (rgba[:, :, 3] < 1).any():
        return rgb
    alpha = np.nan_to_num(np.clip(rgba[:, :, 3:], 0.0, 1.0))
    straight = np.divide(rgb, alpha, out=rgb.copy(), where=alpha > 0)
    return np.concatenate([straight, alpha], axis=2)


def quantised(display: FloatImage, kind: type[Whole], white: int | None = None) -> NDArray[Whole]:
    """Convert 0..1 to rounded integers of `kind`; values outside, which a view may give, clip.

    `white` is the integer for 1, by default the largest.
    """
    most = np.float32(white or np.iinfo(kind).max)
    scaled = np.clip(np.nan_to_num(display, nan=0.0), 0.0, 1.0) * most
    return (scaled + np.float32(0.5)).astype(kind)
