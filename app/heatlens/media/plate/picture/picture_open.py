"""Read the stored values of pictures other than EXR: PNG, JPEG, DPX, NumPy and others.

Pillow reads pictures with 8 bits a channel, and single channels of 16 or 32 bits. Pictures that it
would silently reduce to 8 bits are read by OpenImageIO. That is an optional extra, and so is HEIC.

A capture by Record3D is rgb/12.jpg and depth/12.exr with metadata.json beside them. This file gives
the matrix of the camera by columns, in pixels of `w` x `h`, and the frame rate.
"""

import contextlib
import importlib.util
import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageOps, features

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import BASE, import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import open_regular_file, read_file_bytes, unreadable_error
from heatlens.media.files.apart import call_in_process
from heatlens.media.files.limits import allow_for, is_bounded
from heatlens.media.files.opened_by_ending import open_with_pillow
from heatlens.media.files.picture_formats import movie_of_frame
from heatlens.media.plate.picture.capture_folder import capture_info
from heatlens.media.plate.picture.movie_picture import read_movie_info, read_movie_values
from heatlens.media.plate.picture.openimageio_read import check_size, read_by_openimageio
from heatlens.media.plate.picture.pfm import read_pfm
from heatlens.media.plate.picture.portrait import portrait_header

_MODES = {"1": "L", "P": "RGB", "CMYK": "RGB", "YCbCr": "RGB", "PA": "RGBA", "LAB": "RGB"}
_HEIC = (".heic", ".heif")
_ORIENTATION = 0x0112  # tag of EXIF
_HEAD_BYTES = 4096  # start of an AVIF that holds its description


@dataclass(frozen=True, eq=False)
class RawPicture:
    """Stored values (H, W, C) of 8, 16 or 32 bits, with 1 to 4 channels, and their metadata.

    `info` holds the metadata that Pillow found: profile, EXIF, segments, depth images. For a frame
    of a movie it holds the facts of `read_movie_info`. `white` is the value of white if it is not
    the largest value of the type.
    """

    values: NDArray[Any]
    info: dict[str, Any] = field(default_factory=dict)
    white: float | None = None

    @property
    def full_scale(self) -> float | None:
        """The value of white for integers; None for floating point."""
        kind = self.values.dtype
        return self.white or (float(np.iinfo(kind).max) if kind.kind in "ui" else None)


def open_picture(path: Path) -> RawPicture:
    """Read a whole picture. Raises InputError that names the file if it cannot be read."""
    if _needs_own_process(path):
        return call_in_process(open_picture, path, str(path))
    movie = movie_of_frame(path)
    if movie is not None:
        values, white, info = read_movie_values(*movie)
        return RawPicture(values, info, white)
    if path.suffix.lower() in _ARRAY_READERS:
        return RawPicture(_ARRAY_READERS[path.suffix.lower()](path))
    with convert_library_errors(path), _open_with_pillow(path) as image:
        if image is None or _is_reduced_by_pillow(image):
            values, facts = read_by_openimageio(path)
            return RawPicture(values, facts if image is None else _collect_info(image))
        upright = ImageOps.exif_transpose(image)
        upright = upright.convert(_MODES[upright.mode]) if upright.mode in _MODES else upright
        values = np.array(upright)
        info = _photo_info(path, image, upright.size)
    return RawPicture(values if values.ndim == 3 else values[:, :, None], info)


def picture_info(path: Path) -> tuple[tuple[int, int], dict[str, object]]:
    """Read (width, height) and the metadata without decoding the pixels, where possible."""
    if _needs_own_process(path):
        return call_in_process(picture_info, path, str(path))
    movie = movie_of_frame(path)
    if movie is not None:
        return read_movie_info(*movie)
    if path.suffix.lower() in _ARRAY_READERS:
        height, width = _ARRAY_READERS[path.suffix.lower()](path).shape[:2]
        return (width, height), {} if path.suffix.lower() == ".npy" else {"is_light": True}
    with convert_library_errors(path), _open_with_pillow(path) as image:
        if image is None:  # floating point, or a format that Pillow lacks
            values, facts = read_by_openimageio(path)
            return values.shape[1::-1], facts | {"is_light": values.dtype.kind == "f"}
        info = _photo_info(path, image, image.size)
        return _upright_size(image), info | {"is_light": image.mode == "F"}


def _needs_own_process(path: Path) -> bool:
    """Return True for a HEIC that must still be moved to a separate process to be read.

    The library for HEIC is large and may crash.
    """
    if path.suffix.lower() not in _HEIC or importlib.util.find_spec("pillow_heif") is None:
        return False
    allow_for(path)
    return not is_bounded()


@contextlib.contextmanager
def _open_with_pillow(path: Path) -> Iterator[Image.Image | None]:
    """Open the file without decoding its pixels; yield None if Pillow does not know the format."""
    if path.suffix.lower() in _HEIC:
        _register_heic(path)
    if not os.path.isfile(path):  # opening a pipe would wait for its writer
        raise unreadable_error(path)
    with open_regular_file(path) as file:  # raises an OSError that says why it cannot be opened
        _check_avif(path, file.read(_HEAD_BYTES))
    image = open_with_pillow(path)
    if image is None:
        yield None
        return
    with image:
        check_size(path, image.size)
        yield image


@contextlib.contextmanager
def convert_library_errors(path: Path) -> Iterator[None]:
    """Turn every failure of the libraries into an InputError of one line.

    For a damaged file the libraries can raise any exception, so the `with` block must contain
    nothing but calls of them.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # damage either leads to an error or does not matter
            yield
    except InputError:
        raise
    except FileNotFoundError as error:
        raise unreadable_error(path, error) from error
    except Image.DecompressionBombError as error:
        raise InputError(f"{path} has too many pixels ({error}).") from error
    except Exception as error:
        reason = one_line(error) or type(error).__name__
        raise InputError(
            f"{path} cannot be read: it is damaged, or of a kind that heatlens does not know "
            f"({reason}). Convert it to PNG or EXR."
        ) from error


# Pillow has no color of 16 bits and silently keeps the upper 8 bits of each number. A depth or a
# graded picture would then show steps.
def _is_reduced_by_pillow(image: Image.Image) -> bool:
    """Return True if Pillow would reduce the picture from 16 bits to 8."""
    is_color = image.mode in ("RGB", "RGBA", "LA", "RGBX")
    return is_color and any(";16" in str(tile[-1]) for tile in getattr(image, "tile", ()))


def _read_numpy(path: Path) -> NDArray[np.generic]:
    """Read values (H, W, C) of a NumPy file that holds only numbers."""
    with convert_library_errors(path):
        values = np.load(BytesIO(read_file_bytes(path)), allow_pickle=False)
        values = values.squeeze() if values.ndim > 2 and 1 in values.shape else values
        if values.ndim not in (2, 3) or values.dtype.kind not in "fui" or not values.size:
            raise InputError(
                f"{path} holds an array of shape {values.shape} of {values.dtype}; a picture is "
                "(height, width) or (height, width, channels) of numbers."
            )
    check_size(path, (values.shape[1], values.shape[0]))
    pixels: NDArray[np.generic] = values if values.ndim == 3 else values[:, :, None]
    return pixels


def _read_checked_pfm(path: Path) -> NDArray[np.generic]:
    """Read values (H, W, C) of a PFM file, and check its size."""
    with convert_library_errors(path):
        values = read_pfm(path)
    check_size(path, (values.shape[1], values.shape[0]))
    return values


_ARRAY_READERS = {
    ".npy": _read_numpy,
    ".pfm": _read_checked_pfm,
}  # formats that need no library for pictures


def _check_avif(path: Path, head: bytes) -> None:
    """Refuse an AVIF of more than 8 bits, because Pillow would reduce it to 8.

    Source: AOMedia, AV1 Codec ISO Media File Format Binding, section 2.3.
    """
    if head[4:12] != b"ftypavif":
        return
    if not features.check("avif"):
        raise InputError(
            f"{path}: AVIF needs Pillow 11.3 or newer: {BASE.install_command('-U pillow')}."
        )
    position = head.find(b"av1C")
    if position >= 0 and head[position + 6 : position + 7] and head[position + 6] & 0b0100_0000:
        raise InputError(
            f"{path} has more than 8 bits a channel, which heatlens cannot read from AVIF: "
            "convert it to a 16-bit PNG or TIFF, or to EXR."
        )


def _register_heic(path: Path) -> None:
    """Register the HEIC reader with Pillow."""
    import_extra("pillow_heif", f"{path}: HEIC").register_heif_opener()


def _collect_info(image: Image.Image | None) -> dict[str, object]:
    """Return the metadata of a picture; a depth image becomes its values and its metadata."""
    if image is None:
        return {}
    info: dict[str, Any] = {str(name): value for name, value in image.info.items()}
    info["depth_images"] = [
        (np.asarray(depth_image.to_pillow()), depth_image.info.get("metadata") or {})
        for depth_image in info.get("depth_images", ())
    ]
    info["exif_tags"] = {**image.getexif(), **image.getexif().get_ifd(ExifTags.IFD.Exif)}
    info["segments"] = list(getattr(image, "applist", ()))
    return info


def _upright_size(image: Image.Image) -> tuple[int, int]:
    """Return (width, height) of the picture as it is shown; Pillow turns a TIFF itself."""
    is_on_side = image.format != "TIFF" and image.getexif().get(_ORIENTATION, 1) in (5, 6, 7, 8)
    return image.size[::-1] if is_on_side else image.size


def _photo_info(path: Path, image: Image.Image, upright_size: tuple[int, int]) -> dict[str, object]:
    """Return the metadata of a picture; its header describes the camera.

    The camera comes from the capture folder if there is one, else from the photo.
    """
    info = _collect_info(image)
    capture = capture_info(path, upright_size)
    header = portrait_header(path, image.size, info)
    return {**info, "header": header, **capture}
