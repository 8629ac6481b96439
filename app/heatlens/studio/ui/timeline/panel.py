"""Draw the timeline panel: transport, ruler with the state of the frames, and keys or curve.

The row of key controls sets a key, auto key, curve, interpolation and easing.
"""

import math
from collections.abc import Sequence
from functools import partial

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.keys.key_choice import key_of
from heatlens.core.model.keys.key_rows import CAMERA
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import RecordingState
from heatlens.media.frame_cache.frame_states import Run
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.timeline.curve_editor import curve_editor
from heatlens.studio.ui.timeline.dope_sheet import dope_sheet
from heatlens.studio.ui.timeline.recording_row import recording_row
from heatlens.studio.ui.timeline.tool_row import (
    Tool,
    button_tool,
    checkbox_tool,
    text_tool,
    tool_row,
)
from heatlens.studio.ui.timeline.transport import combo, transport
from heatlens.studio.ui.timeline.view import TimelineView, TimeScale

NAMES_EM = 8.0  # width of the column of names
_RULER_EM, _STRIP_EM = 1.9, 0.27
_NUMBERS_EM = 4.4  # smallest distance between numbers on the ruler
_ZOOM = 1.25  # zoom factor of one wheel notch
_EDGE_EM = 0.6


def timeline_panel(control: TimeControl, view: TimelineView, unit: str) -> None:
    """Draw the timeline in the current window, and apply what the mouse does in it."""
    transport(control)
    if control.recording.state is RecordingState.OFF:
        key_controls_row(control, view)
    else:
        recording_row(control, unit)
    em = imgui.get_font_size()
    corner, free_size = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    x = corner.x + NAMES_EM * em
    width = max(free_size.x - (NAMES_EM + _EDGE_EM) * em, 4 * em)
    scale = _visible_scale(control, view, x, width)
    ruler_height = _RULER_EM * em
    widgets.invisible_button("timeline ruler", ImVec2(x, corner.y), ImVec2(width, ruler_height))
    if imgui.is_item_active():
        control.timeline.go_to(scale.frame_at(imgui.get_mouse_pos().x))
    _draw_ruler(control, view, scale, corner.y, ruler_height)
    bottom = corner.y + max(free_size.y, ruler_height)
    top = corner.y + ruler_height + 0.15 * em
    area = scale, ImVec2(corner.x, top), max(bottom - top, 1.0)
    if control.keys.rows.shows_curve:
        curve_editor(control, view, unit, *area)
    else:
        dope_sheet(control, view, *area)
    _draw_playhead(control, scale, corner.y, bottom)
    _zoom_and_pan(control, view, scale)


def _visible_scale(control: TimeControl, view: TimelineView, x: float, width: float) -> TimeScale:
    """Return the scale of the visible frames over `width`."""
    frames, old_scale = control.timeline.visible_range, view.scale
    if old_scale is None:
        return TimeScale.over(frames.first, frames.last, x, width)
    scale = TimeScale(old_scale.first, old_scale.last, x, max(width, 1.0))
    return scale.pan(0.0, frames.first - 0.5, frames.last + 0.5)


def _zoom_and_pan(control: TimeControl, view: TimelineView, scale: TimeScale) -> None:
    """Zoom the visible frames with the wheel, or pan them with a middle drag."""
    io, frames = imgui.get_io(), control.timeline.visible_range
    first_time, last_time = frames.first - 0.5, frames.last + 0.5
    if not imgui.is_window_hovered():
        return
    if io.mouse_wheel and not io.key_alt:
        scale = scale.zoom(_ZOOM**io.mouse_wheel, io.mouse_pos.x, first_time, last_time)
    elif imgui.is_mouse_dragging(imgui.MouseButton_.middle, 0.0) and io.mouse_delta.x:
        scale = scale.pan(io.mouse_delta.x, first_time, last_time)
    else:
        return
    is_all = scale.last - scale.first >= last_time - first_time
    view.scale = None if is_all else scale


def _draw_ruler(
    control: TimeControl, view: TimelineView, scale: TimeScale, y: float, height: float
) -> None:
    """Draw the ruler: played range, numbers, rendered frames, states and warnings."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    strip_height = _STRIP_EM * em
    end_x, strip_y = scale.x + scale.width, y + height - strip_height
    draw.push_clip_rect(ImVec2(scale.x, y), ImVec2(end_x, y + height), True)
    draw.add_rect_filled(ImVec2(scale.x, y), ImVec2(end_x, y + height), theme.colors.groove)
    _draw_cells(draw, scale, control.timeline.played, y, strip_y, theme.colors.played)
    for frame in scale.ticks(_NUMBERS_EM * em):
        tick_x = scale.x_at(frame)
        draw.add_line(
            ImVec2(tick_x, strip_y - 0.3 * em), ImVec2(tick_x, strip_y), theme.colors.text_dim
        )
        text = str(frame)
        text_x = scale.text_x(frame, imgui.calc_text_size(text).x)
        draw.add_text(ImVec2(text_x, y + 0.1 * em), theme.colors.text_dim, text)
    for run in control.frames_ahead.progress.runs:
        _draw_cells(draw, scale, run, strip_y - strip_height, strip_y - 1.0, theme.colors.rendered)
    _draw_states(control, scale, strip_y)
    _draw_warnings(control, view, scale, y)
    draw.pop_clip_rect()


def _draw_states(control: TimeControl, scale: TimeScale, y: float) -> None:
    """Draw a line along the frames that have a file; it is brighter for frames in memory."""
    draw, timeline = imgui.get_window_draw_list(), control.timeline
    end_y = y + _STRIP_EM * imgui.get_font_size()
    if timeline.is_sequence and timeline.frames is not None:
        _draw_cells(draw, scale, timeline.frames, y, end_y, theme.colors.on_disk)
    for run in timeline.runs():
        _draw_cells(draw, scale, run, y, end_y, _state_color(run.state))


def _state_color(state: str) -> int:
    """Return the color of frames in a state."""
    colors = theme.colors
    colors_by_state = {
        "ready": colors.ready,
        "reading": colors.text_dim,
        "queued": colors.queued,
        "damaged": colors.damaged,
    }
    return colors_by_state.get(state, colors.groove)


def _draw_warnings(control: TimeControl, view: TimelineView, scale: TimeScale, y: float) -> None:
    """Mark frames in red whose focus is nearer than the close focus of the lens."""
    frames = control.timeline.visible_range
    first = max(frames.first, math.floor(scale.first))
    visible_frames = FrameRange(first, max(first, min(frames.last, math.ceil(scale.last))))
    draw, end_y = imgui.get_window_draw_list(), y + _STRIP_EM * imgui.get_font_size()
    for frame in view.track.too_close_frames(control.editing.shot, visible_frames):
        _draw_cells(draw, scale, FrameRange(frame, frame), y, end_y, theme.colors.damaged)


def _draw_cells(
    draw: imgui.ImDrawList,
    scale: TimeScale,
    frames: FrameRange | Run,
    y0: float,
    y1: float,
    color: int,
) -> None:
    """Fill the cells of a range of frames, at least one pixel wide."""
    if frames.last + 0.5 > scale.first and frames.first - 0.5 < scale.last:
        x0, x1 = scale.x_at(frames.first - 0.5), scale.x_at(frames.last + 0.5)
        draw.add_rect_filled(ImVec2(x0, y0), ImVec2(max(x1, x0 + 1.0), y1), color)


def _draw_playhead(control: TimeControl, scale: TimeScale, y0: float, y1: float) -> None:
    """Draw the playhead as a line with the number of its frame."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    text = str(control.editing.frame)
    half_width = imgui.calc_text_size(text).x / 2 + 0.3 * em
    x = scale.x_at(control.editing.frame)
    if not scale.x - 1 <= x <= scale.x + scale.width + 1:
        return
    draw.add_line(ImVec2(x, y0), ImVec2(x, y1), theme.colors.handle, 0.1 * em)
    draw.add_rect_filled(
        ImVec2(x - half_width, y0), ImVec2(x + half_width, y0 + 1.15 * em), theme.colors.handle, 3.0
    )
    draw.add_text(ImVec2(x - half_width + 0.3 * em, y0 + 0.06 * em), theme.colors.on_accent, text)


_MIXED = "mixed"
_SET_TIPS = {
    False: "Set a key for the focus and every parameter that has keys (K)",
    True: "Set a key for the camera at this frame (K)",
}
_AUTO_KEY_TIP = "Set a key whenever a parameter with keys is changed (A)"
_CURVE_TIP = "Show the selected row as a curve, or all keys in rows (Shift+C)"
_EASE_EM, _INTERPOLATION_EM, _CURVE_OF_EM = 6.2, 6.0, 8.4


def key_controls_row(control: TimeControl, view: TimelineView) -> None:
    """Draw the row of key controls; those for selected keys are disabled without any."""
    em, rows = imgui.get_font_size(), control.keys.rows
    keys = [
        key
        for key_id in control.keys.target_keys
        if (key := key_of(control.editing.shot, key_id)) is not None
    ]
    tools = [
        button_tool(
            "Set key", "set key", 0, control.keys.set_here, _SET_TIPS[rows.selected_row is CAMERA]
        ),
        checkbox_tool("auto key", control.editing, "auto_key", 1, _AUTO_KEY_TIP),
        checkbox_tool("curve", rows, "shows_curve", 1, _CURVE_TIP),
        Tool(partial(_interpolation_choice, control, keys), _INTERPOLATION_EM * em, 3),
        Tool(partial(_ease_field, control, keys, "ease out", True), _EASE_EM * em, 4),
        Tool(partial(_ease_field, control, keys, "ease in", False), _EASE_EM * em, 4),
        text_tool(_selection_note(control), 5),
    ]
    if rows.shows_curve:
        tools.insert(3, Tool(partial(_curve_choice, control, view), _CURVE_OF_EM * em, 2))
    tool_row("keys", tools)


def _curve_choice(control: TimeControl, view: TimelineView) -> None:
    """Draw the choice of the parameter whose curve is shown."""
    rows = control.keys.rows
    parameter = combo("curve of", rows.curve_parameter, {row: row.words for row in LensParameter})
    if parameter is not rows.curve_parameter:
        rows.select(parameter)
        view.heights = None


def _interpolation_choice(control: TimeControl, keys: Sequence[Key]) -> None:
    """Draw the interpolation after the chosen keys; the camera has only one."""
    kinds = {key.interpolation for key in keys}
    current = kinds.pop() if len(kinds) == 1 else None
    words: dict[Interpolation | None, str] = {kind: str(kind) for kind in Interpolation}
    with widgets.disabled(not keys):
        picked_kind = combo("interpolation", current, words, _MIXED if keys else "")
    if picked_kind is not None and picked_kind is not current:
        control.keys.interpolate(picked_kind)


def _ease_field(control: TimeControl, keys: Sequence[Key], name: str, is_out: bool) -> None:
    """Draw the length of the handles of the chosen keys on one side."""
    eases = [key.ease_out if is_out else key.ease_in for key in keys]
    percent = eases[0].influence_percent if eases else 0.0
    with widgets.disabled(not keys):
        has_changed, new_percent = imgui.drag_float(
            f"##{name}", percent, 0.5, 0.0, 100.0, f"{name} %.0f %%",
            imgui.SliderFlags_.always_clamp,
        )  # fmt: skip
        rects.note(name)
        texts.tooltip("How far the handle reaches; the segment becomes a Bezier")
    if has_changed:
        control.keys.ease(new_percent, is_out)


def _selection_note(control: TimeControl) -> str:
    """Return how many keys are selected, in words."""
    count = len(control.keys.selection)
    if count:
        return f"{count} key{'s' * (count > 1)} selected"
    return "key" if control.keys.target_keys else "no key"
