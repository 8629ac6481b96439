"""Small deep EXR files, written by the library from lists of samples."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from support.exr_files import write_file

Sample = tuple[float, float, float]  # premultiplied grey, coverage, distance


def write_deep(
    path: Path,
    pixels: Sequence[Sequence[Sample]],
    size: tuple[int, int],
    thickness: float | None = None,
    **attributes: Any,
) -> Path:
    """Write (height, width) pixels, each a list of samples; `thickness` adds ZBack."""
    columns = {"R": 0, "G": 0, "B": 0, "A": 1, "Z": 2} | ({} if thickness is None else {"ZBack": 2})
    channels = {name: np.empty(size, object) for name in columns}
    for index, samples in zip(np.ndindex(*size), pixels, strict=True):
        for name, column in columns.items():
            values = np.array([sample[column] for sample in samples], np.float32)
            channels[name][index] = values + np.float32((thickness or 0.0) * (name == "ZBack"))
    header = {"type": OpenEXR.deepscanline, "compression": OpenEXR.ZIPS_COMPRESSION}
    return write_file(path, channels, **header, **attributes)
