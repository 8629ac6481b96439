"""Draw the line of the wipe between A and B, and its grip."""

from imgui_bundle import ImVec2, imgui

from heatlens.model.view_geometry import Viewport
from heatlens.ui import theme


def draw_wipe_handle(x: float, place: Viewport, names: tuple[str, str]) -> None:
    """Draw the line in the current window; `x` is the first column of B, in screen units."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    (_, y), (_, height) = place.corner, place.size
    middle, width = y + height / 2, 1.0 / place.framebuffer_scale
    draw.add_rect_filled(ImVec2(x, y), ImVec2(x + width, y + height), theme.OVER_PICTURE.handle)
    draw.add_circle_filled(ImVec2(x, middle), 0.55 * em, theme.OVER_PICTURE.shadow)
    draw.add_circle(ImVec2(x, middle), 0.55 * em, theme.OVER_PICTURE.handle)
    top, gap = y + 0.4 * em, 0.6 * em
    left = x - gap - imgui.calc_text_size(names[0]).x
    draw.add_text(ImVec2(left, top), theme.OVER_PICTURE.handle, names[0])
    draw.add_text(ImVec2(x + gap, top), theme.OVER_PICTURE.handle, names[1])
