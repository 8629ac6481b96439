"""Draw one parameter as an editable curve over frames, with depth of field and focus marks.

Infinity is at the top, and equal heights are equal turns of the ring, see `curve_axis`.
"""

import math
from itertools import pairwise

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.curves.curve import Key
from heatlens.core.model.keys.key_choice import KeyId, KeySelection, key_of, move_keys
from heatlens.core.model.shot.focus_track import Sample
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import RecordingState
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.board.key_drag import KeyPositions, Move, nearest_key
from heatlens.studio.ui import theme
from heatlens.studio.ui.timeline.curve_axis import AXES, CurveAxis, raise_keys
from heatlens.studio.ui.timeline.curve_handles import (
    Heights,
    Line,
    corners_of,
    draw_handles,
    draw_value_beside,
    screen_points,
)
from heatlens.studio.ui.timeline.curve_marks import MarkSnap, draw_marks, mark_levels
from heatlens.studio.ui.timeline.dope_sheet import draw_keys, handle_key_drag, stretch_grips
from heatlens.studio.ui.timeline.recording_row import draw_recorded, recorded_range
from heatlens.studio.ui.timeline.view import TimelineView, TimeScale

_SAMPLE_PX, _MARGIN_SHARE = 4.0, 0.12
_ZOOM, _MIN_ZOOM_SHARE = (
    1.25,
    0.1,
)  # zoom factor of one notch; smallest range, as a share of the usual
_SNAP_EM = 1.2  # how near to the line of a mark a key goes there with Shift
_MIN_DRAG_PX = 3.0  # a smaller vertical movement of the mouse does not change the value of a key


def curve_editor(
    control: TimeControl,
    view: TimelineView,
    unit: str,
    scale: TimeScale,
    corner: ImVec2,
    height: float,
) -> None:
    """Draw the editor at `corner`, its labels left of `scale`, and apply the mouse."""
    axis = AXES[control.keys.rows.curve_parameter]
    count = max(int(scale.width / _SAMPLE_PX), 2)
    line = view.line.points(control.editing.shot, axis, scale.first, scale.last, count)
    samples = _focus_samples(control, view, scale, count)
    is_recording = control.recording.state is RecordingState.RECORDING
    # During a drag the range stays, and so the key stays under the pointer.
    if view.heights is None or is_recording or not imgui.is_any_item_active():
        fitted_range = _levels_to_fit(control, axis, line, samples, view.fits_marks)
        view.heights = view.zoom_range or fitted_range
    heights = Heights(*view.heights, corner.y, height)
    _draw_background(unit, axis, scale, heights)
    _draw_sharp_range(scale, heights, samples)
    if axis.parameter is LensParameter.FOCUS_DISTANCE:
        draw_recorded(control, scale, heights)
    _draw_line(scale, heights, line, theme.colors.accent, 0.12)
    if axis.parameter is LensParameter.FOCUS_DISTANCE:
        draw_marks(control, scale, heights)
    draw_handles(control, axis, scale, heights)
    key_positions = _key_positions(control.editing.shot, axis, scale, heights)
    move = _move_function(control, view, axis, heights)
    stretch_grips(view.stretch, scale, corner.y, height)
    handle_key_drag(view.drag, scale, corner.y, height, key_positions, move)
    draw_keys(control, view.drag, scale, key_positions, corner.y, height)
    _draw_value(control, view, key_positions, scale, corner.y, unit)
    _handle_pointer(view, axis, scale, heights)


def _move_function(
    control: TimeControl, view: TimelineView, axis: CurveAxis, heights: Heights
) -> Move:
    """Return the function that moves the chosen keys; with Shift it puts them onto marks."""

    def move(
        shot: Shot, selection: KeySelection, frames: int, up: float
    ) -> tuple[Shot, KeySelection]:
        """Return the shot and selection with the keys moved by `frames` and up by pixels."""
        level_change = up / heights.px_per_level if abs(up) > _MIN_DRAG_PX else 0.0
        if imgui.get_io().key_shift and axis.parameter is LensParameter.FOCUS_DISTANCE:
            reach = _SNAP_EM * imgui.get_font_size() / heights.px_per_level
            snap = MarkSnap(control, view.drag.pressed_key, frames, reach)
            level_change = snap.level_change(shot, axis, level_change)
        return move_keys(raise_keys(shot, selection, axis, level_change), selection, frames)

    return move


def _handle_pointer(
    view: TimelineView, axis: CurveAxis, scale: TimeScale, heights: Heights
) -> None:
    """Note whether the pointer is over the curve; zoom the values with Alt and the wheel."""
    io = imgui.get_io()
    is_hovered = imgui.is_mouse_hovering_rect(*corners_of(scale, heights))
    view.is_hovered = is_hovered and imgui.is_window_hovered()
    if view.is_hovered and io.key_alt and io.mouse_wheel:
        pointer_level, factor = heights.level_at(io.mouse_pos.y), _ZOOM**-io.mouse_wheel
        low = max(pointer_level + (heights.top_level - pointer_level) * factor, axis.top_level)
        high = pointer_level + (heights.bottom_level - pointer_level) * factor
        view.zoom_range = low, max(high, low + _MIN_ZOOM_SHARE * axis.min_span)


def _draw_value(
    control: TimeControl,
    view: TimelineView,
    key_positions: KeyPositions,
    scale: TimeScale,
    top: float,
    unit: str,
) -> None:
    """Draw the value of the key that is dragged or under the pointer; `top` is the upper edge."""
    mouse, em = imgui.get_mouse_pos(), imgui.get_font_size()
    selected_positions = {
        key: position for key, position in key_positions.items() if key in control.keys.selection
    }
    is_dragged = view.drag.is_dragging and selected_positions and view.drag.box_corner is None
    reach = math.inf if is_dragged else em * imgui.is_window_hovered()
    key_id = nearest_key(
        (mouse.x, mouse.y), selected_positions if is_dragged else key_positions, reach
    )
    key = None if key_id is None else key_of(control.editing.shot, key_id)
    if key_id is None or not isinstance(key, Key):
        return
    words = AXES[control.keys.rows.curve_parameter].format_value(key.value, unit)
    draw_value_beside(words, "key", key_positions[key_id], scale, top)


def _focus_samples(
    control: TimeControl, view: TimelineView, scale: TimeScale, count: int
) -> tuple[Sample, ...]:
    """Return the depth of field at `count` times; nothing if another parameter is shown."""
    if control.keys.rows.curve_parameter is not LensParameter.FOCUS_DISTANCE:
        return ()
    return view.track.samples(control.editing.shot, scale.first, scale.last, count)


def _levels_to_fit(
    control: TimeControl, axis: CurveAxis, line: Line, samples: tuple[Sample, ...], frames_all: bool
) -> tuple[float, float]:
    """Return the visible range of levels: keys and curve, and the depth of field near them.

    With `frames_all`, or if there are no keys, the range includes the marks too.
    """
    keys = control.editing.shot.curves.of(axis.parameter).keys
    levels = [level for _, level in line] + [axis.level_of(key.value) for key in keys]
    levels += recorded_range(control) if samples else []
    levels += mark_levels(control) if samples and (frames_all or not keys) else []
    low, high = min(levels), max(levels)
    range_dioptres = max((sample.near - sample.focus for sample in samples), default=0.0)
    span = max(high - low + 2 * min(range_dioptres, high - low + axis.min_span), axis.min_span)
    center = (low + high) / 2
    low = max(center - span * (0.5 + _MARGIN_SHARE), axis.top_level)
    return low, max(center + span * (0.5 + _MARGIN_SHARE), low + axis.min_span)


def _key_positions(shot: Shot, axis: CurveAxis, scale: TimeScale, heights: Heights) -> KeyPositions:
    """Return the screen positions of the keys of a parameter."""
    return {
        KeyId(axis.parameter, key.frame): (
            scale.x_at(key.frame),
            heights.y_at(axis.level_of(key.value)),
        )
        for key in shot.curves.of(axis.parameter).keys
    }


def _draw_background(unit: str, axis: CurveAxis, scale: TimeScale, heights: Heights) -> None:
    """Draw the background with the labeled values of the axis."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    corner, end = corners_of(scale, heights)
    draw.add_rect_filled(corner, end, theme.colors.groove)
    last_y = end.y + em
    levels_apart = 1.1 * em / heights.px_per_level
    for value in axis.visible_labels(heights.top_level, heights.bottom_level, levels_apart):
        y = heights.y_at(axis.level_of(value))
        if last_y - y >= 1.1 * em and y <= end.y - 0.5 * em:
            text = axis.format_value(value, unit)
            text_x = scale.x - 0.5 * em - imgui.calc_text_size(text).x
            draw.add_text(ImVec2(text_x, max(y - 0.5 * em, corner.y)), theme.colors.text_dim, text)
            draw.add_line(ImVec2(scale.x, y), ImVec2(end.x, y), theme.colors.played)
            last_y = y


def _draw_sharp_range(scale: TimeScale, heights: Heights, samples: tuple[Sample, ...]) -> None:
    """Draw the depth of field as a band between its limits."""
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(*corners_of(scale, heights), True)
    old_flags, draw.flags = draw.flags, 0  # or each seam between two quads would be drawn twice
    for a, b in pairwise(samples):
        x0, x1 = scale.x_at(a.frame), scale.x_at(b.frame)
        draw.add_quad_filled(
            ImVec2(x0, heights.line_y(a.far)),
            ImVec2(x1, heights.line_y(b.far)),
            ImVec2(x1, heights.line_y(b.near)),
            ImVec2(x0, heights.line_y(a.near)),
            theme.colors.in_focus_band,
        )
    draw.flags = old_flags
    draw.pop_clip_rect()
    for limit in ("far", "near") if samples else ():
        line = [(sample.frame, getattr(sample, limit)) for sample in samples]
        _draw_line(scale, heights, line, theme.colors.in_focus, 0.067)


def _draw_line(scale: TimeScale, heights: Heights, line: Line, color: int, em: float) -> None:
    """Draw a line of points (frame, level), clipped to the editor."""
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(*corners_of(scale, heights), True)
    width = em * imgui.get_font_size()
    draw.add_polyline([*screen_points(scale, heights, line)], color, width, 0)
    draw.pop_clip_rect()
