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
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.desks import TimeDesk
from heatlens.studio.session.keys.key_choice import Chosen, KeyId, key_of, moved
from heatlens.studio.session.keys.key_drag import Places, nearest
from heatlens.studio.session.live.pull_recording import RecordingState
from heatlens.studio.session.time.focus_track import Sample
from heatlens.studio.ui import probe, theme
from heatlens.studio.ui.probe import Rect
from heatlens.studio.ui.timeline.curve_axis import AXES, CurveAxis, raised
from heatlens.studio.ui.timeline.curve_handles import Heights, curve_handles
from heatlens.studio.ui.timeline.dope_sheet import draw_keys, hold_keys, stretch_grips
from heatlens.studio.ui.timeline.recording_row import draw_recorded, recorded_places
from heatlens.studio.ui.timeline.view import TimelineView, TimeScale

_SAMPLE_PX, _ROOM = 4.0, 0.12
_GRIP_EM = 1.4  # room at the edges for the grip of the chosen keys
_ZOOM, _ZOOM_LEAST = 1.25, 0.1  # zoom factor of one notch; smallest range, as a share of the usual
_NAME_GAP = 0.5  # em
_STILL_PX = 3.0  # a smaller vertical movement of the mouse does not change the value of a key
Line = Sequence[tuple[float, float]]  # (frame, place on the axis)


def curve_editor(
    desk: TimeDesk, view: TimelineView, unit: str, scale: TimeScale, corner: ImVec2, height: float
) -> None:
    """Draw the editor at `corner`, its labels left of `scale`, and apply the mouse."""
    axis = AXES[desk.keys.rows.curve_of]
    count = max(int(scale.width / _SAMPLE_PX), 2)
    line = view.line.points(desk.editing.shot, axis, scale.first, scale.last, count)
    sharp = _sharp(desk, view, scale, count)
    is_recording = desk.recording.state is RecordingState.RECORDING
    if (
        view.heights is None or is_recording or not imgui.is_any_item_active()
    ):  # during a drag the range stays, so that the key stays under the pointer
        view.heights = view.zoomed or _ends(desk, axis, line, sharp, view.frames_all)
    heights = Heights(*view.heights, corner.y, height)
    _draw_ground(unit, axis, scale, heights)
    _draw_sharp(scale, heights, sharp)
    if axis.parameter is LensParameter.FOCUS_DISTANCE:
        draw_recorded(desk.recording, scale, heights)
    _draw_line(scale, heights, line, theme.colors.accent, 0.12)
    if axis.parameter is LensParameter.FOCUS_DISTANCE:
        _draw_marks(desk, scale, heights)
    curve_handles(desk, axis, scale, heights)
    places = _places(desk.editing.shot, axis, scale, heights)

    def move(shot: Shot, chosen: Chosen, frames: int, up: float) -> tuple[Shot, Chosen]:
        higher = up / heights.per_place if abs(up) > _STILL_PX else 0.0
        return moved(raised(shot, chosen, axis, higher), chosen, frames)

    stretch_grips(view.stretch, scale, corner.y, height)
    hold_keys(view.drag, scale, corner.y, height, places, move)
    draw_keys(desk, view.drag, scale, places, corner.y, height)
    _draw_value(desk, view, places, scale, unit)
    _answer_pointer(view, axis, scale, heights)


def _answer_pointer(
    view: TimelineView, axis: CurveAxis, scale: TimeScale, heights: Heights
) -> None:
    """Note that the pointer is over the curve; Alt and the wheel zoom the values there."""
    io = imgui.get_io()
    is_here = imgui.is_mouse_hovering_rect(*_corners(scale, heights))
    view.pointed_at = is_here and imgui.is_window_hovered()
    if view.pointed_at and io.key_alt and io.mouse_wheel:
        middle, factor = heights.place_at(io.mouse_pos.y), _ZOOM**-io.mouse_wheel
        low = max(middle + (heights.low - middle) * factor, axis.least)
        high = middle + (heights.high - middle) * factor
        view.zoomed = low, max(high, low + _ZOOM_LEAST * axis.span_least)


def _draw_value(
    desk: TimeDesk, view: TimelineView, places: Places, scale: TimeScale, unit: str
) -> None:
    """Draw the value beside the key that is dragged or pointed at."""
    mouse, em = imgui.get_mouse_pos(), imgui.get_font_size()
    held = {key: at for key, at in places.items() if key in desk.keys.chosen}
    is_dragged = view.drag.is_holding and held and view.drag.box_from is None
    reach = math.inf if is_dragged else em * imgui.is_window_hovered()
    key_id = nearest((mouse.x, mouse.y), held if is_dragged else places, reach)
    key = None if key_id is None else key_of(desk.editing.shot, key_id)
    if key_id is None or not isinstance(key, Key):
        return
    axis, (x, y) = AXES[desk.keys.rows.curve_of], places[key_id]
    words = axis.words(key.value, unit)
    width = imgui.calc_text_size(words).x + 0.6 * em
    x += -0.7 * em - width if x + 0.7 * em + width > scale.x + scale.width else 0.7 * em
    low, high = ImVec2(x, y - 0.6 * em), ImVec2(x + width, y + 0.6 * em)
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled(low, high, theme.colors.mark, 3.0)
    draw.add_text(ImVec2(x + 0.3 * em, y - 0.5 * em), theme.colors.on_accent, words)
    probe.note_at("value beside the key", (low.x, low.y, high.x, high.y))


def _sharp(desk: TimeDesk, view: TimelineView, scale: TimeScale, count: int) -> tuple[Sample, ...]:
    """Return the depth of field at `count` times; nothing if another parameter is shown."""
    if desk.keys.rows.curve_of is not LensParameter.FOCUS_DISTANCE:
        return ()
    return view.track.samples(desk.editing.shot, scale.first, scale.last, count)


def _ends(
    desk: TimeDesk, axis: CurveAxis, line: Line, sharp: tuple[Sample, ...], frames_all: bool
) -> tuple[float, float]:
    """Return the visible range of places: keys and curve, and the depth of field near them.

    With `frames_all`, or where there are no keys, the marks lie in it too.
    """
    keys = desk.editing.shot.curves.of(axis.parameter).keys
    places = [place for _, place in line] + [axis.place_of(key.value) for key in keys]
    places += recorded_places(desk.recording) if sharp else []
    places += _mark_places(desk) if sharp and (frames_all or not keys) else []
    low, high = min(places), max(places)
    band = max((sample.near - sample.focus for sample in sharp), default=0.0)
    span = high - low + 2 * min(band, high - low + axis.span_least)
    span = max(span, axis.span_least)
    middle = (low + high) / 2
    low = max(middle - span * (0.5 + _ROOM), axis.least)
    return low, max(middle + span * (0.5 + _ROOM), low + axis.span_least)


def _mark_places(desk: TimeDesk) -> list[float]:
    places = [1.0 / m.distance_m for m in desk.editing.shot.marks if isinstance(m, DistanceMark)]
    lines = [line for track in desk.mark_tracks() for line in track.lines]
    return places + [place for line in lines for _, place in line]


def _places(shot: Shot, axis: CurveAxis, scale: TimeScale, heights: Heights) -> Places:
    return {
        KeyId(axis.parameter, key.frame): (
            scale.x_at(key.frame),
            heights.y_at(axis.place_of(key.value)),
        )
        for key in shot.curves.of(axis.parameter).keys
    }


def _draw_ground(unit: str, axis: CurveAxis, scale: TimeScale, heights: Heights) -> None:
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    corner, end = _corners(scale, heights)
    draw.add_rect_filled(corner, end, theme.colors.groove)
    last_y = end.y + em
    for value in axis.visible_labels(heights.low, heights.high, 1.1 * em / heights.per_place):
        y = heights.y_at(axis.place_of(value))
        if last_y - y >= 1.1 * em and y <= end.y - 0.5 * em:
            text = axis.words(value, unit)
            left = scale.x - 0.5 * em - imgui.calc_text_size(text).x
            draw.add_text(ImVec2(left, max(y - 0.5 * em, corner.y)), theme.colors.text_dim, text)
            draw.add_line(ImVec2(scale.x, y), ImVec2(end.x, y), theme.colors.played)
            last_y = y


def _corners(scale: TimeScale, heights: Heights) -> tuple[ImVec2, ImVec2]:
    end = ImVec2(scale.x + scale.width, heights.y + heights.height)
    return ImVec2(scale.x, heights.y), end


def _points(
    scale: TimeScale, heights: Heights, places: Iterable[tuple[float, float]]
) -> Iterator[ImVec2]:
    """Return screen positions."""
    return (ImVec2(scale.x_at(frame), heights.line_y(place)) for frame, place in places)


def _draw_sharp(scale: TimeScale, heights: Heights, samples: tuple[Sample, ...]) -> None:
    """Draw the depth of field as a band between its limits."""
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(*_corners(scale, heights), True)
    smooth, draw.flags = draw.flags, 0  # or each seam between two quads would be drawn twice
    for a, b in pairwise(samples):
        x0, x1 = scale.x_at(a.frame), scale.x_at(b.frame)
        draw.add_quad_filled(
            ImVec2(x0, heights.line_y(a.far)),
            ImVec2(x1, heights.line_y(b.far)),
            ImVec2(x1, heights.line_y(b.near)),
            ImVec2(x0, heights.line_y(a.near)),
            theme.colors.in_focus_band,
        )
    draw.flags = smooth
    draw.pop_clip_rect()
    for limit in ("far", "near") if samples else ():
        line = [(s.frame, getattr(s, limit)) for s in samples]
        _draw_line(scale, heights, line, theme.colors.in_focus, 0.067)


def _draw_line(scale: TimeScale, heights: Heights, line: Line, color: int, em: float) -> None:
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(*_corners(scale, heights), True)
    width = em * imgui.get_font_size()
    draw.add_polyline([*_points(scale, heights, line)], color, width, 0)
    draw.pop_clip_rect()


def _draw_marks(desk: TimeDesk, scale: TimeScale, heights: Heights) -> None:
    """Draw the distances of the marks: fixed ones as lines, others at the frames they are known."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    corner, end = _corners(scale, heights)
    names = _Names(corner.y)
    draw.push_clip_rect(corner, end, True)
    lines: list[tuple[str, Line]] = []
    for track in desk.mark_tracks():
        for earlier in track.lines[:-1]:
            draw.add_polyline([*_points(scale, heights, earlier)], theme.colors.mark, 0.1 * em, 0)
        lines += [(track.name, line) for line in track.lines[-1:]]
        for bridge in track.bridges:
            _draw_dashes(_points(scale, heights, bridge), 0.5 * em)
    for mark in desk.editing.shot.marks:
        if isinstance(mark, DistanceMark):
            place = 1.0 / mark.distance_m
            lines.append((mark.name, ((scale.first, place), (scale.last, place))))
    for name, line in sorted(lines, key=lambda it: it[1][-1][1]):
        draw.add_polyline([*_points(scale, heights, line)], theme.colors.mark, 0.1 * em, 0)
        x = min(scale.x_at(line[-1][0]), end.x) - _GRIP_EM * em
        if heights.low <= line[-1][1] <= heights.high:
            names.draw(name, x, heights.y_at(line[-1][1]), theme.colors.mark)
    draw.pop_clip_rect()


def _draw_dashes(ends: Iterable[ImVec2], dash: float) -> None:
    """Draw a broken line, as for a thing that is hidden."""
    start, end = ends
    draw, count = imgui.get_window_draw_list(), max(int(math.dist(start, end) / dash), 1)
    for at in range(0, count, 2):
        a, b = (start + (end - start) * (it / count) for it in (at, min(at + 1, count)))
        draw.add_line(a, b, theme.colors.mark, 0.2 * dash)


@dataclass
class _Names:
    """Draws names of lines above their right ends, but below `top`, and left of other names."""

    top: float
    taken: list[Rect] = field(default_factory=list)

    def draw(self, name: str, end: float, y: float, color: int) -> None:
        """Draw a name that ends at `end` or left of it, over a line at `y`."""
        em, text = imgui.get_font_size(), printable(name)
        width, y0 = imgui.calc_text_size(text).x, max(y - em, self.top)
        for left, upper, right, lower in sorted(self.taken, reverse=True):
            if (
                upper < y0 + em
                and y0 < lower
                and left < end + _NAME_GAP * em
                and end - width < right
            ):
                end = left - _NAME_GAP * em
        rect = end - width, y0, end, y0 + em
        self.taken.append(rect)
        probe.note_at(f"name {name} on the curve", rect)
        imgui.get_window_draw_list().add_text(ImVec2(rect[0], y0), color, text)
