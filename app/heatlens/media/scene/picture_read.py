"""Read the pictures of materials as 8-bit RGBA from the bytes of a PNG, JPEG or WebP."""

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from heatlens.core.base.errors import InputError
from heatlens.media.files.opened_by_ending import open_embedded_picture

# GPUs allow no larger textures; a damaged header can claim any size.
_SIDE_MOST_PX = 16384
_PIXELS_MOST = 1 << 27
_TOGETHER_MOST = 1 << 29


def read_picture(
    data: bytes, label: str, earlier_pictures: Sequence[NDArray[np.uint8]] = ()
) -> NDArray[np.uint8]:
    """Read a picture as (H, W, 4) with row 0 on top; `label` names it in errors.

    Raises InputError if the picture is damaged, has an unknown format or is too large, alone or
    together with `earlier_pictures`, which were read for the same scene.
    """
    earlier_pixels = sum(picture.size // 4 for picture in earlier_pictures)
    try:
        with warnings.catch_warnings(), open_embedded_picture(data) as image:
            warnings.simplefilter("ignore")  # warnings about odd but readable headers
            _check_size(image, label)
            if earlier_pixels + image.width * image.height > _TOGETHER_MOST:
                raise InputError(
                    f"{label}: all pictures of a scene may have {_TOGETHER_MOST:,} pixels "
                    "together, and with this one they have more. Make them smaller."
                )
            return pixels_of_image(image)
    except UnidentifiedImageError:
        raise InputError(f"{label}: this is not a picture in PNG, JPEG or WebP.") from None
    except (OSError, ValueError, SyntaxError, ArithmeticError, Image.DecompressionBombError) as e:
        raise InputError(f"{label}: the picture is damaged or cut short ({e}).") from e


def pixels_of_image(image: Image.Image) -> NDArray[np.uint8]:
    """Convert a picture in any mode to RGBA (H, W, 4) with row 0 on top."""
    if image.mode.startswith("I"):  # 16-bit gray, which Pillow would clip
        grey = np.asarray(image).astype(np.uint32) >> 8
        image = Image.fromarray(np.minimum(grey, 255).astype(np.uint8))
    return np.array(image.convert("RGBA"))


def _check_size(image: Image.Image, label: str) -> None:
    """Raise InputError for an empty picture, or one that is too large for a surface."""
    width, height = image.size
    if max(width, height) > _SIDE_MOST_PX or width * height > _PIXELS_MOST or not width * height:
        raise InputError(
            f"{label}: a picture of {width} x {height} pixels is too large for a surface; "
            f"{_SIDE_MOST_PX} a side and {_PIXELS_MOST:,} in all are the most."
        )
