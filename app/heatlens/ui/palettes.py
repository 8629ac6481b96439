"""Define all colours of the interface, one Palette for each theme.

Backgrounds are neutral greys, so that the surround does not bias how the picture's colours look.
What is drawn over the picture uses `DARK` in every theme, see `theme.OVER_PICTURE`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from imgui_bundle import ImVec4, imgui

from heatlens.model.guides import LINE_OPACITY

_Col = imgui.Col_


def _rgba(red: int, green: int, blue: int, alpha: float = 1.0) -> int:
    """Return a colour packed as ImGui's draw lists take it."""
    return imgui.color_convert_float4_to_u32(ImVec4(red / 255, green / 255, blue / 255, alpha))


@dataclass(frozen=True)
class Palette:
    """The colours of a theme: packed integers for draw lists, ImVec4 for text and controls.

    accent, live   the live lens alone; `on_accent` is text on it, and on keys and marks
    groove         background of bars and curves; `played` is the played range of frames
    handle         emphasised items: names of rows with keys, icons, draggable lines
    key, mark      keys of a curve, and keys that follow a focus mark
    guide          guide lines over the picture; `pixel_grid` lines between its pixels
    fringe_red     rims of a disc with axial colour, also `fringe_blue`
    disc_ground    background of the drawing of a bokeh disc
    tolerance_band how far keys may be off it, in another green than that of what is sharp
    recorded       a recorded focus pull; `armed` is the record button when armed
    told           what the program says; `bad` for faults
    tried          a value that holds at this frame only and has no key
    status_ground  background of the status bar; `start_ground` of the start screen
    dimming        drawn over everything behind a dialog
    style          ImGui's own colours, components 0 to 1
    """

    accent: int
    on_accent: int
    in_focus: int
    in_focus_band: int
    hyperfocal: int
    histogram: int
    groove: int
    played: int
    text_dim: int
    window_line: int
    handle: int
    shadow: int
    mark: int
    key: int
    box: int
    on_disk: int
    queued: int
    ready: int
    rendered: int
    damaged: int
    guide: int
    pixel_grid: int
    fringe_red: int
    fringe_blue: int
    disc_ground: int
    recorded: int
    tolerance_band: int
    status_ground: int
    start_ground: int
    armed: ImVec4
    tried: ImVec4
    bad: ImVec4
    told: ImVec4
    live: ImVec4
    dim: ImVec4
    dimming: ImVec4
    style: Mapping[int, tuple[float, float, float]]
    is_light: bool = False


_BRIGHT_KNOB = (0.74, 0.74, 0.74)
DARK = Palette(
    accent=_rgba(242, 169, 59),
    on_accent=_rgba(24, 18, 8),
    in_focus=_rgba(90, 200, 110),
    in_focus_band=_rgba(90, 200, 110, 0.28),
    hyperfocal=_rgba(200, 200, 205),
    histogram=_rgba(128, 130, 136),
    groove=_rgba(20, 20, 21),
    played=_rgba(48, 48, 50),
    text_dim=_rgba(159, 159, 161),
    window_line=_rgba(120, 120, 122, 0.8),
    handle=_rgba(235, 235, 235, 0.9),
    shadow=_rgba(0, 0, 0, 0.65),
    mark=_rgba(120, 178, 232),
    key=_rgba(120, 178, 232),
    box=_rgba(200, 200, 210, 0.12),
    on_disk=_rgba(74, 74, 76),
    queued=_rgba(112, 112, 116),
    ready=_rgba(96, 160, 108),
    rendered=_rgba(74, 158, 200),
    damaged=_rgba(232, 84, 74),
    guide=_rgba(255, 255, 255, LINE_OPACITY),
    pixel_grid=_rgba(128, 128, 128, 0.35),
    fringe_red=_rgba(240, 70, 60),
    fringe_blue=_rgba(70, 110, 250),
    disc_ground=_rgba(0, 0, 0, 0.0),
    recorded=_rgba(240, 92, 82),
    tolerance_band=_rgba(206, 226, 92, 0.42),
    status_ground=_rgba(0, 0, 0, 0.0),
    start_ground=_rgba(0, 0, 0, 0.0),
    armed=ImVec4(0.42, 0.14, 0.12, 1.0),
    tried=ImVec4(0.45, 0.75, 1.0, 1.0),
    bad=ImVec4(1.0, 0.45, 0.4, 1.0),
    told=ImVec4(0.80, 0.80, 0.80, 1.0),
    live=ImVec4(0.95, 0.66, 0.23, 1.0),
    dim=ImVec4(0.6, 0.6, 0.61, 1.0),
    dimming=ImVec4(0.0, 0.0, 0.0, 0.5),
    style={
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
        _Col.tab_selected_overline: _BRIGHT_KNOB,
        _Col.tab_dimmed: (0.13, 0.13, 0.13),
        _Col.tab_dimmed_selected: (0.19, 0.19, 0.19),
        _Col.tab_dimmed_selected_overline: (0.5, 0.5, 0.5),
        _Col.header: (0.24, 0.24, 0.24),
        _Col.header_hovered: (0.30, 0.30, 0.30),
        _Col.header_active: (0.34, 0.34, 0.34),
        _Col.button: (0.25, 0.25, 0.252),
        _Col.button_hovered: (0.33, 0.33, 0.332),
        _Col.button_active: (0.40, 0.40, 0.40),
        _Col.slider_grab: _BRIGHT_KNOB,
        _Col.slider_grab_active: (0.90, 0.90, 0.90),
        _Col.check_mark: _BRIGHT_KNOB,
        _Col.checkbox_selected_bg: (0.21, 0.21, 0.212),
        _Col.plot_histogram: (0.36, 0.36, 0.36),  # keeps white figures on it readable
        _Col.plot_histogram_hovered: (0.36, 0.36, 0.36),
        _Col.separator: (0.25, 0.25, 0.25),
        _Col.separator_hovered: (0.4, 0.4, 0.4),
        _Col.separator_active: _BRIGHT_KNOB,
        _Col.docking_preview: _BRIGHT_KNOB,
        _Col.text_selected_bg: (0.24, 0.34, 0.46),
        _Col.resize_grip: (0.25, 0.25, 0.25),
        _Col.resize_grip_hovered: (0.4, 0.4, 0.4),
        _Col.resize_grip_active: _BRIGHT_KNOB,
        _Col.table_header_bg: (0.19, 0.19, 0.192),
        _Col.nav_cursor: _BRIGHT_KNOB,
    },
)

_DARK_KNOB, _LINE = (0.36, 0.36, 0.36), (0.70, 0.70, 0.70)
LIGHT = Palette(
    accent=_rgba(168, 92, 0),
    on_accent=_rgba(255, 255, 255),
    in_focus=_rgba(24, 120, 48),
    in_focus_band=_rgba(40, 150, 66, 0.26),
    hyperfocal=_rgba(60, 60, 66),
    histogram=_rgba(120, 122, 128),
    groove=_rgba(250, 250, 250),
    played=_rgba(222, 222, 224),
    text_dim=_rgba(92, 92, 94),
    window_line=_rgba(120, 120, 122, 0.8),
    handle=_rgba(32, 32, 32, 0.95),
    shadow=_rgba(0, 0, 0, 0.35),
    mark=_rgba(20, 92, 160),
    key=_rgba(20, 92, 160),
    box=_rgba(60, 60, 80, 0.14),
    on_disk=_rgba(176, 176, 178),
    queued=_rgba(140, 140, 144),
    ready=_rgba(40, 130, 60),
    rendered=_rgba(20, 110, 160),
    damaged=_rgba(200, 40, 30),
    guide=_rgba(255, 255, 255, LINE_OPACITY),
    pixel_grid=_rgba(128, 128, 128, 0.35),
    fringe_red=_rgba(240, 70, 60),
    fringe_blue=_rgba(70, 110, 250),
    disc_ground=_rgba(37, 37, 37),
    recorded=_rgba(200, 40, 30),
    tolerance_band=_rgba(140, 160, 0, 0.40),
    status_ground=_rgba(218, 218, 219),
    start_ground=_rgba(243, 243, 243),
    armed=ImVec4(0.97, 0.74, 0.70, 1.0),
    tried=ImVec4(0.0, 0.34, 0.68, 1.0),
    bad=ImVec4(0.70, 0.07, 0.05, 1.0),
    told=ImVec4(0.16, 0.16, 0.16, 1.0),
    live=ImVec4(0.66, 0.36, 0.0, 1.0),
    dim=ImVec4(0.35, 0.35, 0.36, 1.0),
    dimming=ImVec4(0.0, 0.0, 0.0, 0.35),
    style={
        _Col.text: (0.09, 0.09, 0.09),
        _Col.text_disabled: (0.35, 0.35, 0.36),
        _Col.window_bg: (0.90, 0.90, 0.901),
        _Col.child_bg: (0.90, 0.90, 0.901),
        _Col.popup_bg: (0.95, 0.95, 0.951),
        _Col.border: (0.58, 0.58, 0.58),
        _Col.frame_bg: (0.98, 0.98, 0.981),
        _Col.frame_bg_hovered: (0.94, 0.94, 0.941),
        _Col.frame_bg_active: (0.86, 0.86, 0.861),
        _Col.title_bg: (0.82, 0.82, 0.821),
        _Col.title_bg_active: (0.82, 0.82, 0.821),
        _Col.menu_bar_bg: (0.855, 0.855, 0.856),
        _Col.tab: (0.84, 0.84, 0.841),
        _Col.tab_hovered: (0.97, 0.97, 0.97),
        _Col.tab_selected: (0.96, 0.96, 0.96),
        _Col.tab_selected_overline: _DARK_KNOB,
        _Col.tab_dimmed: (0.84, 0.84, 0.84),
        _Col.tab_dimmed_selected: (0.93, 0.93, 0.93),
        _Col.tab_dimmed_selected_overline: (0.5, 0.5, 0.5),
        _Col.header: (0.80, 0.80, 0.80),
        _Col.header_hovered: (0.75, 0.75, 0.75),
        _Col.header_active: (0.70, 0.70, 0.70),
        _Col.button: (0.79, 0.79, 0.791),
        _Col.button_hovered: (0.73, 0.73, 0.731),
        _Col.button_active: (0.66, 0.66, 0.66),
        _Col.slider_grab: _DARK_KNOB,
        _Col.slider_grab_active: (0.22, 0.22, 0.22),
        _Col.check_mark: _DARK_KNOB,
        _Col.checkbox_selected_bg: (0.98, 0.98, 0.981),
        _Col.plot_histogram: (0.74, 0.74, 0.74),  # keeps black figures on it readable
        _Col.plot_histogram_hovered: (0.74, 0.74, 0.74),
        _Col.separator: _LINE,
        _Col.separator_hovered: (0.55, 0.55, 0.55),
        _Col.separator_active: _DARK_KNOB,
        _Col.docking_preview: _DARK_KNOB,
        _Col.text_selected_bg: (0.70, 0.82, 0.95),
        _Col.resize_grip: _LINE,
        _Col.resize_grip_hovered: (0.55, 0.55, 0.55),
        _Col.resize_grip_active: _DARK_KNOB,
        _Col.table_header_bg: (0.82, 0.82, 0.821),
        _Col.nav_cursor: _DARK_KNOB,
    },
    is_light=True,
)
