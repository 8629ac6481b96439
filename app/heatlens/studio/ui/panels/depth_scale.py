"""Draw the depths of a scene as columns over dioptres, and the scale of distances under them.

Infinity is at the right and the nearest surface at the left, as on most lens barrels. The labels
are round distances in the displayed unit.
"""

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from heatlens.core.model.units import FOOT_M, INCH_M, format_distance
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.studio.ui import theme
from heatlens.studio.ui.texts import text_width

# Round numbers, times a power of ten. Each group is used where the groups before it leave room.
_ROUND_STEPS = (1.0, 2.0, 5.0), (1.5, 3.0, 7.0), (4.0, 6.0, 8.0), (2.5, 9.0)
_FINE_STEPS = tuple(1.0 + 0.1 * i for i in range(90))  # ticks without labels
_MAX_FINE_TICKS = 200  # fine ticks on a scale, at most
_DECADES = 4  # powers of ten from the near end on; farther distances look like infinity
_MAX_INCHES = 9.5  # 10 inches would leave no room for 1 foot
INFINITY = "inf"
_MIN_LABEL_M = 0.01  # smallest label, if the entrance pupil lies behind the film plane


class Tick(NamedTuple):
    """A labeled distance in meters, its text, and the x where the text begins."""

    distance_m: float
    text: str
    text_x: float


def round_distances_m(near_m: float, unit: str, steps: tuple[float, ...]) -> Iterator[float]:
    """Yield round distances from `near_m` on, in meters or in feet and inches."""
    if unit == "m":
        yield from _multiples_m(near_m, math.inf, 1.0, steps)
        return
    yield from _multiples_m(near_m, _MAX_INCHES * INCH_M, INCH_M, steps)
    yield from _multiples_m(max(near_m, 0.999 * FOOT_M), math.inf, FOOT_M, steps)


def _multiples_m(
    least_m: float, most_m: float, unit_m: float, steps: tuple[float, ...]
) -> Iterator[float]:
    """Yield the steps times powers of ten, in units of `unit_m`, from `least_m` to `most_m`."""
    first_power = math.floor(math.log10(least_m / unit_m))
    for power in range(first_power, first_power + _DECADES + 1):
        for step in steps:
            distance_m = step * 10.0**power * unit_m
            if least_m <= distance_m < most_m:
                yield distance_m


def tick_text(distance_m: float, unit: str) -> str:
    """Format a distance as short as possible: whole feet without inches."""
    return format_distance(distance_m, unit).replace("'0\"", "'")


def distance_ticks(
    near_m: float,
    unit: str,
    x_at: Callable[[float], float],
    ends_x: tuple[float, float],
    width_of: Callable[[str], float],
) -> list[Tick]:
    """Return the ticks that fit without overlap, with infinity at the right.

    near_m      the distance at the left end, above 0
    x_at        maps a distance to its x on the screen, within `ends_x`
    width_of    measures a text; a gap as wide as "0" is kept between texts
    """
    gap, (left, right) = width_of("0"), ends_x
    ticks = [Tick(distance_m=math.inf, text=INFINITY, text_x=right - width_of(INFINITY))]
    for steps in _ROUND_STEPS:
        for distance_m in round_distances_m(near_m, unit, steps):
            text = tick_text(distance_m, unit)
            width = width_of(text)
            x = x_at(distance_m) - width / 2
            is_apart = (
                x >= tick.text_x + width_of(tick.text) + gap or x + width + gap <= tick.text_x
                for tick in ticks
            )
            if x >= left and all(is_apart):
                ticks.append(Tick(distance_m, text, x))
    return ticks


def scale_ticks(
    histogram: DepthHistogram,
    offset_m: float,
    unit: str,
    ends_x: tuple[float, float],
    width_of: Callable[[str], float],
) -> list[Tick]:
    """Return the ticks under a histogram between `ends_x`, with infinity at the right.

    Labels are distances from where the user measures them, which are longer by `offset_m` than
    those of the histogram.
    """
    left, right = ends_x
    near_m = _nearest_label_m(histogram, offset_m)

    def x_at(label_m: float) -> float:
        return right - histogram.scale_position(label_m - offset_m) * (right - left)

    return distance_ticks(near_m, unit, x_at, ends_x, width_of)


@lru_cache(maxsize=4)
def fine_ticks_m(histogram: DepthHistogram, offset_m: float, unit: str) -> tuple[float, ...]:
    """Return the distances of the fine ticks between the labels, as the histogram has them.

    They are a tenth of the leading digit apart, and end where they would overlap.
    """
    min_dioptres = histogram.most_dioptres / _MAX_FINE_TICKS
    distances_m: list[float] = []
    for label_m in round_distances_m(_nearest_label_m(histogram, offset_m), unit, _FINE_STEPS):
        distance_m = label_m - offset_m
        if not distances_m or 1.0 / distances_m[-1] - 1.0 / distance_m >= min_dioptres:
            distances_m.append(distance_m)
    return tuple(distances_m)


def _nearest_label_m(histogram: DepthHistogram, offset_m: float) -> float:
    """Return the label of the near end of a histogram, in m."""
    return max(1.0 / histogram.most_dioptres + offset_m, _MIN_LABEL_M)


TICK_EM = 0.4


def visible_heights(histogram: DepthHistogram) -> NDArray[np.float64]:
    """Return the (BINS,) heights of the columns, 0 to 1; the highest but the first becomes 1.

    The first column is infinity and is clipped at 1: in many pictures it has half of all pixels,
    and would make the other columns invisibly low.
    """
    highest = float(histogram.heights[1:].max(initial=0.0))
    heights = histogram.heights if highest == 0 else histogram.heights / highest
    return np.asarray(np.minimum(heights, 1.0))


def draw_histogram(
    draw: imgui.ImDrawList,
    histogram: DepthHistogram,
    corner: ImVec2,
    size: ImVec2,
    focus_range_x: tuple[float, float] | None = None,
) -> None:
    """Draw the columns into the rectangle of `size`, infinity at the right.

    Between the two x of `focus_range_x` the ground and the columns are green.
    """
    bottom, colors = corner.y + size.y, theme.colors
    _draw_columns(draw, histogram, corner, size, colors.histogram)
    if focus_range_x is None:
        return
    draw.add_rect_filled(
        ImVec2(focus_range_x[0], corner.y), ImVec2(focus_range_x[1], bottom), colors.in_focus_band
    )
    draw.push_clip_rect(ImVec2(focus_range_x[0], corner.y), ImVec2(focus_range_x[1], bottom), True)
    _draw_columns(draw, histogram, corner, size, colors.in_focus)
    draw.pop_clip_rect()


def _draw_columns(
    draw: imgui.ImDrawList, histogram: DepthHistogram, corner: ImVec2, size: ImVec2, color: int
) -> None:
    """Draw the columns of the histogram in one color."""
    heights = visible_heights(histogram)[::-1]
    step, bottom = size.x / len(heights), corner.y + size.y
    for index, height in enumerate(heights):
        if height > 0:
            x = corner.x + index * step
            top = ImVec2(x, bottom - float(height) * (size.y - 4))
            draw.add_rect_filled(top, ImVec2(x + step + 0.5, bottom), color)


@lru_cache(maxsize=4)
def _cached_ticks(
    histogram: DepthHistogram, offset_m: float, unit: str, ends_x: tuple[float, float], em: float
) -> list[Tick]:
    """Return the ticks in the current font, of the size `em`."""
    return scale_ticks(histogram, offset_m, unit, ends_x, text_width)


def draw_scale(
    draw: imgui.ImDrawList,
    histogram: DepthHistogram,
    corner: ImVec2,
    size: ImVec2,
    unit: str,
    offset_m: float = 0.0,
) -> None:
    """Draw labeled distances under a bar of this size, as many as fit.

    Labels are distances from where the user measures them, which are longer by `offset_m` than
    those of the histogram.
    """
    y, ends_x = corner.y + size.y, (corner.x, corner.x + size.x)
    tick_height = TICK_EM * imgui.get_font_size()
    for tick_label in _cached_ticks(histogram, offset_m, unit, ends_x, imgui.get_font_size()):
        draw.add_text(ImVec2(tick_label.text_x, y), theme.colors.text_dim, tick_label.text)
        if math.isfinite(tick_label.distance_m):
            x = tick_label.text_x + text_width(tick_label.text) / 2
            draw.add_line(ImVec2(x, y - tick_height), ImVec2(x, y), theme.colors.text_dim)
