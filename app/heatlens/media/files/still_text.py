"""Write a small picture as text, as a look keeps its still, and read it back."""

import base64
import binascii
from io import BytesIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.media.files.opened_by_ending import open_embedded_picture

_QUALITY = 85
_MAX_SIDE = 1024  # pixels; larger pictures are rejected


def still_of(pixels: NDArray[np.uint8]) -> str:
    """Return a picture, (H, W, 3), as the text of a still."""
    file = BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "JPEG", quality=_QUALITY)
    return base64.b64encode(file.getvalue()).decode("ascii")


def pixels_of_still(text: str) -> NDArray[np.uint8] | None:
    """Return the picture of a still, (H, W, 3); None for an invalid text."""
    try:
        data = base64.b64decode(text, validate=True)
        with open_embedded_picture(data, ("JPEG",)) as image:
            if max(image.size) > _MAX_SIDE:
                return None
            return np.asarray(image.convert("RGB"), np.uint8)
    except (binascii.Error, OSError, ValueError, Image.DecompressionBombError):
        return None
