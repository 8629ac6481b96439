"""Write a picture seen through the lens to a file, for the window and the command line alike.

Scene-linear colour becomes 8-bit display values in PNG, JPEG or TIFF.
"""

import io
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from heatlens.base.errors import InputError
from heatlens.files.atomic_file import check_folder, check_writable, make_folder, write_whole
from heatlens.files.marks import IMAGE_DESCRIPTION, blurred_mark, comment_of
from heatlens.model.boxes import Box
from heatlens.model.lens.breathing import as_seen
from heatlens.model.lens.lens import Lens
from heatlens.plate.exr.exr_write import write_exr
from heatlens.plate.header.camera_header import lens_attributes
from heatlens.plate.picture.display import srgb_encoded
from heatlens.plate.plate import FloatImage, Plate
from heatlens.plate.windows import moved_to_window

_FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".tif": "TIFF", ".tiff": "TIFF"}
EYE_SUFFIXES = tuple(_FORMATS)
Encode = Callable[[FloatImage], FloatImage]  # scene-linear (H, W, 3) to display values
Whole = TypeVar("Whole", np.uint8, np.uint16)
_OPTIONS: dict[str, dict[str, object]] = {
    "JPEG": {"quality": 95},
    "TIFF": {"compression": "tiff_adobe_deflate"},
}


def write_png(
    path: str | os.PathLike[str],
    rgba: FloatImage,
    encode: Encode = srgb_encoded,
) -> None:
    """Write scene-linear `rgba`, (H, W, 3) or premultiplied (H, W, 4).

    `encode` converts light (H, W, 3) to display values, which are clamped to 0..1. If any pixel is
    not opaque, PNG and TIFF hold alpha with unpremultiplied colour, and JPEG shows the picture over
    black. Raises InputError if the file cannot be written.
    """
    write_image(path, shown_image(rgba, encode, keeps_alpha(Path(path).suffix)))


def shown_image(rgba: FloatImage, encode: Encode, keep_alpha: bool = True) -> Image.Image:
    """Return what `write_png` writes; without `keep_alpha` over black."""
    light = _straight(rgba, keep_alpha)
    shown = np.concatenate([encode(light[:, :, :3]), light[:, :, 3:]], axis=2)
    return Image.fromarray(quantised(shown, np.uint8))


def write_image(
    path: str | os.PathLike[str], image: Image.Image, marks: Mapping[str, str] | None = None
) -> None:
    """Write `image` with texts in the format of the suffix. Raises InputError if that fails."""
    kind = picture_format(path)
    write_whole(path, encoded_picture(image, kind, **_marked(kind, marks or {})))


def _marked(kind: str, marks: Mapping[str, str]) -> dict[str, object]:
    """Return Pillow's options that store the texts where each format has room for them."""
    if not marks:
        return {}
    if kind == "PNG":
        info = PngInfo()
        for name, text in marks.items():
            info.add_text(name, text)
        return {"pnginfo": info}
    comment = comment_of(marks)
    return {"comment": comment} if kind == "JPEG" else {"tiffinfo": {IMAGE_DESCRIPTION: comment}}


def picture_format(path: str | os.PathLike[str]) -> str:
    """Return PNG, JPEG or TIFF for the suffix of a name. Raises InputError for another suffix."""
    kind = _FORMATS.get(Path(path).suffix.lower())
    if kind is None:
        raise InputError(f"{path}: pictures are written as {', '.join(_FORMATS)}.")
    return kind


def keeps_alpha(suffix: str) -> bool:
    """Return whether files with this suffix hold alpha."""
    return _FORMATS.get(suffix.lower()) != "JPEG"


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


PICTURE_SUFFIXES = (".exr", *EYE_SUFFIXES)


def write_picture(
    path: Path,
    pixels: FloatImage,
    plate: Plate,
    lens: Lens,
    proxy: float,
    *,
    half: bool = True,
    compression: str = "zip",
    encode: Encode = srgb_encoded,
    more_channels: Mapping[str, FloatImage] | None = None,
    more_attributes: Mapping[str, object] | None = None,
    kept_channels: Mapping[str, NDArray[np.generic]] | None = None,
    is_blurred: bool = True,
) -> None:
    """Write `pixels`, (H, W, 4) premultiplied at `proxy` scale, in the format of the suffix.

    An EXR is scene-linear, over the plate's windows, with the plate's metadata and `lens` in its
    header and 16 bits a channel if `half`. `more_channels` of the same size and `more_attributes`
    are added; `kept_channels` are written bit for bit. Other formats are converted by `encode`, and
    show the display window, as players do. All are marked as blurred or not. A missing folder is
    made, inside an existing one. Raises InputError if the file cannot be written.
    """
    make_folder(path.parent)
    mark = blurred_mark(is_blurred)
    if path.suffix.lower() in EYE_SUFFIXES:
        write_image(path, seen_image(pixels, plate, proxy, encode, keeps_alpha(path.suffix)), mark)
        return
    names = "RGBA" if plate.has_alpha else "RGB"
    write_exr(
        path,
        {**{name: pixels[..., i] for i, name in enumerate(names)}, **(more_channels or {})},
        scaled_window(plate.data_window, proxy, pixels.shape[1::-1]),
        scaled_window(plate.display_window, proxy),
        plate.pixel_aspect_ratio,
        {**plate.attributes, **lens_header(plate, lens), **mark, **(more_attributes or {})},
        half=half,
        compression=compression,
        kept=kept_channels,
    )


def seen_image(
    pixels: FloatImage, plate: Plate, proxy: float, encode: Encode, keep_alpha: bool = True
) -> Image.Image:
    """Return `pixels`, (H, W, 4) premultiplied at `proxy` scale, as an image of 8 bits.

    It shows the display window; `encode` and `keep_alpha` are those of `shown_image`.
    """
    shown = in_display_window(pixels, plate, proxy)
    return shown_image(shown if plate.has_alpha else shown[..., :3], encode, keep_alpha)


def check_output(path: Path, plate: Path, *beside: Path) -> None:
    """Raise InputError for an output that would fail only after rendering or destroy an input.

    `beside` are other input files, which need not exist.
    """
    if path.suffix.lower() not in PICTURE_SUFFIXES:
        raise InputError(f"{path}: the output must end in {', '.join(PICTURE_SUFFIXES)}.")
    check_folder(path)
    check_writable(path if path.parent.is_dir() else path.parent)
    if os.path.isdir(path):
        raise InputError(f"{path} is a folder: give the name of a file to write.")
    if _is_same(path, plate):
        raise InputError(f"{path} is the plate itself: give another name for the output.")
    if any(_is_same(path, other) for other in beside):
        raise InputError(f"{path} is part of {plate.name}: give another name for the output.")


def _is_same(path: Path, other: Path) -> bool:
    return os.path.exists(path) and os.path.exists(other) and os.path.samefile(path, other)


def lens_header(plate: Plate, lens: Lens) -> dict[str, Any]:
    """Return the lens as header attributes; none if the plate holds circles of confusion.

    The height of the sensor follows from the shape of the picture, as in camera files: it decides
    the vertical angle, while the height in a header may be that of a whole sensor, of which the
    picture is a part.
    """
    if plate.coc_px is not None:
        return {}
    lens, window = as_seen(lens), plate.display_window
    height_mm = lens.sensor_width_mm * window.height / (window.width * plate.pixel_aspect_ratio)
    return lens_attributes(
        lens.focal_length_mm,
        lens.f_stop,
        lens.focus_distance_m,
        lens.sensor_width_mm,
        height_mm,
        model=lens.model,
    )


def in_display_window(
    pixels: FloatImage, plate: Plate, proxy: float, outside: FloatImage | None = None
) -> FloatImage:
    """Return `pixels`, (H, W, n) over the data window at `proxy` scale, over the display window.

    Overscan is cut off. Pixels that the renderer did not write become `outside`, (n,) values, or 0.
    """
    window = scaled_window(plate.data_window, proxy, pixels.shape[1::-1])
    seen = scaled_window(plate.display_window, proxy)
    if window == seen:
        return pixels
    count = pixels.shape[2]
    fill = np.zeros(count, np.float32) if outside is None else outside
    moved = (moved_to_window(pixels[..., i], window, seen, float(fill[i])) for i in range(count))
    return np.stack(list(moved), axis=-1)


def scaled_window(box: Box, scale: float, size: tuple[int, ...] | None = None) -> Box:
    """Return the window `box` at proxy scale; `size` (width, height) overrides the rounded size."""
    x0, y0 = round(box.x0 * scale), round(box.y0 * scale)
    width, height = size or (max(1, round(box.width * scale)), max(1, round(box.height * scale)))
    return Box(x0, y0, x0 + width, y0 + height)
