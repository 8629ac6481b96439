"""A rendered picture in half floats with its windows, and its file format."""

import json
import math
import struct
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from heatlens.gpu.textures import FloatArray
from heatlens.model.boxes import Box

HalfImage = npt.NDArray[np.float16]

_HALF_MOST = 65504.0  # the largest half float; larger values would become infinite
_MAGIC = b"HLframe1"
_HEAD = struct.Struct("<8sII")  # magic, CRC-32 of the rest, length of the description


@dataclass(frozen=True, eq=False)
class RenderedPicture:
    """One frame as it was rendered: a KeptPicture with (H, W, 4) float32 pixels."""

    pixels: FloatArray
    data_window: Box
    display_window: Box
    pixel_aspect: float = 1.0

    def kept(self) -> "KeptPicture":
        """Return the picture in half floats; this takes a while."""
        half = half_of(self.pixels)
        return KeptPicture(half, self.data_window, self.display_window, self.pixel_aspect)


@dataclass(frozen=True, eq=False)
class KeptPicture:
    """One frame.

    pixels          (H, W, 4) half floats, scene-linear, premultiplied
    data_window     that of the plate it was rendered from, in pixels of the plate
    display_window  that of the same plate
    pixel_aspect    width of a pixel divided by its height
    """

    pixels: HalfImage
    data_window: Box
    display_window: Box
    pixel_aspect: float = 1.0

    def kept(self) -> "KeptPicture":
        """Return the picture itself."""
        return self


def half_of(pixels: FloatArray) -> HalfImage:
    """Round float32 pixels to half floats, clamped to the largest half float."""
    return np.clip(pixels, -_HALF_MOST, _HALF_MOST).astype(np.float16)


def encoded(picture: KeptPicture, key: str) -> bytes:
    """Return the bytes of a file that holds `picture` under `key`."""
    height, width = picture.pixels.shape[:2]
    windows = [_corners(box) for box in (picture.data_window, picture.display_window)]
    facts = {"key": key, "size": [width, height], "windows": windows}
    words = json.dumps(facts | {"pixel_aspect": picture.pixel_aspect}).encode()
    pixels = np.ascontiguousarray(picture.pixels).data.cast("B")
    check = zlib.crc32(pixels, zlib.crc32(words))
    return b"".join((_HEAD.pack(_MAGIC, check, len(words)), words, pixels))


def decoded(data: bytes, key: str) -> KeptPicture | None:
    """Return the picture that `encoded` wrote under `key`; None for other or damaged data."""
    if len(data) < _HEAD.size:
        return None
    magic, check, count = _HEAD.unpack_from(data)
    if magic != _MAGIC or zlib.crc32(memoryview(data)[_HEAD.size :]) != check:
        return None
    try:
        facts = json.loads(data[_HEAD.size : _HEAD.size + count])
        return _picture(facts, data, _HEAD.size + count) if facts["key"] == key else None
    except (ValueError, KeyError, TypeError):  # intact, but written by another program
        return None


def _picture(facts: dict[str, Any], data: bytes, offset: int) -> KeptPicture:
    """Return the picture of a description. Raises ValueError if no renderer could have made it."""
    width, height = facts["size"]
    pixels = np.frombuffer(data, np.float16, offset=offset).reshape(height, width, 4)
    aspect, corners = float(facts["pixel_aspect"]), np.array(facts["windows"])
    is_whole = corners.dtype.kind == "i" and np.abs(corners).max() < 1 << 31
    is_possible = is_whole and 0 < aspect < math.inf and (corners[:, 2:] > corners[:, :2]).all()
    if not (is_possible and np.isfinite(pixels).all()):
        raise ValueError("this is not a rendered picture")
    data_window, display_window = (Box(*map(int, box)) for box in corners)
    return KeptPicture(pixels, data_window, display_window, aspect)


def _corners(box: Box) -> tuple[int, int, int, int]:
    return box.x0, box.y0, box.x1, box.y1
