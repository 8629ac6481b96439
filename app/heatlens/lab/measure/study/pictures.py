"""The pictures of a report, as files: whole ones, differences, FLIP maps and crops; and its chart.

The crops are of the places at which the methods differ most. The chart shows the error of each
method against its time.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from heatlens.core.model.boxes import Box
from heatlens.lab.measure.chart import (
    Entry,
    legend_beside,
    new_figure,
    plain_axes,
    plain_ticks,
    style_of,
)
from heatlens.lab.measure.compared_pictures import absolute_difference, flip_map
from heatlens.lab.measure.metrics import flip_evaluation
from heatlens.lab.measure.study.measured import Report, Row
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.plate.picture.picture_write import write_png
from heatlens.media.plate.plate import FloatImage

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


REFERENCE, SHARP = "reference", "sharp"
CROPS = 3
_SHARE = 0.22  # share of the shorter side of the picture
_SIDE_MIN_PX, _SIDE_MAX_PX = 16, 160


def crop_name(name: str, number: int) -> str:
    """Return the file name of a crop; `place` counts from 1."""
    return f"{name}-crop-{number}.png"


def write_pictures(folder: Path, report: Report) -> Iterator[str]:
    """Write each PNG into `folder` and yield its name.

    Raises InputError for a disk that is full, and where the package for FLIP is not installed.
    """
    for name, light in whole_pictures(report):
        yield _write(folder, f"{name}.png", light)
        for number, box in enumerate(report.crops, 1):
            crop = light[box.y0 : box.y1, box.x0 : box.x1]
            yield _write(folder, crop_name(name, number), crop)
    truth = report.reference.pixels
    for row in report.rows:
        error = absolute_difference(row.pixels, truth, report.gain)
        yield _write(folder, f"{row.method}-difference.png", error, is_display=True)
        error = flip_map(row.pixels, truth)
        yield _write(folder, f"{row.method}-flip.png", error, is_display=True)


def whole_pictures(report: Report) -> list[tuple[str, FloatImage]]:
    """Return name and light (H, W, 3) of each picture, in the order shown."""
    pictures = [] if report.sharp is None else [(SHARP, report.sharp)]
    pictures.append((REFERENCE, report.reference.pixels))
    return pictures + [(str(row.method), row.pixels) for row in report.rows]


def _write(folder: Path, name: str, picture: FloatImage, is_display: bool = False) -> str:
    """Write light through the sRGB curve, or display values as they are; return the name."""
    picture = np.ascontiguousarray(picture)
    if is_display:
        write_png(folder / name, picture, encode=lambda shown: shown)
    else:
        write_png(folder / name, picture)
    return name


def crop_boxes(pictures: list[FloatImage], reference: FloatImage) -> list[Box]:
    """Return up to CROPS squares that do not touch, the most informative first.

    `pictures` and `reference` are scene-linear (H, W, 3). The most informative place is where the
    errors of the best and the worst picture differ most; with one picture, where its error is
    largest.
    """
    side = crop_side(*reference.shape[:2])
    sums = _box_sums(_error_range(pictures, reference), side)
    boxes: list[Box] = []
    while len(boxes) < CROPS and np.isfinite(sums).any():
        y, x = (int(i) for i in np.unravel_index(int(np.argmax(sums)), sums.shape))
        boxes.append(Box(x, y, x + side, y + side))
        distance_px = side + side // 2  # crops closer together would show the same thing twice
        sums[
            max(0, y - distance_px) : y + distance_px, max(0, x - distance_px) : x + distance_px
        ] = -np.inf
    return boxes


def crop_side(height: int, width: int) -> int:
    """Return the side of a crop in pixels, never more than the picture has."""
    side = min(_SIDE_MAX_PX, max(_SIDE_MIN_PX, round(_SHARE * min(height, width))))
    return min(side, height, width)


def flip_inside(picture: FloatImage, reference: FloatImage, box: Box) -> float:
    """Return the mean FLIP of a crop, 0 equal to 1 worst; both pictures are (H, W, 3)."""
    rows, columns = slice(box.y0, box.y1), slice(box.x0, box.x1)
    display, display_truth = (encode_srgb(p[rows, columns]) for p in (picture, reference))
    return float(flip_evaluation(display, display_truth, "LDR")[1])


def _error_range(pictures: list[FloatImage], reference: FloatImage) -> npt.NDArray[np.float64]:
    """Return (H, W), the worst minus the best error of each pixel's display value."""
    display = encode_srgb(reference)
    errors = np.stack([np.abs(encode_srgb(p) - display).mean(axis=2) for p in pictures])
    least = errors.min(axis=0) if len(pictures) > 1 else 0.0
    return np.asarray(errors.max(axis=0) - least, np.float64)


def _box_sums(values: npt.NDArray[np.float64], side: int) -> npt.NDArray[np.float64]:
    """Sum over the square that begins at each pixel; summed-area table, Crow 1984."""
    table = np.pad(values, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    return np.asarray(
        table[side:, side:] - table[:-side, side:] - table[side:, :-side] + table[:-side, :-side]
    )


_SECONDS_LEAST = 1e-6  # a clock may return 0, which a logarithmic axis does not have
_FLIP_LEAST = 0.01  # the shortest axis, for methods that all equal the reference


def error_chart(rows: Sequence[Row], best: Row) -> "Figure":
    """Return a figure with a point for each method: milliseconds, logarithmic, and FLIP from 0.

    The legend names the methods, the one with the largest error at the top, and marks `best`.
    """
    figure = new_figure(8.6, 3.8)
    axes = figure.subplots()
    axes.set(xscale="log", xlabel="time of a frame [ms]", ylabel="FLIP, lower is better")
    entries = []
    for row in rows:
        ms, flip = 1e3 * max(row.seconds, _SECONDS_LEAST), row.scores.flip
        style = style_of(str(row.method))
        (point,) = axes.plot([ms], [flip], linestyle="none", markersize=10, clip_on=False, **style)
        label = f"{row.method}, the closest" if row is best else str(row.method)
        entries.append(Entry(point, label, flip))
    axes.set_ylim(0.0, max(1.1 * max(row.scores.flip for row in rows), _FLIP_LEAST))
    _widen_to_decade(axes)
    plain_axes(axes)
    plain_ticks(axes.xaxis)
    legend_beside(axes, entries)
    return figure


def _widen_to_decade(axes: "Axes") -> None:
    """Widen the time axis to a factor of ten at least, around its middle."""
    low, high = axes.get_xlim()
    middle = (low * high) ** 0.5
    axes.set_xlim(min(low, middle / 10**0.5), max(high, middle * 10**0.5))
