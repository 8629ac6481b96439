"""Draw grips at both ends of the chosen keys, which stretch a pull in time."""

from imgui_bundle import ImVec2, imgui

from heatlens.session.keys.key_stretch import KeyStretch
from heatlens.ui import theme, widgets
from heatlens.ui.timeline.scale import TimeScale

_WIDTH_EM, _HEIGHT_EM, _GAP_EM = 0.5, 1.3, 0.55
GRIPS_EM = _HEIGHT_EM + 0.2  # height of the strip that the grips need


def stretch_grips(stretch: KeyStretch, scale: TimeScale, y: float, height: float) -> None:
    """Draw the grips at the bottom of the area of keys; call this before that area's button."""
    ends = stretch.ends
    if ends is None:
        return
    em = imgui.get_font_size()
    top = y + max(height - GRIPS_EM * em, 0.0)
    for name, frame, is_last in (("first", ends.first, False), ("last", ends.last, True)):
        left = scale.x_at(frame) + (_GAP_EM if is_last else -_GAP_EM - _WIDTH_EM) * em
        left = min(max(left, scale.x), scale.x + scale.width - _WIDTH_EM * em)
        _grip(stretch, scale, f"stretch {name}", ImVec2(left, top), is_last)
    words = f"{ends.last - ends.first:g} frames"
    x0, x1 = scale.x_at(ends.first), scale.x_at(ends.last)
    width = imgui.calc_text_size(words).x
    if x1 - x0 > width + em and scale.x < x0 and x1 < scale.x + scale.width:
        at, draw = ImVec2((x0 + x1 - width) / 2, top + 0.15 * em), imgui.get_window_draw_list()
        low = ImVec2(at.x - 0.3 * em, at.y)  # own background, to be legible over a curve
        draw.add_rect_filled(low, ImVec2(at.x + width + 0.3 * em, at.y + em), theme.colors.groove)
        draw.add_text(at, theme.colors.text_dim, words)


def _grip(stretch: KeyStretch, scale: TimeScale, name: str, corner: ImVec2, is_last: bool) -> None:
    em = imgui.get_font_size()
    size = ImVec2(_WIDTH_EM * em, _HEIGHT_EM * em)
    widgets.area(name, corner, size, "Drag to stretch or shorten the chosen keys")
    is_lit = imgui.is_item_hovered() or imgui.is_item_active()
    if is_lit:
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
    if imgui.is_item_activated():
        stretch.press(is_last)
    elif imgui.is_item_active():
        gap = (_GAP_EM + _WIDTH_EM / 2) * em
        stretch.drag(scale.frame_at(imgui.get_mouse_pos().x - (gap if is_last else -gap)))
    elif imgui.is_item_deactivated():
        stretch.release()
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    draw.add_rect_filled(corner, end, theme.colors.handle if is_lit else theme.colors.key, 2.0)
