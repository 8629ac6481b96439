"""Error over time as an inline SVG: what is low is right, what is left is quick."""

import math
from html import escape

from heatlens.measure.study.measured import Row

WIDTH, HEIGHT = 860, 350
_LEFT, _RIGHT, _TOP, _BOTTOM = 64, 28, 34, 48
_LINE_PX = 17  # names that come closer than this to each other are moved apart


def chart_svg(rows: tuple[Row, ...], best: Row) -> str:
    """A dot for each row, `best` in colour: time to the right, logarithmic; FLIP upwards from 0."""
    low, high = _decades([row.seconds for row in rows])
    top = _round_up(max(row.scores.flip for row in rows))
    marks = [_time_mark(power, low, high) for power in range(low, high + 1)]
    marks += [_flip_mark(top * i / 4, top) for i in range(5)]
    dots = [(_x(row.seconds, low, high), _y(row.scores.flip, top)) for row in rows]
    named = zip(rows, dots, _apart(dots), strict=True)
    marks += [_dot(str(row.method), dot, name_y, row is best) for row, dot, name_y in named]
    return (
        f'<svg class="chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="FLIP of each method over its time">{"".join(marks)}'
        f'<text x="{WIDTH - _RIGHT}" y="{HEIGHT - 4}" text-anchor="end">time of a frame</text>'
        f'<text x="0" y="12">FLIP</text></svg>'
    )


def _decades(seconds: list[float]) -> tuple[int, int]:
    """Powers of ten around all of them; a decade at least."""
    powers = [math.log10(max(s, 1e-6)) for s in seconds]
    low, high = math.floor(min(powers)), math.ceil(max(powers))
    return low, max(high, low + 1)


def _round_up(flip: float) -> float:
    """The end of the axis: 1, 2, 4 or 8 times a power of ten; each quarter is short to write."""
    if flip <= 0:
        return 0.04
    power = 10.0 ** math.floor(math.log10(flip))
    return next(step * power for step in (1, 2, 4, 8, 10) if flip <= step * power * (1 + 1e-9))


def _x(seconds: float, low: int, high: int) -> float:
    share = (math.log10(max(seconds, 1e-6)) - low) / (high - low)
    return _LEFT + share * (WIDTH - _LEFT - _RIGHT)


def _y(flip: float, top: float) -> float:
    return HEIGHT - _BOTTOM - flip / top * (HEIGHT - _TOP - _BOTTOM)


def _time_mark(power: int, low: int, high: int) -> str:
    x = _x(10.0**power, low, high)
    words = f"{10.0 ** (power + 3):g} ms" if power < 0 else f"{10.0**power:g} s"
    return (
        f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{_TOP}" y2="{HEIGHT - _BOTTOM}" stroke="#e3dfd8"/>'
        f'<text x="{x:.1f}" y="{HEIGHT - _BOTTOM + 22}" text-anchor="middle">{words}</text>'
    )


def _flip_mark(flip: float, top: float) -> str:
    y = _y(flip, top)
    return (
        f'<line x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{y:.1f}" y2="{y:.1f}" stroke="#e3dfd8"/>'
        f'<text x="{_LEFT - 10}" y="{y + 4:.1f}" text-anchor="end">{flip:g}</text>'
    )


def _apart(dots: list[tuple[float, float]]) -> list[float]:
    """A height for each name: its dot's, or above it where names would lie on each other."""
    heights = [y for _, y in dots]
    order = sorted(range(len(dots)), key=lambda i: -heights[i])
    for place, this in enumerate(order):
        for other in order[:place]:
            beside = abs(dots[this][0] - dots[other][0]) < 150  # as wide as a name and a half
            if beside and heights[other] - heights[this] < _LINE_PX:
                heights[this] = heights[other] - _LINE_PX
    return heights


def _dot(name: str, dot: tuple[float, float], name_y: float, is_best: bool) -> str:
    color = "#c2410c" if is_best else "#57524b"
    at_end = dot[0] > WIDTH - 150
    x, anchor = (dot[0] - 12, "end") if at_end else (dot[0] + 12, "start")
    return (
        f'<circle cx="{dot[0]:.1f}" cy="{dot[1]:.1f}" r="6" fill="{color}"/>'
        f'<text class="name" x="{x:.1f}" y="{name_y + 4:.1f}" text-anchor="{anchor}">'
        f"{escape(name)}</text>"
    )
