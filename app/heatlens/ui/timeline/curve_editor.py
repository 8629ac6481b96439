"""Draw one parameter as an editable curve over frames, with depth of field and focus marks.

Infinity is at the top, and equal heights are equal turns of the ring, see `curve_axis`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from imgui_bundle import ImVec2, imgui

from heatlens.base.printable import printable
from heatlens.model.marks import DistanceMark
from heatlens.model.shot import LensParameter, Shot
from heatlens.session.desks import TimeDesk
from heatlens.session.keys.key_choice import Chosen, KeyId, moved
from heatlens.session.keys.key_drag import Places
from heatlens.session.live.pull_recording import RecordingState
from heatlens.session.time.focus_track import Sample
from heatlens.ui import probe, theme
from heatlens.ui.probe import Rect
from heatlens.ui.timeline.curve_axis import AXES, CurveAxis, raised
from heatlens.ui.timeline.curve_handles import Heights, curve_handles
from heatlens.ui.timeline.dope_sheet import draw_keys, hold_keys
from heatlens.ui.timeline.recording_row import draw_recorded, recorded_places
from heatlens.ui.timeline.scale import TimeScale
from heatlens.ui.timeline.stretch_grips import stretch_grips
from heatlens.ui.timeline.view import TimelineView

_SAMPLE_PX, _ROOM = 4.0, 0.12
_GRIP_EM = 1.4  # room at the left edge for the grip of the chosen keys
_STILL_PX = 3.0  # a smaller vertical movement of the mouse does not change the value of a key
Line = Sequence[tuple[float, float]]  # (frame, place on the axis)


def curve_editor(
    desk: TimeDesk,
    view: TimelineView,
    unit: str,
    scale: TimeScale,
    corner: ImVec2,
    height: float,
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
        view.heights = _ends(desk, axis, line, sharp)
    heights = Heights(*view.heights, corner.y, height)
    _draw_ground(unit, axis, scale, heights)
    _draw_sharp(scale, heights, sharp)
    if axis.parameter is LensParameter.FOCUS_DISTANCE:
        draw_recorded(desk.recording, scale, heights)
    _draw_line(scale, heights, line, theme.colors.accent, 1.8)
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


def _sharp(desk: TimeDesk, view: TimelineView, scale: TimeScale, count: int) -> tuple[Sample, ...]:
    """Return the depth of field at `count` times; nothing if another parameter is shown."""
    if desk.keys.rows.curve_of is not LensParameter.FOCUS_DISTANCE:
        return ()
    return view.track.samples(desk.editing.shot, scale.first, scale.last, count)


def _ends(
    desk: TimeDesk, axis: CurveAxis, line: Line, sharp: tuple[Sample, ...]
) -> tuple[float, float]:
    """Return the visible range of places: curve, marks, and the depth of field near them."""
    places = [place for _, place in line]
    places += [axis.place_of(key.value) for key in desk.editing.shot.curves.of(axis.parameter).keys]
    places += [*_mark_places(desk), *recorded_places(desk.recording)] if sharp else []
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
    """Draw the background with a line for each labelled value."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    corner, end = _corners(scale, heights)
    draw.add_rect_filled(corner, end, theme.colors.groove)
    last_y = end.y + em
    for value in axis.labels_for(1.1 * em / heights.per_place):
        place = axis.place_of(value)
        y = heights.y_at(place)
        inside = heights.low <= place <= heights.high
        if inside and last_y - y >= 1.1 * em and y <= end.y - 0.5 * em:
            text = axis.words(value, unit)
            left = scale.x - 0.5 * em - imgui.calc_text_size(text).x
            draw.add_text(ImVec2(left, max(y - 0.5 * em, corner.y)), theme.colors.text_dim, text)
            draw.add_line(ImVec2(scale.x, y), ImVec2(end.x, y), theme.colors.played)
            last_y = y


def _corners(scale: TimeScale, heights: Heights) -> tuple[ImVec2, ImVec2]:
    end = ImVec2(scale.x + scale.width, heights.y + heights.height)
    return ImVec2(scale.x, heights.y), end


def _points(scale: TimeScale, heights: Heights, places: Iterable[tuple[float, float]]) -> list[Any]:
    """Return screen positions, as the untyped list that ImGui's stubs require."""
    return [ImVec2(scale.x_at(frame), heights.y_at(place)) for frame, place in places]


def _draw_sharp(scale: TimeScale, heights: Heights, samples: tuple[Sample, ...]) -> None:
    """Draw the depth of field as a band between its limits."""
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(*_corners(scale, heights), True)
    for a, b in pairwise(samples):
        x0, x1 = scale.x_at(a.frame), scale.x_at(b.frame)
        draw.add_quad_filled(
            ImVec2(x0, heights.y_at(a.far)),
            ImVec2(x1, heights.y_at(b.far)),
            ImVec2(x1, heights.y_at(b.near)),
            ImVec2(x0, heights.y_at(a.near)),
            theme.colors.in_focus_band,
        )
    draw.pop_clip_rect()
    for limit in ("far", "near") if samples else ():
        line = [(s.frame, getattr(s, limit)) for s in samples]
        _draw_line(scale, heights, line, theme.colors.in_focus, 1.0)


def _draw_line(scale: TimeScale, heights: Heights, line: Line, color: int, width: float) -> None:
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(*_corners(scale, heights), True)
    draw.add_polyline(_points(scale, heights, line), color, width, 0)
    draw.pop_clip_rect()


def _draw_marks(desk: TimeDesk, scale: TimeScale, heights: Heights) -> None:
    """Draw the distances of the marks: fixed ones as lines, others at the frames they are known."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    corner, end = _corners(scale, heights)
    names = _Names(corner.y)
    draw.push_clip_rect(corner, end, True)
    for mark in desk.editing.shot.marks:
        if isinstance(mark, DistanceMark):
            y = heights.y_at(1.0 / mark.distance_m)
            draw.add_line(ImVec2(scale.x, y), ImVec2(end.x, y), theme.colors.queued, 1.0)
            names.draw(mark.name, scale.x + _GRIP_EM * em, y, theme.colors.text_dim)
    for track in desk.mark_tracks():
        for line in track.lines:
            draw.add_polyline(_points(scale, heights, line), theme.colors.mark, 1.5, 0)
            x, y = scale.x_at(line[0][0]), heights.y_at(line[0][1])
            names.draw(track.name, max(x, scale.x) + 0.2 * em, y, theme.colors.mark)
    draw.pop_clip_rect()


@dataclass
class _Names:
    """Draws names of lines above them, but below `top`, and right of names they would touch."""

    top: float
    taken: list[Rect] = field(default_factory=list)

    def draw(self, name: str, x: float, y: float, color: int) -> None:
        """Draw a name at `x` or right of it, over a line at `y`."""
        em, text = imgui.get_font_size(), printable(name)
        width, y0 = imgui.calc_text_size(text).x, max(y - em, self.top)
        for left, upper, right, lower in sorted(self.taken):
            if x < right and x + width > left and y0 < lower and y0 + em > upper:
                x = right + 0.5 * em
        imgui.get_window_draw_list().add_text(ImVec2(x, y0), color, text)
        self.taken.append((x, y0, x + width, y0 + em))
        probe.note_at(f"name {name} on the curve", self.taken[-1])
