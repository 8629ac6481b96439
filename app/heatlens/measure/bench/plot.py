"""A picture of what the methods cost and buy, by matplotlib, imported when first asked for."""

import importlib
from pathlib import Path
from typing import Any

from heatlens.errors import InputError
from heatlens.files.atomic_file import replacing
from heatlens.files.output_check import check_writable
from heatlens.measure.bench.method_errors import ErrorReport
from heatlens.measure.bench.methods import MethodReport
from heatlens.measure.bench.plot_panels import error_panel, time_panel, trade_panel

PLOT_SUFFIXES = (".png", ".svg")

_ALONE = {"left": 0.09, "right": 0.76, "bottom": 0.11, "top": 0.9}
# Room at the right of each panel above for the names of its lines.
_ABOVE = {"left": 0.07, "right": 0.84, "bottom": 0.55, "top": 0.92, "wspace": 0.75}
_BELOW = {"left": 0.07, "right": 0.98, "bottom": 0.065, "top": 0.44}


def figure_class() -> Any:
    """matplotlib's Figure; raises InputError with what to install."""
    try:
        return importlib.import_module("matplotlib.figure").Figure
    except ImportError as error:
        raise InputError(
            f"matplotlib cannot be loaded ({error}). Install it with: pip install 'heatlens[plot]'"
        ) from error


def check_plot(path: Path) -> None:
    """Refuse, in an InputError, what would only fail after minutes of measuring."""
    if path.suffix.lower() not in PLOT_SUFFIXES:
        raise InputError(f"{path}: a plot must end in {' or '.join(PLOT_SUFFIXES)}.")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}.")
    check_writable(path)
    figure_class()


def write_plot(path: Path, times: MethodReport, errors: ErrorReport | None, renderer: str) -> None:
    """Time over blur, a line for each method, all axes logarithmic; error beside and against it.

    Without errors the first panel is all. Raises InputError where nothing can be written.
    """
    figure = _alone(times) if errors is None else _three(times, errors)
    figure.suptitle(
        f"{renderer}; numbers after names are views", fontsize="small", color="0.4", y=0.99
    )
    with replacing(path) as beside:
        figure.savefig(beside, format=path.suffix.lower()[1:], dpi=150)


def _alone(times: MethodReport) -> Any:
    figure = figure_class()(figsize=(9, 5.5))
    figure.subplots_adjust(**_ALONE)
    time_panel(figure.subplots(), times)
    return figure


def _three(times: MethodReport, errors: ErrorReport) -> Any:
    figure = figure_class()(figsize=(13, 9))
    above = figure.add_gridspec(1, 2, **_ABOVE)
    time_panel(figure.add_subplot(above[0]), times)
    error_panel(figure.add_subplot(above[1]), errors)
    trade_panel(figure.add_subplot(figure.add_gridspec(1, 1, **_BELOW)[0]), errors)
    return figure
