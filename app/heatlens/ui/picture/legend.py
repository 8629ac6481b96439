"""What the colours of an overlay mean, with numbers, in the corner of the picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from imgui_bundle import ImVec2, imgui

from heatlens.defocus.optics import Optics
from heatlens.gpu.shader_constants import (
    OVERLAY_COC_FAR,
    OVERLAY_COC_NEAR,
    OVERLAY_COC_SHARP,
    OVERLAY_FAR,
    OVERLAY_FOCUS,
    OVERLAY_FOCUS_LINE,
    OVERLAY_LAYERS,
    OVERLAY_NEAR,
    Rgb,
)
from heatlens.model.peaking import Peaking, PeakingOn
from heatlens.model.units import format_distance
from heatlens.model.view import Overlay
from heatlens.model.view_geometry import Viewport
from heatlens.plate.plate import DepthReport
from heatlens.ui import probe, theme


@dataclass(frozen=True)
class Entry:
    """A colour and its meaning."""

    color: Rgb
    words: str


def entries(
    overlay: Overlay,
    optics: Optics,
    sharp_px: float,
    layer_limits_px: Sequence[float],
    depth: DepthReport,
    unit: str,
    peaking: Peaking | None = None,
) -> list[Entry]:
    """Return the legend of overlay and peaking; diameters are pixels of the whole picture."""
    legend = _of_overlay(overlay, optics, sharp_px, layer_limits_px, depth, unit)
    if peaking is not None:
        what = "edges in focus" if peaking.on is PeakingOn.PICTURE else "peaking, in focus"
        legend.append(Entry(peaking.rgb, f"{what}, up to {peaking.blur * sharp_px:.1f} px"))
    return legend


def _of_overlay(
    overlay: Overlay,
    optics: Optics,
    sharp_px: float,
    layer_limits_px: Sequence[float],
    depth: DepthReport,
    unit: str,
) -> list[Entry]:
    near_px, far_px = optics.nearest_px, optics.farthest_px
    if overlay is Overlay.ZONES:
        return [
            Entry(OVERLAY_NEAR, "in front"),
            Entry(OVERLAY_FOCUS, f"in focus, up to {sharp_px:.1f} px"),
            Entry(OVERLAY_FAR, "behind"),
        ]
    if overlay is Overlay.FOCUS_PLANE:
        return [Entry(OVERLAY_FOCUS_LINE, "cut by the plane in focus")]
    if overlay is Overlay.COC:
        ends = [Entry(OVERLAY_COC_SHARP, f"in focus, up to {sharp_px:.1f} px")]
        if near_px < -sharp_px:
            ends.insert(0, Entry(OVERLAY_COC_NEAR, f"nearest {-near_px:.1f} px"))
        return ends + (
            [Entry(OVERLAY_COC_FAR, f"farthest {far_px:.1f} px")] if far_px > sharp_px else []
        )
    if overlay is Overlay.DEPTH:
        near = "nearest" if depth.convention.facts.is_coc else format_distance(depth.near_m, unit)
        far = "farthest" if depth.convention.facts.is_coc else format_distance(depth.far_m, unit)
        if depth.infinite_count:
            far = "infinity"
        return [Entry((1.0, 1.0, 1.0), near), Entry((0.0, 0.0, 0.0), far)]
    if overlay is Overlay.LAYERS:
        return _layers(layer_limits_px)
    return []


def _layers(limits_px: Sequence[float]) -> list[Entry]:
    """Return from near to far between which signed diameters each layer lies."""
    if not limits_px:
        return [Entry(OVERLAY_LAYERS[0], "one layer")]
    ends = [f"{limit:+.0f}" for limit in limits_px]
    words = [f"up to {ends[0]} px"]
    words += [f"{a} to {b} px" for a, b in pairwise(ends)]
    words.append(f"from {ends[-1]} px")
    return [Entry(tint, text) for tint, text in zip(OVERLAY_LAYERS, words, strict=False)]


def draw_legend(legend: Sequence[Entry], viewport: Viewport, is_right: bool = False) -> None:
    """Draw it over the lower left corner of the viewport, or the right one, in the window."""
    em = imgui.get_font_size()
    row = 1.35 * em
    (x, y), height = viewport.corner, viewport.size[1]
    width = max(imgui.calc_text_size(entry.words).x for entry in legend) + 2.4 * em
    top = y + height - len(legend) * row - 0.9 * em
    draw = imgui.get_window_draw_list()
    left = x + viewport.size[0] - width - 0.6 * em if is_right else x + 0.6 * em
    low = ImVec2(left, top)
    high = ImVec2(low.x + width, top + len(legend) * row + 0.3 * em)
    draw.add_rect_filled(low, high, theme.OVER_PICTURE.shadow, 3.0)
    probe.note_at("legend", (low.x, low.y, high.x, high.y))
    for i, entry in enumerate(legend):
        at = ImVec2(low.x + 0.5 * em, top + i * row + 0.3 * em)
        swatch = ImVec2(at.x + 0.85 * em, at.y + 0.85 * em)
        color = theme.packed(entry.color)
        draw.add_rect_filled(at, swatch, color)
        draw.add_rect(at, swatch, theme.OVER_PICTURE.window_line)
        draw.add_text(
            ImVec2(at.x + 1.3 * em, at.y - 0.1 * em), theme.OVER_PICTURE.handle, entry.words
        )
