"""Encode pictures for viewing with Pillow, with the marks of heatlens where each has room for them.

Files are encoded in memory, because Pillow silently cuts them short on a full disk.
"""

import io
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from heatlens.media.files.marks import IMAGE_DESCRIPTION, marks_comment

Stored = NDArray[np.uint8] | NDArray[np.uint16]  # whole numbers (H, W, 3 or 4)
_QUALITY = 95  # of JPEG and WebP


def encode_picture(image: Image.Image, kind: str, **options: object) -> bytes:
    """Return the bytes of a file of Pillow's format `kind`; `options` are passed on to Pillow."""
    encoded = io.BytesIO()
    image.save(encoded, format=kind, **options)
    return encoded.getvalue()


def png_bytes(values: Stored, marks: Mapping[str, str]) -> bytes:
    """Encode whole numbers of 8 bits, with each mark as a text."""
    info = PngInfo()
    for name, text in marks.items():
        info.add_text(name, text)
    return encode_picture(Image.fromarray(values), "PNG", pnginfo=info)


def jpeg_bytes(values: Stored, marks: Mapping[str, str]) -> bytes:
    """Encode whole numbers of 8 bits, with the marks as the comment."""
    comment_option = {"comment": marks_comment(marks)} if marks else {}
    return encode_picture(Image.fromarray(values), "JPEG", quality=_QUALITY, **comment_option)


def tiff_bytes(values: Stored, marks: Mapping[str, str]) -> bytes:
    """Encode whole numbers of 8 bits, with the marks as the description."""
    tag_option = {"tiffinfo": {IMAGE_DESCRIPTION: marks_comment(marks)}} if marks else {}
    image = Image.fromarray(values)
    return encode_picture(image, "TIFF", compression="tiff_adobe_deflate", **tag_option)


def webp_bytes(values: Stored, marks: Mapping[str, str]) -> bytes:
    """Encode whole numbers of 8 bits, with the marks as the description in EXIF.

    The colors of fully transparent pixels are kept: they are light that is added.
    """
    tags = Image.Exif()
    if marks:
        tags[IMAGE_DESCRIPTION] = marks_comment(marks)
    image = Image.fromarray(values)
    return encode_picture(image, "WEBP", quality=_QUALITY, exact=True, exif=tags)
