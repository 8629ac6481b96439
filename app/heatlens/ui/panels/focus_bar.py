"""Draw the focus bar: the histogram of depths over dioptres, depth of field, and the focus.

Infinity is at the right and the nearest surface at the left, as on most lens barrels.
"""

import math
from collections.abc import Sequence

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from heatlens.base.printable import printable
from heatlens.model.coc import far_limit_m, hyperfocal_m, near_limit_m
from heatlens.model.depth_histogram import DepthHistogram
from heatlens.model.lens import Lens
from heatlens.session.lens.lens_commands import focused_at
from heatlens.ui import probe, theme
from heatlens.ui.panels.distance_ticks import scale_ticks

_HEIGHT_EM = 4.2
_TICK = 4.0  # screen units
_TRIANGLE_EM = 0.33  # half the width of the one at the hyperfocal distance
_NAME_GAP = 3.0  # between a mark's line and its name, in screen units


def focus_bar(
    lens: Lens, histogram: DepthHistogram, unit: str, marks: Sequence[tuple[str, float]] = ()
) -> Lens:
    """Draw the bar over the width of the panel; return the lens, focused by a drag.

    `marks` are names and distances in metres of focus marks, drawn as lines with their names.
    """
    em = imgui.get_font_size()
    size = ImVec2(imgui.get_content_region_avail().x, _HEIGHT_EM * em)
    corner = imgui.get_cursor_screen_pos()
    imgui.invisible_button("focus bar", size)
    if imgui.is_item_active():
        lens = focused_at(lens, _dioptres_at(imgui.get_mouse_pos().x, corner, size, histogram))
    _draw(lens, histogram, corner, size, unit)
    _draw_marks(histogram, marks, corner, size)
    if imgui.is_item_hovered() and not imgui.is_item_active():
        imgui.set_tooltip("Drag to focus. Green is sharp; the triangle is the hyperfocal distance.")
    return lens


def _dioptres_at(x: float, corner: ImVec2, size: ImVec2, histogram: DepthHistogram) -> float:
    part = (x - corner.x) / max(size.x, 1.0)
    return (1.0 - min(max(part, 0.0), 1.0)) * histogram.most_dioptres


def _draw(lens: Lens, histogram: DepthHistogram, corner: ImVec2, size: ImVec2, unit: str) -> None:
    draw = imgui.get_window_draw_list()
    bottom = corner.y + size.y
    text_y = bottom - imgui.get_font_size()

    def x_at(distance_m: float) -> float:
        return float(corner.x + (1.0 - histogram.part_at(distance_m)) * size.x)

    draw.add_rect_filled(corner, ImVec2(corner.x + size.x, text_y - 2), theme.colors.groove, 3.0)
    draw_histogram(draw, histogram, corner, ImVec2(size.x, text_y - 2 - corner.y))
    near_x, far_x = x_at(near_limit_m(lens)), x_at(far_limit_m(lens))
    draw.add_rect_filled(
        ImVec2(near_x, corner.y), ImVec2(far_x, text_y - 2), theme.colors.in_focus_band
    )
    for x in (near_x, far_x):
        draw.add_line(ImVec2(x, corner.y), ImVec2(x, text_y - 2), theme.colors.in_focus, 1.0)
    focus_x = x_at(lens.focus_distance_m)
    draw.add_line(ImVec2(focus_x, corner.y - 2), ImVec2(focus_x, text_y), theme.colors.accent, 2.5)
    hyper_x, half = x_at(hyperfocal_m(lens)), _TRIANGLE_EM * imgui.get_font_size()
    draw.add_triangle_filled(
        ImVec2(hyper_x - half, corner.y),
        ImVec2(hyper_x + half, corner.y),
        ImVec2(hyper_x, corner.y + 1.4 * half),
        theme.colors.hyperfocal,
    )
    below = ImVec2(size.x, text_y - corner.y)
    draw_scale(draw, histogram, corner, below, unit, lens.measuring_offset_m)


def _draw_marks(
    histogram: DepthHistogram, marks: Sequence[tuple[str, float]], corner: ImVec2, size: ImVec2
) -> None:
    """Draw a line for each mark, from near to far, and its name if it does not touch another."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    low_y, free_x = corner.y + size.y - em - 2, corner.x
    for name, distance_m in sorted(marks, key=lambda mark: mark[1]):
        x = corner.x + (1.0 - histogram.part_at(distance_m)) * size.x
        draw.add_line(ImVec2(x, corner.y), ImVec2(x, low_y), theme.colors.mark, 1.0)
        width = imgui.calc_text_size(printable(name)).x
        text_x = x + _NAME_GAP
        if text_x + width > corner.x + size.x:  # a name at the far end stands left of its line
            text_x = x - _NAME_GAP - width
        if text_x >= free_x:
            draw.add_text(ImVec2(text_x, corner.y), theme.colors.mark, printable(name))
            probe.note_at(f"{name} on the bar", (text_x, corner.y, text_x + width, corner.y + em))
            free_x = text_x + width + _NAME_GAP


def visible_heights(histogram: DepthHistogram) -> NDArray[np.float64]:
    """Return the (BINS,) heights of the columns, 0 to 1; all but the first are scaled to reach 1.

    The first column is infinity: in many pictures it has half of all pixels, and would make the
    other columns invisibly low.
    """
    most = float(histogram.heights[1:].max(initial=0.0))
    heights = histogram.heights if most == 0 else histogram.heights / most
    return np.asarray(np.minimum(heights, 1.0))


def draw_histogram(
    draw: imgui.ImDrawList, histogram: DepthHistogram, corner: ImVec2, size: ImVec2
) -> None:
    """Draw the columns into the rectangle of `size`, infinity at the right."""
    heights = visible_heights(histogram)[::-1]
    step = size.x / len(heights)
    bottom = corner.y + size.y
    for i, height in enumerate(heights):
        if height > 0:
            x = corner.x + i * step
            top = ImVec2(x, bottom - float(height) * (size.y - 4))
            draw.add_rect_filled(top, ImVec2(x + step + 0.5, bottom), theme.colors.histogram)


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

    def width_of(text: str) -> float:
        return float(imgui.calc_text_size(text).x)

    for tick in scale_ticks(histogram, offset_m, unit, ends_x, width_of):
        draw.add_text(ImVec2(tick.text_x, y), theme.colors.text_dim, tick.text)
        if math.isfinite(tick.distance_m):
            x = tick.text_x + width_of(tick.text) / 2
            draw.add_line(ImVec2(x, y - _TICK), ImVec2(x, y), theme.colors.text_dim)
