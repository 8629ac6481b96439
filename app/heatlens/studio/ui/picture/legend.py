"""Draw the legend of an overlay: its colors and what they mean, in a corner of the picture."""

import math
from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.view.overlays import Entry, LegendFacts
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.media.plate.plate import DepthReport
from heatlens.render.defocus.optics import Optics
from heatlens.studio.ui import rects, theme


def legend_facts(
    optics: Optics, sharp_px: float, limits_px: tuple[float, ...], depth: DepthReport, unit: str
) -> LegendFacts:
    """Return the numbers of a legend for the optics of a lens and the depth of a plate."""
    has_distances = not depth.convention.facts.is_coc
    far_m = math.inf if depth.infinite_count else depth.far_m if has_distances else None
    return LegendFacts(
        nearest_px=optics.nearest_px,
        farthest_px=optics.farthest_px,
        sharp_px=sharp_px,
        layer_limits_px=limits_px,
        near_m=depth.near_m if has_distances else None,
        far_m=far_m,
        unit=unit,
    )


def draw_legend(legend: Sequence[Entry], viewport: Viewport, is_right: bool = False) -> None:
    """Draw the legend in the lower left corner of the viewport, or the lower right one."""
    em = imgui.get_font_size()
    row_height = 1.35 * em
    (x, y), height = viewport.corner, viewport.size[1]
    width = max(imgui.calc_text_size(entry.words).x for entry in legend) + 2.4 * em
    top = y + height - len(legend) * row_height - 0.9 * em
    draw = imgui.get_window_draw_list()
    left = x + viewport.size[0] - width - 0.6 * em if is_right else x + 0.6 * em
    corner = ImVec2(left, top)
    end = ImVec2(corner.x + width, top + len(legend) * row_height + 0.3 * em)
    draw.add_rect_filled(corner, end, theme.OVER_PICTURE.shadow, 3.0)
    rects.note_at("legend", (corner.x, corner.y, end.x, end.y))
    for index, entry in enumerate(legend):
        swatch_corner = ImVec2(corner.x + 0.5 * em, top + index * row_height + 0.3 * em)
        swatch_end = ImVec2(swatch_corner.x + 0.85 * em, swatch_corner.y + 0.85 * em)
        color = theme.pack_color(entry.color)
        draw.add_rect_filled(swatch_corner, swatch_end, color)
        draw.add_rect(swatch_corner, swatch_end, theme.OVER_PICTURE.window_line)
        draw.add_text(
            ImVec2(swatch_corner.x + 1.3 * em, swatch_corner.y - 0.1 * em),
            theme.OVER_PICTURE.handle,
            entry.words,
        )
