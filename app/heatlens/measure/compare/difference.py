"""Write a picture of the difference: result, truth and error side by side."""

import os
from pathlib import Path

import numpy as np
from PIL import Image

from heatlens.base.errors import InputError
from heatlens.files.atomic_file import write_whole
from heatlens.measure.compare.metrics import flip_evaluation
from heatlens.plate.picture.display import srgb_encoded
from heatlens.plate.picture.png_write import encoded_picture
from heatlens.plate.plate import FloatImage


def absolute_difference(result: FloatImage, truth: FloatImage, gain: float) -> FloatImage:
    """Return `gain` times |result - truth| of the display values, clamped to 0..1; (H, W, 3)."""
    error = np.abs(srgb_encoded(result) - srgb_encoded(truth)) * np.float32(gain)
    clamped: FloatImage = np.minimum(error, np.float32(1.0))
    return clamped


def flip_map(result: FloatImage, truth: FloatImage) -> FloatImage:
    """Return the LDR-FLIP of each pixel in the colours of magma, as display values (H, W, 3).

    Black means no difference. Raises InputError if the package for FLIP is not installed.
    """
    shown, shown_truth = srgb_encoded(result), srgb_encoded(truth)
    colors = flip_evaluation(shown, shown_truth, "LDR", applyMagma=True)[0]
    return np.asarray(colors, np.float32)


def write_difference(
    path: str | os.PathLike[str], result: FloatImage, truth: FloatImage, error: FloatImage
) -> None:
    """Write `result` and `truth`, scene-linear, and `error`, display values, from left to right.

    All three are (H, W, 3). Raises InputError for a name that is no PNG or cannot be written.
    """
    check_is_png(path)
    strip = np.concatenate([srgb_encoded(result), srgb_encoded(truth), error], axis=1)
    image = Image.fromarray((strip * 255 + 0.5).astype(np.uint8))
    write_whole(path, encoded_picture(image, "PNG"))


def check_is_png(path: str | os.PathLike[str]) -> None:
    """Raise InputError unless the name ends in .png; call it before a long comparison."""
    if Path(path).suffix.lower() != ".png":
        raise InputError(f"{path}: the picture of the difference is written as .png.")
