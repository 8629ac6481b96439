"""Apply colours, sizes and fonts to ImGui; keep the palette in use."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import imgui_bundle
from imgui_bundle import ImVec2, ImVec4, imgui

from heatlens.ui.palettes import DARK, Palette

_FONTS = Path(imgui_bundle.__file__).parent / "assets" / "fonts"
FONT_FILE, FONT_PX = _FONTS / "Roboto" / "Roboto-Regular.ttf", 15.0
# The colour around the picture in every theme. The surround changes how bright and colourful a
# picture looks, so pictures are judged against a neutral grey that is darker than they are.
SURROUND = (30 / 255, 30 / 255, 30 / 255)
# The palette of everything drawn over the picture, whose background is dark in every theme.
OVER_PICTURE = DARK
DARK_INK, LIGHT_INK = (0.0, 0.0, 0.0, 0.9), (1.0, 1.0, 1.0, 0.9)  # text in pixels of the picture
NOTHING, UNTINTED = 0, 0xFFFFFFFF  # a transparent background; a picture without tint

colors = DARK  # the palette in use; `paint` replaces it, so always read `theme.colors.accent`

# The style values that `scale_all_sizes` multiplies.
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
    "_main_scale",  # product of all scales; sets the line width of tab crosses
)


def packed(color: Sequence[float]) -> int:
    """Return a colour of three or four components, 0 to 1, packed for ImGui's draw lists."""
    return imgui.color_convert_float4_to_u32(ImVec4(*color, *[1.0] * (4 - len(color))))


def paint(palette: Palette) -> None:
    """Set the colours of the current ImGui context."""
    global colors
    colors = palette
    if palette.is_light:
        imgui.style_colors_light()
    else:
        imgui.style_colors_dark()
    style = imgui.get_style()
    for slot, color in palette.style.items():
        style.set_color_(slot, ImVec4(*color, 1.0))
    style.set_color_(imgui.Col_.modal_window_dim_bg, palette.dimming)
    style.frame_border_size = 1.0 if palette.is_light else 0.0  # for white on grey


@contextmanager
def over_picture() -> Iterator[None]:
    """Draw the text and controls of the block in the colours for drawing over the picture."""
    style = {} if colors is OVER_PICTURE else OVER_PICTURE.style
    for slot, color in style.items():
        imgui.push_style_color(slot, ImVec4(*color, 1.0))
    yield
    imgui.pop_style_color(len(style))


def apply(scale: float = 1.0) -> None:
    """Set sizes and fonts of the current ImGui context for a content scale (1 is 96 dpi)."""
    style, usual = imgui.get_style(), imgui.Style()
    for name in _SIZES:  # reset sizes that an earlier call has scaled
        setattr(style, name, getattr(usual, name))
    paint(colors)
    style.window_rounding = style.frame_rounding = style.popup_rounding = 3.0
    style.tab_rounding = style.grab_rounding = 3.0
    style.frame_padding = ImVec2(7.0, 4.0)
    style.item_spacing = ImVec2(8.0, 6.0)
    style.window_border_size = 0.0
    style.scrollbar_size = 12.0
    style.tab_min_width_shrink = 30.0  # tabs become narrower instead of leaving the row
    style.window_menu_button_position = imgui.Dir.none
    style.scale_all_sizes(scale)
    style.font_scale_dpi = scale
    fonts = imgui.get_io().fonts
    if len(fonts.fonts) > 0:
        return
    fonts.add_font_from_file_ttf(str(FONT_FILE), FONT_PX)
