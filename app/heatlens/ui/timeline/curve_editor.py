"""The focus as a curve over frames, what is sharp around it, and where marked things are.

Up is far: infinity lies at the top, 0 dioptres, and equal heights are equal steps of a focus ring.
"""

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from imgui_bundle import ImVec2, imgui

from heatlens.model.interpolation import Scale
from heatlens.model.marks import DistanceMark
from heatlens.model.shot import LensParameter, Shot
from heatlens.model.units import format_distance
from heatlens.ui import theme
from heatlens.ui.timeline.curve_handles import Heights, curve_handles
from heatlens.ui.timeline.dope_sheet import draw_keys, hold_keys
from heatlens.ui.timeline.focus_track import Sample
from heatlens.ui.timeline.key_choice import Chosen, KeyId, checked, frames_of, moved
from heatlens.ui.timeline.key_hand import Places
from heatlens.ui.timeline.timeline_scale import TimeScale

if TYPE_CHECKING:
    from heatlens.ui.app import App

_FOCUS = LensParameter.FOCUS_DISTANCE
_LABELS_M = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 7, 10, 20, 50)
_SAMPLE_PX, _ROOM, _SPAN_LEAST = 4.0, 0.12, 0.04
_STILL_PX = 3.0  # a key that is dragged sideways keeps its height so far


def curve_editor(app: "App", scale: TimeScale, corner: ImVec2, height: float) -> None:
    """Draw it from `corner` on, distances left of `scale`, and answer the hand."""
    timeline = app.timeline
    count = max(int(scale.width / _SAMPLE_PX), 2)
    samples = timeline.track.samples(app.shot, scale.first, scale.last, count)
    if timeline.heights is None or not imgui.is_any_item_active():  # else it would run away
        timeline.heights = _ends(app, samples)
    heights = Heights(*timeline.heights, corner.y, height)
    _draw_ground(app, scale, heights, corner)
    _draw_marks(app, scale, heights)
    _draw_curve(scale, heights, samples)
    curve_handles(app, scale, heights)
    places = _places(app.shot, scale, heights)

    def move(shot: Shot, chosen: Chosen, frames: int, up: float) -> tuple[Shot, Chosen]:
        farther = up / heights.per_dioptre if abs(up) > _STILL_PX else 0.0
        return moved(focused_farther(shot, chosen, farther), chosen, frames)

    hold_keys(app, scale, corner.y, height, places, move)
    draw_keys(app, scale, places, corner.y, height)


def focused_farther(shot: Shot, chosen: Chosen, dioptres: float) -> Shot:
    """The chosen keys of the focus by so many dioptres farther, to infinity at most."""
    curve = shot.curves.focus_distance_m
    for frame in frames_of(chosen, _FOCUS) if dioptres else []:
        key = curve.key_at(frame)
        if key is not None:
            value = Scale.RECIPROCAL.value_at(1.0 / key.value - dioptres)
            curve = curve.with_key(replace(key, value=value))
    return checked(shot.with_curve(_FOCUS, curve))


def _ends(app: "App", samples: tuple[Sample, ...]) -> tuple[float, float]:
    """Room for the focus and the marks, and for what is sharp as far as it is near them."""
    places = [sample.focus for sample in samples]
    places += [1.0 / key.value for key in app.shot.curves.focus_distance_m.keys]
    places += [1.0 / m.distance_m for m in app.shot.marks if isinstance(m, DistanceMark)]
    lines = [line for track in app.timeline.mark_tracks() for line in track.lines]
    places += [place for line in lines for _, place in line]
    low, high = min(places), max(places)
    band = max(sample.near - sample.focus for sample in samples)
    span = max(high - low + 2 * min(band, high - low + _SPAN_LEAST), _SPAN_LEAST)
    middle = (low + high) / 2
    low = max(middle - span * (0.5 + _ROOM), 0.0)
    return low, max(middle + span * (0.5 + _ROOM), low + _SPAN_LEAST)


def _places(shot: Shot, scale: TimeScale, heights: Heights) -> Places:
    return {
        KeyId(_FOCUS, key.frame): (scale.x_at(key.frame), heights.y_at(1.0 / key.value))
        for key in shot.curves.focus_distance_m.keys
    }


def _draw_ground(app: "App", scale: TimeScale, heights: Heights, corner: ImVec2) -> None:
    """Distances as far as they have room, with a line each."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    end = ImVec2(scale.x + scale.width, corner.y + heights.height)
    draw.add_rect_filled(ImVec2(scale.x, corner.y), end, theme.GROOVE)
    last_y = corner.y + heights.height + em
    for distance_m in (*_LABELS_M, float("inf")):
        dioptres = 1.0 / distance_m
        y = heights.y_at(dioptres)
        inside = heights.low <= dioptres <= heights.high
        if inside and last_y - y >= 1.1 * em and y <= corner.y + heights.height - 0.5 * em:
            text = format_distance(distance_m, app.view.unit)
            left = scale.x - 0.5 * em - imgui.calc_text_size(text).x
            draw.add_text(ImVec2(left, max(y - 0.5 * em, corner.y)), theme.TEXT_DIM, text)
            draw.add_line(ImVec2(scale.x, y), ImVec2(end.x, y), theme.PLAYED)
            last_y = y


def _corners(scale: TimeScale, heights: Heights) -> tuple[ImVec2, ImVec2]:
    end = ImVec2(scale.x + scale.width, heights.y + heights.height)
    return ImVec2(scale.x, heights.y), end


def _line(scale: TimeScale, heights: Heights, places: Iterable[tuple[float, float]]) -> list[Any]:
    """Points of the screen; a list as ImGui's stubs want it is of no one type."""
    return [ImVec2(scale.x_at(frame), heights.y_at(place)) for frame, place in places]


def _draw_curve(scale: TimeScale, heights: Heights, samples: tuple[Sample, ...]) -> None:
    """The focus, and the band of what is sharp behind it."""
    draw = imgui.get_window_draw_list()
    corner, end = (
        ImVec2(scale.x, heights.y),
        ImVec2(scale.x + scale.width, heights.y + heights.height),
    )
    draw.push_clip_rect(corner, end, True)
    for a, b in pairwise(samples):
        x0, x1 = scale.x_at(a.frame), scale.x_at(b.frame)
        draw.add_quad_filled(
            ImVec2(x0, heights.y_at(a.far)),
            ImVec2(x1, heights.y_at(b.far)),
            ImVec2(x1, heights.y_at(b.near)),
            ImVec2(x0, heights.y_at(a.near)),
            theme.IN_FOCUS_BAND,
        )
    for limit in ("far", "near"):
        places = [(s.frame, getattr(s, limit)) for s in samples]
        draw.add_polyline(_line(scale, heights, places), theme.IN_FOCUS, 1.0, 0)
    places = [(s.frame, s.focus) for s in samples]
    draw.add_polyline(_line(scale, heights, places), theme.ACCENT, 1.8, 0)
    draw.pop_clip_rect()


def _draw_marks(app: "App", scale: TimeScale, heights: Heights) -> None:
    """Where marked things are: at every frame that lies in memory, or always."""
    draw = imgui.get_window_draw_list()
    corner, end = (
        ImVec2(scale.x, heights.y),
        ImVec2(scale.x + scale.width, heights.y + heights.height),
    )
    draw.push_clip_rect(corner, end, True)
    for mark in app.shot.marks:
        if isinstance(mark, DistanceMark):
            y = heights.y_at(1.0 / mark.distance_m)
            draw.add_line(ImVec2(scale.x, y), ImVec2(end.x, y), theme.QUEUED, 1.0)
            draw.add_text(ImVec2(scale.x + 4, y - imgui.get_font_size()), theme.TEXT_DIM, mark.name)
    for track in app.timeline.mark_tracks():
        for line in track.lines:
            draw.add_polyline(_line(scale, heights, line), theme.MARK, 1.5, 0)
            x, y = scale.x_at(line[0][0]), heights.y_at(line[0][1])
            at = ImVec2(max(x, scale.x) + 3, y - imgui.get_font_size())
            draw.add_text(at, theme.MARK, track.name)
    draw.pop_clip_rect()
