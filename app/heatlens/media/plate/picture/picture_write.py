"""Write a picture seen through the lens to a file, for the window and the command line alike.

Scene-linear color becomes display values in all formats but EXR, with the bits of each.
"""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.breathing import without_breathing
from heatlens.core.model.lens.lens import Lens
from heatlens.media.files.atomic_file import (
    check_folder,
    check_writable,
    make_folder,
    write_atomically,
)
from heatlens.media.files.marks import blurred_mark
from heatlens.media.files.picture_formats import suffixes_written, writing_of
from heatlens.media.plate.exr.exr_write import write_exr
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.plate.windows import move_to_window

Encode = Callable[[FloatImage], FloatImage]  # scene-linear (H, W, 3) to display values
Whole = TypeVar("Whole", np.uint8, np.uint16)


def write_png(path: str | os.PathLike[str], rgba: FloatImage, encode: Encode = encode_srgb) -> None:
    """Write scene-linear `rgba`, (H, W, 3) or premultiplied (H, W, 4).

    `encode` converts light (H, W, 3) to display values, which are clamped to 0..1. If any pixel is
    not opaque, formats with alpha hold it with unpremultiplied color, and others show the picture
    over black. Raises InputError if the file cannot be written.
    """
    write_display_values(path, _encode_for_display(rgba, encode, writing_of(path).keeps_alpha))


def _encode_for_display(rgba: FloatImage, encode: Encode, keep_alpha: bool) -> FloatImage:
    """Return display values of scene-linear `rgba`, (H, W, 3 or 4); no `keep_alpha`: over black."""
    light = _unpremultiply(rgba, keep_alpha)
    return np.concatenate([encode(light[:, :, :3]), light[:, :, 3:]], axis=2)


def write_display_values(
    path: str | os.PathLike[str], display_values: FloatImage, marks: Mapping[str, str] | None = None
) -> None:
    """Write display values 0..1, (H, W, 3 or 4), with texts in the format of the suffix.

    Raises InputError if that fails, and for a picture larger than the format allows.
    """
    writing = writing_of(path)
    if max(display_values.shape[:2]) > writing.most_px:
        raise InputError(
            f"{path}: {display_values.shape[1]} x {display_values.shape[0]} pixels are too many "
            "for this format, "
            f"which has at most {writing.most_px} a side."
        )
    is_8_bit, white = writing.bits <= 8, 2**writing.bits - 1
    values = (
        quantize(display_values, np.uint8, white)
        if is_8_bit
        else quantize(display_values, np.uint16, white)
    )
    write_atomically(path, writing.encoded(values, marks or {}))


def _unpremultiply(rgba: FloatImage, keep_alpha: bool) -> FloatImage:
    """Return light (H, W, 3), or unpremultiplied light with alpha (H, W, 4).

    Alpha is left out unless it is kept and some pixel is not opaque.
    """
    rgb = rgba[:, :, :3]
    if not keep_alpha or rgba.shape[2] == 3 or not (rgba[:, :, 3] < 1).any():
        return rgb
    alpha = np.nan_to_num(np.clip(rgba[:, :, 3:], 0.0, 1.0))
    straight = np.divide(rgb, alpha, out=rgb.copy(), where=alpha > 0)
    return np.concatenate([straight, alpha], axis=2)


def quantize(
    display: FloatImage, integer_type: type[Whole], white: int | None = None
) -> NDArray[Whole]:
    """Convert values of 0..1 to rounded integers of `integer_type`; clip values outside.

    `white` is the integer for 1, by default the largest.
    """
    largest = np.float32(white or np.iinfo(integer_type).max)
    scaled = np.clip(np.nan_to_num(display, nan=0.0), 0.0, 1.0) * largest
    return (scaled + np.float32(0.5)).astype(integer_type)


def write_picture(
    path: Path,
    pixels: FloatImage,
    plate: Plate,
    lens: Lens,
    proxy: float,
    *,
    half: bool = True,
    compression: str = "zip",
    encode: Encode = encode_srgb,
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
    if path.suffix.lower() != ".exr":
        write_display_values(
            path, convert_to_display_values(pixels, plate, proxy, encode, path), mark
        )
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
        unchanged=kept_channels,
    )


def convert_to_display_values(
    pixels: FloatImage, plate: Plate, proxy: float, encode: Encode, path: Path
) -> FloatImage:
    """Return `pixels`, (H, W, 4) premultiplied at `proxy` scale, as display values for `path`.

    The result covers the display window. Transparency is kept if the format of `path` has it.
    """
    display_pixels = move_to_display_window(pixels, plate, proxy)
    light = display_pixels if plate.has_alpha else display_pixels[..., :3]
    return _encode_for_display(light, encode, writing_of(path).keeps_alpha)


def check_output(path: Path, plate: Path, *other_inputs: Path) -> None:
    """Raise InputError for an output that would fail only after rendering or destroy an input.

    `other_inputs` are further input files, which need not exist.
    """
    suffix = path.suffix.lower()
    if suffix not in suffixes_written():
        raise InputError(f"{path}: the output must end in {', '.join(suffixes_written())}.")
    if suffix != ".exr":
        writing_of(path).require()
    check_folder(path)
    check_writable(path if path.parent.is_dir() else path.parent)
    if os.path.isdir(path):
        raise InputError(f"{path} is a folder: give the name of a file to write.")
    if _is_same_file(path, plate):
        raise InputError(f"{path} is the plate itself: give another name for the output.")
    if any(_is_same_file(path, input_path) for input_path in other_inputs):
        raise InputError(f"{path} is part of {plate.name}: give another name for the output.")


def _is_same_file(path: Path, other: Path) -> bool:
    return os.path.exists(path) and os.path.exists(other) and os.path.samefile(path, other)


def lens_header(plate: Plate, lens: Lens) -> dict[str, Any]:
    """Return the lens as header attributes; none if the plate holds circles of confusion.

    The height of the sensor follows from the shape of the picture, as in camera files, because it
    decides the vertical angle. The height in a header may be that of a whole sensor, of which the
    picture shows only a part.
    """
    if plate.coc_px is not None:
        return {}
    lens, window = without_breathing(lens), plate.display_window
    height_mm = lens.sensor_width_mm * window.height / (window.width * plate.pixel_aspect_ratio)
    return lens_attributes(
        lens.focal_length_mm,
        lens.f_stop,
        lens.focus_distance_m,
        lens.sensor_width_mm,
        height_mm,
        model=lens.model,
    )


def move_to_display_window(
    pixels: FloatImage, plate: Plate, proxy: float, outside: FloatImage | None = None
) -> FloatImage:
    """Return `pixels`, (H, W, n) over the data window at `proxy` scale, over the display window.

    Overscan is cut off. Pixels that the renderer did not write become `outside`, (n,) values, or 0.
    """
    window = scaled_window(plate.data_window, proxy, pixels.shape[1::-1])
    display_window = scaled_window(plate.display_window, proxy)
    if window == display_window:
        return pixels
    count = pixels.shape[2]
    fill = np.zeros(count, np.float32) if outside is None else outside
    moved = (
        move_to_window(pixels[..., i], window, display_window, float(fill[i])) for i in range(count)
    )
    return np.stack(list(moved), axis=-1)


def scaled_window(box: Box, scale: float, size: tuple[int, ...] | None = None) -> Box:
    """Return the window `box` at proxy scale; `size` (width, height) overrides the rounded size."""
    x0, y0 = round(box.x0 * scale), round(box.y0 * scale)
    width, height = size or (max(1, round(box.width * scale)), max(1, round(box.height * scale)))
    return Box(x0, y0, x0 + width, y0 + height)
