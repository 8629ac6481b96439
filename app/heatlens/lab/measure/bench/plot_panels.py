"""The three panels of the plot: time against blur, error against blur, and error against time."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.lab.measure.bench.method_errors import ErrorReport, ErrorRow
from heatlens.lab.measure.bench.methods import KNOWN_VIEWS, MethodReport
from heatlens.lab.measure.chart import (
    GREY,
    Entry,
    legend_beside,
    new_figure,
    plain_axes,
    plain_ticks,
    style_of,
    write_figure,
)
from heatlens.media.files.atomic_file import check_writable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TRADE_COC_PX = 50.0  # the blur of the third panel: large enough to distinguish the methods
_FLIP_LEAST = 1e-4  # drawn for identical pictures, because a logarithmic axis has no 0
Points = list[tuple[float, float]]  # points of one method, by increasing blur


def time_panel(axes: "Axes", report: MethodReport) -> None:
    """Draw milliseconds per frame against the circle of confusion in pixels.

    A level line means a constant cost. The dotted line grows with the area of the blur disc.
    """
    lines = _lines_of_methods([(row.coc_px, row.ms) for row in report.rows])
    cocs_px = [row.coc_px for row in report.rows]
    entries = _draw_lines(axes, lines, cocs_px, report.limit_s)
    axes.set(ylabel="time of a frame [ms]", xlabel="circle of confusion [px]")
    plain_axes(axes, f"Time, {report.width}x{report.height}, the same blur everywhere")
    legend_beside(axes, [*entries, *_draw_growth(axes, lines)])


def error_panel(axes: "Axes", report: ErrorReport) -> None:
    """Draw FLIP to the truth against the circle of confusion in pixels.

    Errors inside the gray area are smaller than the noise of the truth itself.
    """
    lines = _lines_of_methods([(row.coc_px, _flips(row)) for row in report.rows])
    cocs_px = [row.coc_px for row in report.rows]
    entries = _draw_lines(axes, lines, cocs_px, report.limit_s)
    noise = [_flip(row.truth_flip) for row in report.rows]
    low, high = axes.get_ylim()
    area = axes.fill_between(cocs_px, noise, low, color="0.9", linewidth=0)
    axes.set_ylim(low, high)
    axes.set(ylabel="FLIP, lower is better", xlabel="largest circle of confusion [px]")
    plain_axes(axes, f"Error, {report.width}x{report.height}, to {report.truth_views} views")
    legend_beside(axes, [*entries, Entry(area, "noise of the truth", 0.0)])


def trade_panel(axes: "Axes", report: ErrorReport) -> None:
    """Draw FLIP against milliseconds: a large point per method at one blur, faint lines for all.

    Low is accurate, left is fast. A method that was too slow for that blur has its point at the
    largest blur at which it was measured, which the legend gives.
    """
    row = trade_row(report)
    axes.set(xscale="log", yscale="log")
    entries = []
    for name, points in _trade_points(report).items():
        axes.plot(*zip(*points, strict=True), ".-", color=style_of(name)["color"], alpha=0.25)
        label, (ms, flip) = _trade_point(report, name, row.coc_px)
        (point,) = axes.plot([ms], [flip], linestyle="none", markersize=9, **style_of(name))
        entries.append(Entry(point, label, flip))
    axes.set(xlabel="time of a frame of this scene [ms]", ylabel="FLIP, lower is better")
    size = f"{report.width}x{report.height}"
    plain_axes(
        axes, f"Error against time, {size}, up to {row.coc_px:g} px; faint: from 2 to 200 px"
    )
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    legend_beside(axes, entries)


def trade_row(report: ErrorReport) -> ErrorRow:
    """Return the row of the third panel: the one whose blur is closest to _TRADE_COC_PX."""
    return min(report.rows, key=lambda row: abs(math.log(row.coc_px / _TRADE_COC_PX)))


def _trade_point(report: ErrorReport, name: str, coc_px: float) -> tuple[str, tuple[float, float]]:
    """Return a method's legend and its (ms, FLIP) at `coc_px`, or at the largest blur below."""
    measured_cells = [
        (row.coc_px, cell) for row in report.rows if (cell := row.cells[name]) is not None
    ]
    at_px, cell = [pair for pair in measured_cells if pair[0] <= coc_px][-1]
    label = name if at_px == coc_px else f"{name}, at {at_px:g} px"
    return label, (cell.ms, _flip(cell.flip))


def _trade_points(report: ErrorReport) -> dict[str, Points]:
    """Return (ms, FLIP) of each method that was measured at all, by increasing blur."""
    points_of: dict[str, Points] = {}
    for row in report.rows:
        for name, cell in row.cells.items():
            if cell is not None:
                points_of.setdefault(name, []).append((cell.ms, _flip(cell.flip)))
    return points_of


def _lines_of_methods(rows: list[tuple[float, dict[str, float | None]]]) -> dict[str, Points]:
    """Return (coc, value) of each method; a method without any value is left out."""
    names = list(rows[0][1])
    points_of = {
        method: [(coc, value) for coc, cells in rows if (value := cells[method]) is not None]
        for method in names
    }
    return {name: points for name, points in points_of.items() if points}


def _draw_lines(
    axes: "Axes", lines: dict[str, Points], cocs_px: Sequence[float], limit_s: float
) -> list[Entry]:
    """Draw a line for each method, and return its legend, which explains lines that end early."""
    axes.set(xscale="log", yscale="log")
    entries = []
    for name, points in lines.items():
        width = 2.6 if name == "diffusion" else 1.5
        dashes = "--" if name.endswith(f" {KNOWN_VIEWS[0]}") else "-"
        xy = zip(*points, strict=True)
        (line,) = axes.plot(*xy, dashes, linewidth=width, markersize=5, **style_of(name))
        is_whole = points[-1][0] == cocs_px[-1]
        label = name if is_whole else f"{name}, over {limit_s:g} s"
        entries.append(Entry(line, label, points[-1][1]))
    axes.set_xticks(cocs_px, [f"{coc:g}" for coc in cocs_px])
    axes.set_xticks([], minor=True)
    plain_ticks(axes.yaxis)
    return entries


def _draw_growth(axes: "Axes", lines: dict[str, Points]) -> list[Entry]:
    """Draw the growth of the disc's area over a decade of blur, above the steepest line."""
    candidates = [points for points in lines.values() if len(points) > 1]
    if not candidates:
        return []
    points = max(candidates, key=lambda line: line[-1][1] / line[0][1])
    end, ms = points[-1][0], 2 * points[-1][1]
    start = max(points[0][0], end / 10)
    (line,) = axes.plot([start, end], [ms * (start / end) ** 2, ms], ":", color=GREY)
    return [Entry(line, "as the disc's area", ms)]


def _flips(row: ErrorRow) -> dict[str, float | None]:
    return {name: None if cell is None else _flip(cell.flip) for name, cell in row.cells.items()}


def _flip(flip: float) -> float:
    """Return the FLIP to draw, which is above zero."""
    return max(flip, _FLIP_LEAST)


PLOT_SUFFIXES = (".png", ".svg")


def check_plot(path: Path) -> None:
    """Raise InputError for a plot that cannot be written, before minutes of measuring."""
    if path.suffix.lower() not in PLOT_SUFFIXES:
        raise InputError(f"{path}: a plot must end in {' or '.join(PLOT_SUFFIXES)}.")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}.")
    check_writable(path)
    new_figure(1.0, 1.0)


def write_plot(path: Path, times: MethodReport, errors: ErrorReport | None, renderer: str) -> None:
    """Plot time against blur, error against blur, and error against time, a line for each method.

    All axes are logarithmic. Without errors, the plot has only the first panel. `renderer` names
    the machine. Raises InputError if the file cannot be written.
    """
    figure = _time_figure(times) if errors is None else _three_panel_figure(times, errors)
    title = f"{renderer}; a number after a method's name is its number of views"
    figure.suptitle(title, fontsize="small", color=GREY)
    write_figure(path, figure)


def _time_figure(times: MethodReport) -> "Figure":
    figure = new_figure(9, 5.5)
    time_panel(figure.subplots(), times)
    return figure


def _three_panel_figure(times: MethodReport, errors: ErrorReport) -> "Figure":
    """Return the charts of time, of error, and of one against the other."""
    figure = new_figure(13, 9)
    panels = figure.subplot_mosaic([["time", "error"], ["trade", "trade"]])
    time_panel(panels["time"], times)
    error_panel(panels["error"], errors)
    trade_panel(panels["trade"], errors)
    return figure
