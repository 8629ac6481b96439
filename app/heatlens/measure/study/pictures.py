"""The pictures of a report, as files: whole ones, differences, FLIP maps and crops."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from heatlens.measure.compare.difference import absolute_difference, flip_map
from heatlens.measure.study.report import Report
from heatlens.plate.picture.png_write import write_png
from heatlens.plate.plate import FloatImage

REFERENCE, SHARP = "reference", "sharp"


def crop_name(what: str, place: int) -> str:
    """Return the file name of a crop; `place` counts from 1."""
    return f"{what}-crop-{place}.png"


def write_pictures(folder: Path, report: Report) -> Iterator[str]:
    """Write each PNG into `folder` and yield its name.

    Raises InputError for a disk that is full, and where the package for FLIP is not installed.
    """
    for what, light in whole_pictures(report):
        yield _written(folder, f"{what}.png", light)
        for place, box in enumerate(report.crops, 1):
            part = light[box.y0 : box.y1, box.x0 : box.x1]
            yield _written(folder, crop_name(what, place), part)
    truth = report.reference.pixels
    for row in report.rows:
        error = absolute_difference(row.pixels, truth, report.gain)
        yield _written(folder, f"{row.method}-difference.png", error, as_it_is=True)
        error = flip_map(row.pixels, truth)
        yield _written(folder, f"{row.method}-flip.png", error, as_it_is=True)


def whole_pictures(report: Report) -> list[tuple[str, FloatImage]]:
    """Name and light (H, W, 3) of what is seen whole and in crops, in the order it is shown."""
    pictures = [] if report.sharp is None else [(SHARP, report.sharp)]
    pictures.append((REFERENCE, report.reference.pixels))
    return pictures + [(str(row.method), row.pixels) for row in report.rows]


def _written(folder: Path, name: str, picture: FloatImage, as_it_is: bool = False) -> str:
    """Light through the sRGB curve, display values as they are."""
    picture = np.ascontiguousarray(picture)
    if as_it_is:
        write_png(folder / name, picture, encode=lambda shown: shown)
    else:
        write_png(folder / name, picture)
    return name
