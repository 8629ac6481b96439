"""Encode and decode the still of a look: a small JPEG in base64, stored in the shot file."""

import base64
import binascii
from io import BytesIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

_QUALITY = 85
_SIDE_MOST = 1024  # pixels; larger pictures are rejected


def still_of(pixels: NDArray[np.uint8]) -> str:
    """Return a picture, (H, W, 3), as the text of a still."""
    file = BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "JPEG", quality=_QUALITY)
    return base64.b64encode(file.getvalue()).decode("ascii")


def pixels_of_still(text: str) -> NDArray[np.uint8] | None:
    """Return the picture of a still, (H, W, 3); None for an invalid text."""
    try:
        data = base64.b64decode(text, validate=True)
        with Image.open(BytesIO(data), formats=["JPEG"]) as image:
            if max(image.size) > _SIDE_MOST:
                return None
            return np.asarray(image.convert("RGB"), np.uint8)
    except (binascii.Error, OSError, ValueError, Image.DecompressionBombError):
        return None
