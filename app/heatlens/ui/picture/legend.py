"""Draw the legend of an overlay: its colours and what they mean, in a corner of the picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from imgui_bundle import ImVec2, imgui

from heatlens.defocus.optics import Optics
from heatlens.gpu import shader_constants as colors
from heatlens.gpu.shader_constants import Rgb
from heatlens.model.units import format_distance
from heatlens.model.view.guides import Peaking, PeakingOn
from heatlens.model.view.view import Overlay
from heatlens.model.view.view_geometry import Viewport
from heatlens.plate.plate import DepthReport
from heatlens.ui import probe, theme


@dataclass(frozen=True)
class Entry:
    """A colour and its meaning."""

    color: Rgb
    words: str


@dataclass(frozen=True, eq=False)
class LegendFacts:
    """The numbers of a legend; diameters are in pixels of the whole picture.

    optics           the lens, with the nearest and farthest circle of confusion of the plate
    sharp_px         the largest diameter that counts as sharp
    layer_limits_px  the signed diameters between the layers, near to far
    depth            the depth range of the plate
    unit             unit of distances, "m" or "ft"
    """

    optics: Optics
    sharp_px: float
    layer_limits_px: Sequence[float]
    depth: DepthReport
    unit: str


def entries(overlay: Overlay, facts: LegendFacts, peaking: Peaking | None = None) -> list[Entry]:
    """Return the legend of an overlay, and of focus peaking if that is on."""
    legend = _overlay_entries(overlay, facts)
    if peaking is not None:
        what = "edges in focus" if peaking.on is PeakingOn.PICTURE else "peaking, in focus"
        limit_px = peaking.blur * facts.sharp_px
        legend.append(Entry(peaking.rgb, f"{what}, up to {limit_px:.1f} px"))
    return legend


def _overlay_entries(overlay: Overlay, facts: LegendFacts) -> list[Entry]:
    sharp_px, depth = facts.sharp_px, facts.depth
    near_px, far_px = facts.optics.nearest_px, facts.optics.farthest_px
    if overlay is Overlay.ZONES:
        return [
            Entry(colors.OVERLAY_NEAR, "in front"),
            Entry(colors.OVERLAY_FOCUS, f"in focus, up to {sharp_px:.1f} px"),
            Entry(colors.OVERLAY_FAR, "behind"),
        ]
    if overlay is Overlay.FOCUS_PLANE:
        return [Entry(colors.OVERLAY_FOCUS_LINE, "cut by the plane in focus")]
    if overlay is Overlay.COC:
        ends = [Entry(colors.OVERLAY_COC_SHARP, f"in focus, up to {sharp_px:.1f} px")]
        if near_px < -sharp_px:
            ends.insert(0, Entry(colors.OVERLAY_COC_NEAR, f"nearest {-near_px:.1f} px"))
        if far_px > sharp_px:
            ends.append(Entry(colors.OVERLAY_COC_FAR, f"farthest {far_px:.1f} px"))
        return ends
    if overlay is Overlay.DEPTH:
        near, far = "nearest", "farthest"
        if not depth.convention.facts.is_coc:
            near = format_distance(depth.near_m, facts.unit)
            far = format_distance(depth.far_m, facts.unit)
        if depth.infinite_count:
            far = "infinity"
        return [Entry((1.0, 1.0, 1.0), near), Entry((0.0, 0.0, 0.0), far)]
    if overlay is Overlay.LAYERS:
        return _layer_entries(facts.layer_limits_px)
    return []


def _layer_entries(limits_px: Sequence[float]) -> list[Entry]:
    """Return an entry for each layer, near to far: the range of its signed CoC in pixels."""
    if not limits_px:
        return [Entry(colors.OVERLAY_LAYERS[0], "one layer")]
    ends = [f"{limit:+.0f}" for limit in limits_px]
    words = [f"up to {ends[0]} px"]
    words += [f"{a} to {b} px" for a, b in pairwise(ends)]
    words.append(f"from {ends[-1]} px")
    return [Entry(tint, text) for tint, text in zip(colors.OVERLAY_LAYERS, words, strict=False)]


def draw_legend(legend: Sequence[Entry], viewport: Viewport, is_right: bool = False) -> None:
    """Draw the legend in the lower left corner of the viewport, or the lower right one."""
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
