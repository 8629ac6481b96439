"""Read two pictures, find the region that both hold, and write their difference as a picture."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.lab.measure.metrics import flip_evaluation
from heatlens.media.plate.header.channel_choice import choose_color
from heatlens.media.plate.header.channels import pixels_of
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.plate.picture.picture_write import write_display_values
from heatlens.media.plate.plate import FloatImage
from heatlens.media.plate.read import color_file_parts
from heatlens.media.plate.windows import read_header_window


@dataclass(frozen=True, eq=False)
class Picture:
    """The unrepaired color of a file: `rgb` (H, W, 3) float32, with NaN, over `data_window`."""

    path: Path
    rgb: FloatImage
    data_window: Box
    display_window: Box

    def crop(self, region: Box) -> FloatImage:
        """Return the pixels (H, W, 3) of a region inside the data window."""
        return self.rgb[region.relative_to(self.data_window).slices]


def read_picture(path: str | os.PathLike[str]) -> Picture:
    """Read the finished picture of a file, scene-linear; PNG, JPEG and TIFF are taken as sRGB.

    Raises InputError for a file that is missing, damaged or has no color.
    """
    path = Path(path)
    parts = color_file_parts(path, PlateOptions())
    headers = [header for header, _ in parts]
    choice = choose_color(path, headers, layer=None)
    header = headers[choice.rgb[0].part]
    channels = [pixels_of(parts, ref).astype(np.float32) for ref in choice.rgb]
    return Picture(
        path=path,
        rgb=np.stack(channels, axis=-1),
        data_window=read_header_window(header, "dataWindow"),
        display_window=read_header_window(header, "displayWindow"),
    )


def shared_region(result: Picture, truth: Picture) -> Box:
    """Return the region that both files hold: the data window if it is the same in both.

    If the data windows differ, it is the part of the display window that both hold. Raises
    InputError if the display windows differ, because it is then unknown which pixels correspond.
    """
    if result.display_window != truth.display_window:
        raise InputError(
            "Only pictures on one pixel grid can be compared: the display window of "
            f"{_window_text(result.path, result.display_window)}, that of "
            f"{_window_text(truth.path, truth.display_window)}."
        )
    if result.data_window == truth.data_window:
        return result.data_window
    region = result.data_window.intersection(truth.data_window).intersection(truth.display_window)
    if region.is_empty:
        raise InputError(
            "The pictures have no pixel in common: the data window of "
            f"{_window_text(result.path, result.data_window)}, that of "
            f"{_window_text(truth.path, truth.data_window)}."
        )
    return region


def _window_text(path: Path, box: Box) -> str:
    """Return the size and position of a file's window, for messages."""
    return f"{path} is {box.width} x {box.height} pixels at ({box.x0}, {box.y0})"


def absolute_difference(result: FloatImage, truth: FloatImage, gain: float) -> FloatImage:
    """Return `gain` times |result - truth| of the display values, clamped to 0..1; (H, W, 3)."""
    error = np.abs(encode_srgb(result) - encode_srgb(truth)) * np.float32(gain)
    clamped: FloatImage = np.minimum(error, np.float32(1.0))
    return clamped


def flip_map(result: FloatImage, truth: FloatImage) -> FloatImage:
    """Return the LDR-FLIP of each pixel in the colors of magma, as display values (H, W, 3).

    Black means no difference. Raises InputError if the package for FLIP is not installed.
    """
    display, display_truth = encode_srgb(result), encode_srgb(truth)
    colors = flip_evaluation(display, display_truth, "LDR", applyMagma=True)[0]
    return np.asarray(colors, np.float32)


def write_difference(
    path: str | os.PathLike[str], result: FloatImage, truth: FloatImage, error: FloatImage
) -> None:
    """Write `result` and `truth`, scene-linear, and `error`, display values, from left to right.

    All three are (H, W, 3). Raises InputError for a name that is not a PNG or cannot be written.
    """
    check_is_png(path)
    strip = np.concatenate([encode_srgb(result), encode_srgb(truth), error], axis=1)
    write_display_values(path, strip)


def check_is_png(path: str | os.PathLike[str]) -> None:
    """Raise InputError unless the name ends in .png; call it before a long comparison."""
    if Path(path).suffix.lower() != ".png":
        raise InputError(f"{path}: the difference can only be written as .png.")
