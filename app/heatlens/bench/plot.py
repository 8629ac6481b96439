"""A picture of the methods' times, with matplotlib, which is imported when first asked for."""

import importlib
from pathlib import Path
from typing import Any

from heatlens.bench.methods import MethodReport
from heatlens.errors import InputError
from heatlens.image.atomic_file import replacing

PLOT_SUFFIXES = (".png", ".svg")


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
    figure_class()


def write_plot(path: Path, report: MethodReport, renderer: str) -> None:
    """Milliseconds over circle of confusion, a line for each method, both axes logarithmic.

    A method of constant cost is level there; one that looks at the disc's area rises by two decades
    in one, as the dotted line does. Raises InputError where nothing can be written.
    """
    figure = figure_class()(figsize=(8, 5), layout="constrained")
    axes = figure.subplots()
    for name in report.rows[0].ms:
        done = [(row.coc_px, ms) for row in report.rows if (ms := row.ms[name]) is not None]
        label = name if len(done) == len(report.rows) else f"{name}, then over {report.limit_s:g} s"
        axes.plot([coc for coc, _ in done], [ms for _, ms in done], marker="o", label=label)
    _draw_growth(axes, report)
    axes.set(xscale="log", yscale="log", xlabel="circle of confusion [px]", ylabel="frame [ms]")
    axes.set_xticks([row.coc_px for row in report.rows], [f"{r.coc_px:g}" for r in report.rows])
    axes.set_xticks([], minor=True)
    axes.set_title(f"{report.width}x{report.height}, {renderer}", fontsize="medium")
    axes.grid(alpha=0.3)
    axes.legend()
    with replacing(path) as beside:
        figure.savefig(beside, format=path.suffix.lower()[1:], dpi=150)


def _draw_growth(axes: Any, report: MethodReport) -> None:
    """Four times as much for twice the blur, up to what took longest."""
    cells = [(ms, row.coc_px) for row in report.rows for ms in row.ms.values() if ms is not None]
    if cells:
        ms, coc_px = max(cells)
        axes.plot([coc_px / 10, coc_px], [ms / 100, ms], ":", color="grey", label="disc's area")
