"""Draw the chart of a report: the error of each method against its time."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from heatlens.measure.chart import (
    Entry,
    legend_beside,
    new_figure,
    plain_axes,
    plain_ticks,
    style_of,
)
from heatlens.measure.study.measured import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SECONDS_LEAST = 1e-6  # a clock may return 0, which a logarithmic axis does not have
_FLIP_LEAST = 0.01  # the shortest axis, for methods that all equal the reference


def check_chart() -> None:
    """Raise InputError if matplotlib is not installed, with the extra of `study`."""
    new_figure(1.0, 1.0, extra="study")


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
        words = f"{row.method}, the closest" if row is best else str(row.method)
        entries.append(Entry(point, words, flip))
    axes.set_ylim(0.0, max(1.1 * max(row.scores.flip for row in rows), _FLIP_LEAST))
    _show_a_decade(axes)
    plain_axes(axes)
    plain_ticks(axes.xaxis)
    legend_beside(axes, entries)
    return figure


def _show_a_decade(axes: "Axes") -> None:
    """Widen the time axis to a factor of ten at least, around its middle."""
    low, high = axes.get_xlim()
    middle = (low * high) ** 0.5
    axes.set_xlim(min(low, middle / 10**0.5), max(high, middle * 10**0.5))
