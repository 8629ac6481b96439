"""Draw the depths of a scene as columns over dioptres, and the scale of distances under them.

Infinity is at the right and the nearest surface at the left, as on most lens barrels.
"""

import math

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from heatlens.model.depth_histogram import DepthHistogram
from heatlens.ui import theme
from heatlens.ui.panels.distance_ticks import scale_ticks

TICK_EM = 0.4


def visible_heights(histogram: DepthHistogram) -> NDArray[np.float64]:
    """Return the (BINS,) heights of the columns, 0 to 1; all but the first are scaled to reach 1.

    The first column is infinity: in many pictures it has half of all pixels, and would make the
    other columns invisibly low.
    """
    most = float(histogram.heights[1:].max(initial=0.0))
    heights = histogram.heights if most == 0 else histogram.heights / most
    return np.asarray(np.minimum(heights, 1.0))


def draw_histogram(
    draw: imgui.ImDrawList,
    histogram: DepthHistogram,
    corner: ImVec2,
    size: ImVec2,
    lit: tuple[float, float] | None = None,
) -> None:
    """Draw the columns into the rectangle of `size`, infinity at the right.

    Between the two x of `lit` the ground and the columns are green.
    """
    bottom, colors = corner.y + size.y, theme.colors
    _draw_columns(draw, histogram, corner, size, colors.histogram)
    if lit is None:
        return
    draw.add_rect_filled(ImVec2(lit[0], corner.y), ImVec2(lit[1], bottom), colors.in_focus_band)
    draw.push_clip_rect(ImVec2(lit[0], corner.y), ImVec2(lit[1], bottom), True)
    _draw_columns(draw, histogram, corner, size, colors.in_focus)
    draw.pop_clip_rect()


def _draw_columns(
    draw: imgui.ImDrawList, histogram: DepthHistogram, corner: ImVec2, size: ImVec2, color: int
) -> None:
    heights = visible_heights(histogram)[::-1]
    step, bottom = size.x / len(heights), corner.y + size.y
    for i, height in enumerate(heights):
        if height > 0:
            x = corner.x + i * step
            top = ImVec2(x, bottom - float(height) * (size.y - 4))
            draw.add_rect_filled(top, ImVec2(x + step + 0.5, bottom), color)


def draw_scale(
    draw: imgui.ImDrawList,
    histogram: DepthHistogram,
    corner: ImVec2,
    size: ImVec2,
    unit: str,
    offset_m: float = 0.0,
) -> None:
    """Draw labelled distances under a bar of this size, as many as fit.

    Labels are distances from where the user measures them, which are longer by `offset_m` than
    those of the histogram.
    """
    y, ends_x = corner.y + size.y, (corner.x, corner.x + size.x)
    tick = TICK_EM * imgui.get_font_size()

    def width_of(text: str) -> float:
        return float(imgui.calc_text_size(text).x)

    for it in scale_ticks(histogram, offset_m, unit, ends_x, width_of):
        draw.add_text(ImVec2(it.text_x, y), theme.colors.text_dim, it.text)
        if math.isfinite(it.distance_m):
            x = it.text_x + width_of(it.text) / 2
            draw.add_line(ImVec2(x, y - tick), ImVec2(x, y), theme.colors.text_dim)
