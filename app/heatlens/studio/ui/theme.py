"""Define all colors of the interface for both themes; apply colors, sizes and fonts to ImGui.

Backgrounds are neutral grays, so that the surround does not bias how the picture's colors look.
What is drawn over the picture uses `DARK` in every theme, see `OVER_PICTURE`. The palette in use is
kept here.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Generic, TypeVar

import imgui_bundle
from imgui_bundle import ImVec2, ImVec4, imgui

from heatlens.core.model.view.guides import LINE_OPACITY

_Col = imgui.Col_
_BRIGHT_KNOB, _DARK_KNOB, _LINE = (0.74, 0.74, 0.74), (0.36, 0.36, 0.36), (0.70, 0.70, 0.70)
_Rgb = tuple[float, float, float]

# ImGui's own colors in the dark and in the light theme, components 0 to 1.
_STYLE: Mapping[int, tuple[_Rgb, _Rgb]] = {
    _Col.text: ((0.88, 0.88, 0.88), (0.09, 0.09, 0.09)),
    _Col.text_disabled: ((0.72, 0.72, 0.73), (0.27, 0.27, 0.28)),
    _Col.text_link: ((0.47, 0.70, 0.91), (0.08, 0.36, 0.63)),
    _Col.window_bg: ((0.145, 0.145, 0.147), (0.90, 0.90, 0.901)),
    _Col.child_bg: ((0.145, 0.145, 0.147), (0.90, 0.90, 0.901)),
    _Col.popup_bg: ((0.17, 0.17, 0.172), (0.95, 0.95, 0.951)),
    _Col.border: ((0.46, 0.46, 0.46), (0.50, 0.50, 0.50)),
    _Col.frame_bg: ((0.18, 0.18, 0.181), (0.98, 0.98, 0.981)),
    _Col.frame_bg_hovered: ((0.26, 0.26, 0.262), (0.94, 0.94, 0.941)),
    _Col.frame_bg_active: ((0.31, 0.31, 0.312), (0.86, 0.86, 0.861)),
    _Col.title_bg: ((0.115, 0.115, 0.116), (0.82, 0.82, 0.821)),
    _Col.title_bg_active: ((0.115, 0.115, 0.116), (0.82, 0.82, 0.821)),
    _Col.menu_bar_bg: ((0.115, 0.115, 0.116), (0.855, 0.855, 0.856)),
    _Col.tab: ((0.145, 0.145, 0.147), (0.84, 0.84, 0.841)),
    _Col.tab_hovered: ((0.30, 0.30, 0.30), (0.97, 0.97, 0.97)),
    _Col.tab_selected: ((0.21, 0.21, 0.212), (0.96, 0.96, 0.96)),
    _Col.tab_selected_overline: (_BRIGHT_KNOB, _DARK_KNOB),
    _Col.tab_dimmed: ((0.13, 0.13, 0.13), (0.84, 0.84, 0.84)),
    _Col.tab_dimmed_selected: ((0.19, 0.19, 0.19), (0.93, 0.93, 0.93)),
    _Col.tab_dimmed_selected_overline: ((0.5, 0.5, 0.5), (0.5, 0.5, 0.5)),
    _Col.header: ((0.24, 0.24, 0.24), (0.80, 0.80, 0.80)),
    _Col.header_hovered: ((0.30, 0.30, 0.30), (0.75, 0.75, 0.75)),
    _Col.header_active: ((0.34, 0.34, 0.34), (0.70, 0.70, 0.70)),
    _Col.button: ((0.22, 0.22, 0.222), (0.86, 0.86, 0.861)),
    _Col.button_hovered: ((0.31, 0.31, 0.312), (0.79, 0.79, 0.791)),
    _Col.button_active: ((0.40, 0.40, 0.40), (0.70, 0.70, 0.70)),
    _Col.slider_grab: (_BRIGHT_KNOB, _DARK_KNOB),
    _Col.slider_grab_active: ((0.90, 0.90, 0.90), (0.22, 0.22, 0.22)),
    _Col.check_mark: (_BRIGHT_KNOB, _DARK_KNOB),
    _Col.checkbox_selected_bg: ((0.18, 0.18, 0.181), (0.98, 0.98, 0.981)),
    _Col.plot_histogram: ((0.36, 0.36, 0.36), (0.74, 0.74, 0.74)),  # figures on it stay readable
    _Col.plot_histogram_hovered: ((0.36, 0.36, 0.36), (0.74, 0.74, 0.74)),
    _Col.separator: ((0.25, 0.25, 0.25), _LINE),
    _Col.separator_hovered: ((0.4, 0.4, 0.4), (0.55, 0.55, 0.55)),
    _Col.separator_active: (_BRIGHT_KNOB, _DARK_KNOB),
    _Col.docking_preview: (_BRIGHT_KNOB, _DARK_KNOB),
    _Col.text_selected_bg: ((0.24, 0.34, 0.46), (0.70, 0.82, 0.95)),
    _Col.resize_grip: ((0.25, 0.25, 0.25), _LINE),
    _Col.resize_grip_hovered: ((0.4, 0.4, 0.4), (0.55, 0.55, 0.55)),
    _Col.resize_grip_active: (_BRIGHT_KNOB, _DARK_KNOB),
    _Col.table_header_bg: ((0.19, 0.19, 0.192), (0.82, 0.82, 0.821)),
    _Col.nav_cursor: (_BRIGHT_KNOB, _DARK_KNOB),
}

Color = TypeVar("Color")


class _Pair(Generic[Color]):
    """A color of the dark and of the light theme; a palette has one of them."""

    def __init__(self, dark: Color, light: Color) -> None:
        self._dark, self._light = dark, light

    def __get__(self, palette: "Palette", _kind: object) -> Color:
        return self._light if palette.is_light else self._dark


def _packed_pair(dark: tuple[float, ...], light: tuple[float, ...] = ()) -> _Pair[int]:
    """Return colors from components 0 to 255 and an opacity, packed for ImGui's draw lists."""

    def pack(red: float, green: float, blue: float, alpha: float = 1.0) -> int:
        return imgui.color_convert_float4_to_u32(ImVec4(red / 255, green / 255, blue / 255, alpha))

    return _Pair(pack(*dark), pack(*(light or dark)))


def _text_color_pair(dark: tuple[float, ...], light: tuple[float, ...]) -> _Pair[ImVec4]:
    """Return colors of text and controls from components 0 to 1, perhaps with an opacity."""

    def text_color(red: float, green: float, blue: float, alpha: float = 1.0) -> ImVec4:
        return ImVec4(red, green, blue, alpha)

    return _Pair(text_color(*dark), text_color(*light))


# One meaning has one color, so that a color can be read without its label: amber is only the live
# lens, keys and marks are blue, messages gray, faults red; knobs and ticks are neutral. The green
# of the tolerance differs from the green of the sharp range.
class Palette:
    """The colors of a theme: packed integers for draw lists, ImVec4 for text and controls.

    accent, live   the live lens alone; `on_accent` is text on it, and on keys and marks
    groove         background of bars and curves; `played` is the played range of frames
    handle         emphasised items: names of rows with keys, icons, draggable lines
    key, mark      keys of a curve, and keys that follow a focus mark
    guide          guide lines over the picture; `pixel_grid` lines between its pixels
    fringe_red     rims of a disc with axial color, also `fringe_blue`
    disc_ground    background of the drawing of a bokeh disc
    tolerance_band how far keys may differ from a recording, in another green than the sharp range
    recorded       a recorded focus pull; `armed_button` is the record button when armed
    message        messages of the program; `bad` for faults
    trial          a value that holds at this frame only and has no key
    status_ground  background of the status bar; `start_ground` of the start screen
    dimming        drawn over everything behind a dialog
    style          ImGui's own colors, components 0 to 1
    disabled_alpha how opaque controls are that cannot be used
    """

    accent = _packed_pair((242, 169, 59), (143, 77, 0))
    on_accent = _packed_pair((24, 18, 8), (255, 255, 255))
    in_focus = _packed_pair((90, 200, 110), (20, 112, 44))
    in_focus_band = _packed_pair((90, 200, 110, 0.28), (40, 150, 66, 0.26))
    hyperfocal = _packed_pair((200, 200, 205), (60, 60, 66))
    histogram = _packed_pair((128, 130, 136), (120, 122, 128))
    groove = _packed_pair((20, 20, 21), (250, 250, 250))
    played = _packed_pair((48, 48, 50), (222, 222, 224))
    text_dim = _packed_pair((159, 159, 161), (92, 92, 94))
    window_line = _packed_pair((120, 120, 122, 0.8))
    handle = _packed_pair((235, 235, 235, 0.9), (32, 32, 32, 0.95))
    shadow = _packed_pair((0, 0, 0, 0.65), (0, 0, 0, 0.35))
    mark = _packed_pair((120, 178, 232), (20, 92, 160))
    key = _packed_pair((120, 178, 232), (20, 92, 160))
    box = _packed_pair((200, 200, 210, 0.12), (60, 60, 80, 0.14))
    on_disk = _packed_pair((106, 106, 108), (138, 138, 140))
    queued = _packed_pair((140, 140, 144), (112, 112, 116))
    ready = _packed_pair((96, 160, 108), (40, 130, 60))
    rendered = _packed_pair((74, 158, 200), (20, 110, 160))
    damaged = _packed_pair((232, 84, 74), (200, 40, 30))
    guide = _packed_pair((255, 255, 255, LINE_OPACITY))
    pixel_grid = _packed_pair((128, 128, 128, 0.35))
    fringe_red = _packed_pair((240, 70, 60))
    fringe_blue = _packed_pair((70, 110, 250))
    disc_ground = _packed_pair((0, 0, 0, 0.0), (37, 37, 37))
    recorded = _packed_pair((252, 122, 112), (180, 30, 24))
    tolerance_band = _packed_pair((206, 226, 92, 0.42), (140, 160, 0, 0.40))
    status_ground = _packed_pair((0, 0, 0, 0.0), (218, 218, 219))
    start_ground = _packed_pair((0, 0, 0, 0.0), (243, 243, 243))
    armed_button = _text_color_pair((0.42, 0.14, 0.12), (0.97, 0.74, 0.70))
    trial = _text_color_pair((0.45, 0.75, 1.0), (0.0, 0.34, 0.68))
    bad = _text_color_pair((1.0, 0.48, 0.43), (0.70, 0.07, 0.05))
    message = _text_color_pair((0.80, 0.80, 0.80), (0.16, 0.16, 0.16))
    live = _text_color_pair((0.95, 0.66, 0.23), (0.56, 0.30, 0.0))
    dim = _text_color_pair((0.72, 0.72, 0.73), (0.27, 0.27, 0.28))
    dimming = _text_color_pair((0.0, 0.0, 0.0, 0.5), (0.0, 0.0, 0.0, 0.35))

    def __init__(self, is_light: bool) -> None:
        self.is_light = is_light
        self.disabled_alpha = 0.8 if is_light else 0.7  # words stay legible
        self.style = {slot: pair[is_light] for slot, pair in _STYLE.items()}


DARK, LIGHT = Palette(False), Palette(True)


_FONTS = Path(imgui_bundle.__file__).parent / "assets" / "fonts"
FONT_FILE, FONT_PX = _FONTS / "Roboto" / "Roboto-Regular.ttf", 15.0
# The color around the picture in every theme. The surround changes how bright and colorful a
# picture looks, so pictures are judged against a neutral gray that is darker than they are.
SURROUND = (30 / 255, 30 / 255, 30 / 255)
# The palette of everything drawn over the picture, whose background is dark in every theme.
OVER_PICTURE = DARK
NOTICE_OPACITY = 0.86  # of the ground of words over the picture, legible over white too
DARK_INK, LIGHT_INK = (0.0, 0.0, 0.0, 0.9), (1.0, 1.0, 1.0, 0.9)  # text in pixels of the picture
NOTHING, UNTINTED = 0, 0xFFFFFFFF  # a transparent background; a picture without tint

colors = DARK  # the palette in use; `paint` replaces it, so always read `theme.colors.accent`

# The style values that `scale_all_sizes` multiplies by the scale of the interface. They must be
# reset before each change of the scale: a missing one would grow with every step.
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


def pack_color(color: Sequence[float]) -> int:
    """Return a color of three or four components, 0 to 1, packed for ImGui's draw lists."""
    return imgui.color_convert_float4_to_u32(ImVec4(*color, *[1.0] * (4 - len(color))))


def paint(palette: Palette) -> None:
    """Make a palette the current one, and set the colors of the ImGui context."""
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
    style.frame_border_size = 1.0  # what can be pressed has a rim that is seen
    style.disabled_alpha = palette.disabled_alpha


@contextmanager
def over_picture() -> Iterator[None]:
    """Draw the text and controls of the block in the colors for drawing over the picture."""
    style = {} if colors is OVER_PICTURE else OVER_PICTURE.style
    for slot, color in style.items():
        imgui.push_style_color(slot, ImVec4(*color, 1.0))
    yield
    imgui.pop_style_color(len(style))


def apply(scale: float = 1.0) -> None:
    """Set sizes and fonts of the current ImGui context for a content scale (1 is 96 dpi)."""
    style, default_style = imgui.get_style(), imgui.Style()
    for name in _SIZES:  # reset sizes that an earlier call has scaled
        setattr(style, name, getattr(default_style, name))
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
