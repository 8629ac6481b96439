"""The three panels of the methods' plot: time and error over blur, and error over time."""

import math
from typing import Any

from heatlens.measure.bench.entrants import KNOWN_VIEWS
from heatlens.measure.bench.method_errors import ErrorReport, ErrorRow
from heatlens.measure.bench.methods import MethodReport
from heatlens.measure.bench.plot_labels import Label, name_lines, name_points

# Okabe and Ito 2008: told apart by those who see fewer colours as well, dark enough for letters.
_COLORS = {
    "diffusion": "#D55E00",
    "heat": "#B8860B",
    "gather": "#0072B2",
    "scatter": "#3A9BD0",
    "pyramid": "#007A59",
    "accumulation": "#B0528A",
    "raytraced": "#555555",
}
_GREY = "#666666"
_AT_PX = 50.0  # the blur of the third panel: large enough to tell the methods apart
Values = dict[str, list[tuple[float, float]]]


def time_panel(axes: Any, report: MethodReport) -> None:
    """Milliseconds; level is constant cost, the dotted line grows as the disc's area does."""
    found = _values([(row.coc_px, row.ms) for row in report.rows])
    cocs = [row.coc_px for row in report.rows]
    _over_blur(axes, cocs, found)
    growth = _draw_growth(axes, found)
    axes.set(ylabel="time of a frame [ms]", xlabel="circle of confusion [px]")
    _title(axes, f"Time, {report.width}x{report.height}, the same blur everywhere")
    _name(axes, found, cocs[-1], report.limit_s, growth)


def error_panel(axes: Any, report: ErrorReport) -> None:
    """FLIP to the truth; in the grey, the truth is not sure of itself."""
    found = _values([(row.coc_px, _flips(row)) for row in report.rows])
    cocs = [row.coc_px for row in report.rows]
    _over_blur(axes, cocs, found)
    noise = [_flip(row.truth_flip) for row in report.rows]
    axes.plot(cocs, noise, color="0.8", linewidth=1)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high)
    axes.fill_between(cocs, noise, low, color="0.92", linewidth=0)
    axes.text(cocs[-1], 1.3 * low, "noise of the truth ", color=_GREY, fontsize=9, ha="right")
    axes.set(ylabel="FLIP, lower is better", xlabel="largest circle of confusion [px]")
    _title(axes, f"Error, {report.width}x{report.height}, to {report.truth_views} views")
    _name(axes, found, cocs[-1], report.limit_s)


def trade_panel(axes: Any, report: ErrorReport) -> None:
    """A point for each method at one blur, amid those of all: what is low is right, what is left
    is quick. One that was too slow for that blur has its point at the last that it was done at."""
    row = chosen_row(report)
    trades = _trades(report)
    labels = [_traded(report, name, row.coc_px) for name in trades]
    _logarithmic(axes)
    for name, points in trades.items():
        axes.plot(*zip(*points, strict=True), ".-", color=_color(name), alpha=0.25, linewidth=1)
    for label in labels:
        axes.plot([label.x], [label.y], "o", color=label.color, markersize=8)
    axes.set(xlabel="time of a frame of this scene [ms]", ylabel="FLIP, lower is better")
    size = f"{report.width}x{report.height}"
    _title(axes, f"Error against time, {size}, up to {row.coc_px:g} px; faint: from 2 to 200 px")
    _plain_ticks(axes)
    name_points(axes, labels)


def chosen_row(report: ErrorReport) -> ErrorRow:
    """The row that the third panel shows: the nearest to _AT_PX."""
    return min(report.rows, key=lambda row: abs(math.log(row.coc_px / _AT_PX)))


def _traded(report: ErrorReport, name: str, coc_px: float) -> Label:
    """One method's point, at `coc_px` or the last before it; then its name says where."""
    done = [(row.coc_px, cell) for row in report.rows if (cell := row.cells[name]) is not None]
    at, cell = [pair for pair in done if pair[0] <= coc_px][-1]
    words = name if at == coc_px else f"{name}, at {at:g} px"
    return Label(words, cell.ms, _flip(cell.flip), _color(name))


def _trades(report: ErrorReport) -> Values:
    """Of each method that was done once, milliseconds and FLIP from the least blur to the most."""
    found: Values = {}
    for row in report.rows:
        for name, cell in row.cells.items():
            if cell is not None:
                found.setdefault(name, []).append((cell.ms, _flip(cell.flip)))
    return found


def _values(rows: list[tuple[float, dict[str, float | None]]]) -> Values:
    """What there is of each method, over coc; a method of which there is nothing is left out."""
    names = list(rows[0][1])
    found = {n: [(coc, v) for coc, cells in rows if (v := cells[n]) is not None] for n in names}
    return {name: points for name, points in found.items() if points}


def _over_blur(axes: Any, cocs: list[float], found: Values) -> None:
    _logarithmic(axes)
    for name, points in found.items():
        wide = 2.6 if name == "diffusion" else 1.5
        style = "o--" if name.endswith(f" {KNOWN_VIEWS[0]}") else "o-"
        axes.plot(*zip(*points, strict=True), style, color=_color(name), linewidth=wide, ms=4)
    axes.set_xticks(cocs, [f"{coc:g}" for coc in cocs])
    axes.set_xticks([], minor=True)


def _logarithmic(axes: Any) -> None:
    axes.set(xscale="log", yscale="log")
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)


def _title(axes: Any, words: str) -> None:
    axes.set_title(words, loc="left", fontsize="medium")


def _plain_ticks(axes: Any) -> None:
    """1, 2, 5, 10 rather than powers, and only decades where there are many."""
    low, high = axes.get_ylim()
    steps = (1, 2, 5) if high / low < 1000 else (1,)
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)))
    ticks = [n * 10.0**power for power in (*powers, powers.stop) for n in steps]
    shown = [tick for tick in ticks if low <= tick <= high]
    axes.set_yticks(shown, [f"{tick:g}" for tick in shown])
    axes.set_yticks([], minor=True)
    axes.xaxis.set_major_formatter(lambda x, _: f"{x:g}")


def _name(
    axes: Any, found: Values, last: float, limit_s: float, more: tuple[Label, ...] = ()
) -> None:
    """Names at the lines' ends; those that end early say why."""
    _plain_ticks(axes)
    labels = []
    for name, points in found.items():
        words = name if points[-1][0] == last else f"{name}, over {limit_s:g} s"
        labels.append(Label(words, *points[-1], _color(name)))
    name_lines(axes, [*labels, *more])


def _draw_growth(axes: Any, found: Values) -> tuple[Label, ...]:
    """Four times as much for twice the blur, a decade of it, over the method that grows most."""
    lines = [points for points in found.values() if len(points) > 1]
    if not lines:
        return ()
    points = max(lines, key=lambda line: line[-1][1] / line[0][1])
    end, ms = points[-1][0], 2 * points[-1][1]
    start = max(points[0][0], end / 10)
    axes.plot([start, end], [ms * (start / end) ** 2, ms], ":", color=_GREY)
    return (Label("as the disc's area", end, ms, _GREY),)


def _flips(row: ErrorRow) -> dict[str, float | None]:
    return {name: None if cell is None else _flip(cell.flip) for name, cell in row.cells.items()}


def _flip(flip: float) -> float:
    """Equal pictures have no place on a logarithmic axis."""
    return max(flip, 1e-4)


def _color(name: str) -> str:
    return _COLORS.get(name.partition(" ")[0], "#000000")
