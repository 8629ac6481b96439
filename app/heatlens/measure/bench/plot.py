"""Draw the plot of `heatlens bench --methods`: the time and the error of each method."""

from pathlib import Path
from typing import Any

from heatlens.base.errors import InputError
from heatlens.files.output_check import check_writable
from heatlens.measure.bench.method_errors import ErrorReport
from heatlens.measure.bench.methods import MethodReport
from heatlens.measure.bench.plot_panels import error_panel, time_panel, trade_panel
from heatlens.measure.chart import GREY, new_figure, write_figure

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
    figure = _time_figure(times) if errors is None else _whole_figure(times, errors)
    words = f"{renderer}; a number after a method's name is its number of views"
    figure.suptitle(words, fontsize="small", color=GREY)
    write_figure(path, figure)


def _time_figure(times: MethodReport) -> Any:
    figure = new_figure(9, 5.5)
    time_panel(figure.subplots(), times)
    return figure


def _whole_figure(times: MethodReport, errors: ErrorReport) -> Any:
    figure = new_figure(13, 9)
    panels = figure.subplot_mosaic([["time", "error"], ["trade", "trade"]])
    time_panel(panels["time"], times)
    error_panel(panels["error"], errors)
    trade_panel(panels["trade"], errors)
    return figure
