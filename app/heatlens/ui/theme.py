"""Colours and fonts: neutral greys, so that nothing beside the picture tints it."""

from pathlib import Path

import imgui_bundle
from imgui_bundle import ImVec2, ImVec4, imgui

from heatlens.model.guides import LINE_OPACITY

FONT_PX = 15.0
# Behind everything: what surrounds the picture is not painted again over it.
SURROUND = (30 / 255, 30 / 255, 30 / 255)


def _rgba(red: int, green: int, blue: int, alpha: float = 1.0) -> int:
    """Return a colour as ImGui's draw lists take it."""
    return imgui.color_convert_float4_to_u32(ImVec4(red / 255, green / 255, blue / 255, alpha))


ACCENT = _rgba(242, 169, 59)  # focus: the amber of an assistant's marks
IN_FOCUS = _rgba(90, 200, 110)
IN_FOCUS_BAND = _rgba(90, 200, 110, 0.28)
HYPERFOCAL = _rgba(200, 200, 205)
HISTOGRAM = _rgba(128, 130, 136)
GROOVE = _rgba(20, 20, 21)
TEXT_DIM = _rgba(150, 150, 152)
WINDOW_LINE = _rgba(120, 120, 122, 0.8)
HANDLE = _rgba(235, 235, 235, 0.9)
SHADOW = _rgba(0, 0, 0, 0.65)
MARK = _rgba(120, 178, 232)
KEY = _rgba(196, 196, 200)
BOX = _rgba(200, 200, 210, 0.12)
ON_DISK = _rgba(74, 74, 76)
QUEUED = _rgba(112, 112, 116)
READY = _rgba(96, 160, 108)
RENDERED = _rgba(74, 158, 200)
DAMAGED = _rgba(232, 84, 74)
PLAYED = _rgba(48, 48, 50)
ON_ACCENT = _rgba(24, 18, 8)
GUIDE = _rgba(255, 255, 255, LINE_OPACITY)
PIXEL_GRID = _rgba(128, 128, 128, 0.35)
FRINGE_RED = _rgba(240, 70, 60)  # the rims of a disc whose colours have a focus each
FRINGE_BLUE = _rgba(70, 110, 250)
RECORDED = _rgba(240, 92, 82)  # a pull that was performed
RECORDED_BAND = _rgba(240, 92, 82, 0.32)
ARMED = ImVec4(0.42, 0.14, 0.12, 1.0)
TRIED = ImVec4(0.45, 0.75, 1.0, 1.0)  # a value that no key holds
BAD = ImVec4(1.0, 0.45, 0.4, 1.0)
ACCENT_TEXT = ImVec4(0.95, 0.72, 0.38, 1.0)
DIM = ImVec4(0.6, 0.6, 0.61, 1.0)

_Col = imgui.Col_
_STYLE = {
    _Col.text: (0.88, 0.88, 0.88),
    _Col.text_disabled: (0.56, 0.56, 0.57),
    _Col.window_bg: (0.145, 0.145, 0.147),
    _Col.child_bg: (0.145, 0.145, 0.147),
    _Col.popup_bg: (0.17, 0.17, 0.172),
    _Col.border: (0.25, 0.25, 0.25),
    _Col.frame_bg: (0.21, 0.21, 0.212),
    _Col.frame_bg_hovered: (0.26, 0.26, 0.262),
    _Col.frame_bg_active: (0.31, 0.31, 0.312),
    _Col.title_bg: (0.115, 0.115, 0.116),
    _Col.title_bg_active: (0.115, 0.115, 0.116),
    _Col.menu_bar_bg: (0.115, 0.115, 0.116),
    _Col.tab: (0.145, 0.145, 0.147),
    _Col.tab_hovered: (0.30, 0.30, 0.30),
    _Col.tab_selected: (0.21, 0.21, 0.212),
    _Col.tab_selected_overline: (0.95, 0.66, 0.23),
    _Col.tab_dimmed: (0.13, 0.13, 0.13),
    _Col.tab_dimmed_selected: (0.19, 0.19, 0.19),
    _Col.tab_dimmed_selected_overline: (0.5, 0.5, 0.5),
    _Col.header: (0.24, 0.24, 0.24),
    _Col.header_hovered: (0.30, 0.30, 0.30),
    _Col.header_active: (0.34, 0.34, 0.34),
    _Col.button: (0.25, 0.25, 0.252),
    _Col.button_hovered: (0.33, 0.33, 0.332),
    _Col.button_active: (0.40, 0.40, 0.40),
    _Col.slider_grab: (0.95, 0.66, 0.23),
    _Col.slider_grab_active: (1.0, 0.74, 0.34),
    _Col.check_mark: (0.95, 0.66, 0.23),
    _Col.checkbox_selected_bg: (0.21, 0.21, 0.212),
    _Col.plot_histogram: (0.55, 0.38, 0.13),  # white figures on it can be read
    _Col.plot_histogram_hovered: (0.55, 0.38, 0.13),
    _Col.separator: (0.25, 0.25, 0.25),
    _Col.separator_hovered: (0.4, 0.4, 0.4),
    _Col.separator_active: (0.95, 0.66, 0.23),
    _Col.docking_preview: (0.95, 0.66, 0.23),
    _Col.text_selected_bg: (0.45, 0.33, 0.16),
    _Col.resize_grip: (0.25, 0.25, 0.25),
    _Col.resize_grip_hovered: (0.4, 0.4, 0.4),
    _Col.resize_grip_active: (0.95, 0.66, 0.23),
    _Col.table_header_bg: (0.19, 0.19, 0.192),
    _Col.nav_cursor: (0.95, 0.66, 0.23),
}

# What `scale_all_sizes` multiplies.
_SIZES = (
    *("window_padding", "window_rounding", "window_min_size", "window_border_hover_padding"),
    *("child_rounding", "popup_rounding", "frame_padding", "frame_rounding", "item_spacing"),
    *("item_inner_spacing", "cell_padding", "touch_extra_padding", "indent_spacing"),
    *("columns_min_spacing", "scrollbar_size", "scrollbar_rounding", "grab_min_size"),
    *("grab_rounding", "log_slider_deadzone", "tab_rounding", "tab_bar_overline_size"),
    *("separator_text_padding", "docking_separator_size", "display_window_padding"),
    *("display_safe_area_padding", "mouse_cursor_scale", "child_border_size", "separator_size"),
    *("drag_drop_target_border_size", "drag_drop_target_padding", "input_text_cursor_size"),
    *("popup_border_size", "scrollbar_padding", "separator_text_border_size", "tree_lines_size"),
    *("tab_bar_border_size", "tab_min_width_base", "tab_min_width_shrink", "window_border_size"),
    "color_marker_size",
)


def apply(scale: float = 1.0) -> None:
    """Set the style of the current ImGui context for a screen of this content scale."""
    style, usual = imgui.get_style(), imgui.Style()
    for name in _SIZES:  # those that were scaled before begin again
        setattr(style, name, getattr(usual, name))
    imgui.style_colors_dark()
    for slot, (red, green, blue) in _STYLE.items():
        style.set_color_(slot, ImVec4(red, green, blue, 1.0))
    style.set_color_(_Col.modal_window_dim_bg, ImVec4(0.0, 0.0, 0.0, 0.5))
    style.window_rounding = style.frame_rounding = style.popup_rounding = 3.0
    style.tab_rounding = style.grab_rounding = 3.0
    style.frame_padding = ImVec2(7.0, 4.0)
    style.item_spacing = ImVec2(8.0, 6.0)
    style.window_border_size = 0.0
    style.scrollbar_size = 12.0
    style.tab_min_width_shrink = 30.0  # tabs grow narrower rather than leave the row
    style.window_menu_button_position = imgui.Dir.none
    style.scale_all_sizes(scale)
    style.font_scale_dpi = scale
    fonts = imgui.get_io().fonts
    if len(fonts.fonts) > 0:
        return
    folder = Path(imgui_bundle.__file__).parent / "assets" / "fonts" / "Roboto"
    fonts.add_font_from_file_ttf(str(folder / "Roboto-Regular.ttf"), FONT_PX)
