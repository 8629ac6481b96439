"""Draw the marks behind the focus curve; a key dragged with Shift goes onto their lines."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.keys.key_choice import KeyId, key_of
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.ui import rects, theme
from heatlens.studio.ui.timeline.curve_axis import CurveAxis
from heatlens.studio.ui.timeline.curve_handles import Heights, Line, corners_of, screen_points
from heatlens.studio.ui.timeline.view import TimeScale

_GRIP_MARGIN_EM = 1.4  # space at the edges for the grip of the selected keys
_NAME_GAP = 0.5  # em


@dataclass(frozen=True)
class MarkSnap:
    """Puts the key that is dragged with Shift onto the line of a mark that is near.

    frames  how many frames the key is moved
    reach   the largest distance of the line, in levels of the axis
    """

    control: TimeControl
    key: KeyId | None
    frames: int
    reach: float

    def level_change(self, shot: Shot, axis: CurveAxis, level_change: float) -> float:
        """Return by how many levels to raise the keys; `shot` is that before the drag."""
        key = None if self.key is None else key_of(shot, self.key)
        if not isinstance(key, Key):
            return level_change
        level = axis.level_of(key.value)
        lines = _levels_of_marks(self.control, key.frame + self.frames)
        nearest = min(lines, key=lambda line: abs(line - (level - level_change)), default=math.inf)
        is_near = abs(nearest - (level - level_change)) <= self.reach
        return level - nearest if is_near else level_change


def _levels_of_marks(control: TimeControl, frame: float) -> list[float]:
    """Return the levels of all marks on the focus axis at a frame, where they are known."""
    marks = control.editing.shot.marks
    levels = [1.0 / mark.distance_m for mark in marks if isinstance(mark, DistanceMark)]
    for track in control.mark_tracks():
        for line in track.lines:
            frames, line_levels = zip(*line, strict=True)
            if frames[0] <= frame <= frames[-1]:
                levels.append(float(np.interp(frame, frames, line_levels)))
    return levels


def mark_levels(control: TimeControl) -> list[float]:
    """Return the distances of all marks at all known frames, as levels of the focus axis."""
    marks = control.editing.shot.marks
    levels = [1.0 / mark.distance_m for mark in marks if isinstance(mark, DistanceMark)]
    lines = [line for track in control.mark_tracks() for line in track.lines]
    return levels + [level for line in lines for _, level in line]


def draw_marks(control: TimeControl, scale: TimeScale, heights: Heights) -> None:
    """Draw the distances of the marks: fixed ones as lines, others at the known frames."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    corner, end = corners_of(scale, heights)
    names = _NameDrawer(corner.y)
    draw.push_clip_rect(corner, end, True)
    lines: list[tuple[str, Line]] = []
    for track in control.mark_tracks():
        for line_before in track.lines[:-1]:
            draw.add_polyline(
                [*screen_points(scale, heights, line_before)], theme.colors.mark, 0.1 * em, 0
            )
        lines += [(track.name, line) for line in track.lines[-1:]]
        for bridge in track.bridges:
            _draw_dashes(screen_points(scale, heights, bridge), 0.5 * em)
    for mark in control.editing.shot.marks:
        if isinstance(mark, DistanceMark):
            level = 1.0 / mark.distance_m
            lines.append((mark.name, ((scale.first, level), (scale.last, level))))
    for name, line in sorted(lines, key=lambda named_line: named_line[1][-1][1]):
        draw.add_polyline([*screen_points(scale, heights, line)], theme.colors.mark, 0.1 * em, 0)
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
