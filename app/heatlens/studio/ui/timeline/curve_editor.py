"""Draw one parameter as an editable curve over frames, with depth of field and focus marks.

Infinity is at the top, and equal heights are equal turns of the ring, see `curve_axis`.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.keys.key_choice import KeyId, KeySelection, key_of, move_keys
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.focus_track import Sample
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import RecordingState
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.board.key_drag import KeyPositions, nearest_key
from heatlens.studio.ui import rects, theme
from heatlens.studio.ui.timeline.curve_axis import AXES, CurveAxis, raise_keys
from heatlens.studio.ui.timeline.curve_handles import Heights, draw_handles
from heatlens.studio.ui.timeline.dope_sheet import draw_keys, handle_key_drag, stretch_grips
from heatlens.studio.ui.timeline.recording_row import draw_recorded, recorded_range
from heatlens.studio.ui.timeline.view import TimelineView, TimeScale

_SAMPLE_PX, _MARGIN_SHARE = 4.0, 0.12
_GRIP_MARGIN_EM = 1.4  # space at the edges for the grip of the selected keys
_ZOOM, _MIN_ZOOM_SHARE = (
    1.25,
    0.1,
)  # zoom factor of one notch; smallest range, as a share of the usual
_NAME_GAP = 0.5  # em
_VALUE_RISE_EM = 1.6  # how far above a key its value is drawn
_MIN_DRAG_PX = 3.0  # a smaller vertical movement of the mouse does not change the value of a key
Line = Sequence[tuple[float, float]]  # (frame, level on the axis)


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
        _draw_marks(control, scale, heights)
    draw_handles(control, axis, scale, heights)
    key_positions = _key_positions(control.editing.shot, axis, scale, heights)

    def move(
        shot: Shot, selection: KeySelection, frames: int, up: float
    ) -> tuple[Shot, KeySelection]:
        """Return the shot and selection with the keys moved by `frames` and up by pixels."""
        level_change = up / heights.px_per_level if abs(up) > _MIN_DRAG_PX else 0.0
        return move_keys(raise_keys(shot, selection, axis, level_change), selection, frames)

    stretch_grips(view.stretch, scale, corner.y, height)
    handle_key_drag(view.drag, scale, corner.y, height, key_positions, move)
    draw_keys(control, view.drag, scale, key_positions, corner.y, height)
    _draw_value(control, view, key_positions, scale, corner.y, unit)
    _handle_pointer(view, axis, scale, heights)


def _handle_pointer(
    view: TimelineView, axis: CurveAxis, scale: TimeScale, heights: Heights
) -> None:
    """Note whether the pointer is over the curve; zoom the values with Alt and the wheel."""
    io = imgui.get_io()
    is_hovered = imgui.is_mouse_hovering_rect(*_corners(scale, heights))
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
    axis, (x, y) = AXES[control.keys.rows.curve_parameter], key_positions[key_id]
    words = axis.format_value(key.value, unit)
    width = imgui.calc_text_size(words).x + 0.6 * em
    x += -0.7 * em - width if x + 0.7 * em + width > scale.x + scale.width else 0.7 * em
    # Above the key, or below it at the upper edge, since the pointer covers what is beside it.
    y += em * (-_VALUE_RISE_EM if y - (_VALUE_RISE_EM + 0.6) * em > top else 1.5 * _VALUE_RISE_EM)
    box_corner, box_end = ImVec2(x, y - 0.6 * em), ImVec2(x + width, y + 0.6 * em)
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled(box_corner, box_end, theme.colors.mark, 3.0)
    draw.add_text(ImVec2(x + 0.3 * em, y - 0.5 * em), theme.colors.on_accent, words)
    rects.note_at("value beside the key", (box_corner.x, box_corner.y, box_end.x, box_end.y))


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
    levels += _mark_levels(control) if samples and (frames_all or not keys) else []
    low, high = min(levels), max(levels)
    range_dioptres = max((sample.near - sample.focus for sample in samples), default=0.0)
    span = max(high - low + 2 * min(range_dioptres, high - low + axis.min_span), axis.min_span)
    center = (low + high) / 2
    low = max(center - span * (0.5 + _MARGIN_SHARE), axis.top_level)
    return low, max(center + span * (0.5 + _MARGIN_SHARE), low + axis.min_span)


def _mark_levels(control: TimeControl) -> list[float]:
    """Return the distances of all marks at all known frames, as levels of the focus axis."""
    marks = control.editing.shot.marks
    levels = [1.0 / mark.distance_m for mark in marks if isinstance(mark, DistanceMark)]
    lines = [line for track in control.mark_tracks() for line in track.lines]
    return levels + [level for line in lines for _, level in line]


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
    corner, end = _corners(scale, heights)
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


def _corners(scale: TimeScale, heights: Heights) -> tuple[ImVec2, ImVec2]:
    """Return the top left and the bottom right corner of the curves' area."""
    end = ImVec2(scale.x + scale.width, heights.y + heights.height)
    return ImVec2(scale.x, heights.y), end


def _screen_points(
    scale: TimeScale, heights: Heights, levels: Iterable[tuple[float, float]]
) -> Iterator[ImVec2]:
    """Return the screen positions of points (frame, level)."""
    return (ImVec2(scale.x_at(frame), heights.line_y(level)) for frame, level in levels)


def _draw_sharp_range(scale: TimeScale, heights: Heights, samples: tuple[Sample, ...]) -> None:
    """Draw the depth of field as a band between its limits."""
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(*_corners(scale, heights), True)
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
    draw.push_clip_rect(*_corners(scale, heights), True)
    width = em * imgui.get_font_size()
    draw.add_polyline([*_screen_points(scale, heights, line)], color, width, 0)
    draw.pop_clip_rect()


def _draw_marks(control: TimeControl, scale: TimeScale, heights: Heights) -> None:
    """Draw the distances of the marks: fixed ones as lines, others at the known frames."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    corner, end = _corners(scale, heights)
    names = _NameDrawer(corner.y)
    draw.push_clip_rect(corner, end, True)
    lines: list[tuple[str, Line]] = []
    for track in control.mark_tracks():
        for line_before in track.lines[:-1]:
            draw.add_polyline(
                [*_screen_points(scale, heights, line_before)], theme.colors.mark, 0.1 * em, 0
            )
        lines += [(track.name, line) for line in track.lines[-1:]]
        for bridge in track.bridges:
            _draw_dashes(_screen_points(scale, heights, bridge), 0.5 * em)
    for mark in control.editing.shot.marks:
        if isinstance(mark, DistanceMark):
            level = 1.0 / mark.distance_m
            lines.append((mark.name, ((scale.first, level), (scale.last, level))))
    for name, line in sorted(lines, key=lambda named_line: named_line[1][-1][1]):
        draw.add_polyline([*_screen_points(scale, heights, line)], theme.colors.mark, 0.1 * em, 0)
        x = min(scale.x_at(line[-1][0]), end.x) - _GRIP_MARGIN_EM * em
        if heights.top_level <= line[-1][1] <= heights.bottom_level:
            names.draw(name, x, heights.y_at(line[-1][1]), theme.colors.mark)
    draw.pop_clip_rect()


def _draw_dashes(ends: Iterable[ImVec2], dash_px: float) -> None:
    """Draw a dashed line, for a mark that is hidden between two frames."""
    start, end = ends
    draw, count = imgui.get_window_draw_list(), max(int(math.dist(start, end) / dash_px), 1)
    for index in range(0, count, 2):
        a, b = (
            start + (end - start) * (number / count) for number in (index, min(index + 1, count))
        )
        draw.add_line(a, b, theme.colors.mark, 0.2 * dash_px)


@dataclass
class _NameDrawer:
    """Draws names of lines above their right ends, but below `top`, and left of other names."""

    top: float
    name_rects: list[rects.Rect] = field(default_factory=list)

    def draw(self, name: str, right_x: float, y: float, color: int) -> None:
        """Draw a name that ends at `end` or left of it, over a line at `y`."""
        em, text = imgui.get_font_size(), printable(name)
        width, y0 = imgui.calc_text_size(text).x, max(y - em, self.top)
        for left, top, right, bottom in sorted(self.name_rects, reverse=True):
            if (
                top < y0 + em
                and y0 < bottom
                and left < right_x + _NAME_GAP * em
                and right_x - width < right
            ):
                right_x = left - _NAME_GAP * em
        rect = right_x - width, y0, right_x, y0 + em
        self.name_rects.append(rect)
        rects.note_at(f"name {name} on the curve", rect)
        imgui.get_window_draw_list().add_text(ImVec2(rect[0], y0), color, text)
