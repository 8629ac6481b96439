"""Draw the Bezier handles of a curve, which the user drags to bend it between two keys."""

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.messages import report_errors
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from heatlens.core.model.keys.key_choice import check_shot, frames_of
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.ui import rects, theme, widgets
from heatlens.studio.ui.timeline.curve_axis import CurveAxis
from heatlens.studio.ui.timeline.view import TimeScale

_TIP_EM, _REACH_EM = 0.36, 0.9  # radius of a tip, and of the circle in which it can be clicked
_VALUE_RISE_EM = 1.6  # how far above a key its value is drawn
Line = Sequence[tuple[float, float]]  # (frame, level on the axis)
_MIN_LENGTH_EM = 1.7  # smallest distance of a tip from its key, so that both can be clicked


@dataclass(frozen=True)
class Heights:
    """Maps levels of an axis to the screen, from `top_level` to `bottom_level`.

    `y` and `height` are the top and the height of the editor in screen units.
    """

    top_level: float
    bottom_level: float
    y: float
    height: float

    @property
    def px_per_level(self) -> float:
        """Screen units per level of the axis."""
        return self.height / (self.bottom_level - self.top_level)

    def y_at(self, level: float) -> float:
        """Return the y of a level, limited to the height of the editor."""
        return self.line_y(min(max(level, self.top_level), self.bottom_level))

    def line_y(self, level: float) -> float:
        """Return the y of a level, which may lie outside the editor."""
        return self.y + (level - self.top_level) * self.px_per_level

    def level_at(self, y: float) -> float:
        """Return the level at a screen position y."""
        return self.top_level + (y - self.y) / self.px_per_level


def corners_of(scale: TimeScale, heights: Heights) -> tuple[ImVec2, ImVec2]:
    """Return the top left and the bottom right corner of the curves' area."""
    end = ImVec2(scale.x + scale.width, heights.y + heights.height)
    return ImVec2(scale.x, heights.y), end


def screen_points(
    scale: TimeScale, heights: Heights, levels: Iterable[tuple[float, float]]
) -> Iterator[ImVec2]:
    """Return the screen positions of points (frame, level)."""
    return (ImVec2(scale.x_at(frame), heights.line_y(level)) for frame, level in levels)


@dataclass(frozen=True)
class Handle:
    """One of a key's two handles; `segment_frames` is the distance to the next key."""

    key: Key
    is_out: bool
    segment_frames: float

    @property
    def name(self) -> str:
        """The name of its ImGui button."""
        return f"handle {'out' if self.is_out else 'in'} {self.key.frame:g}"

    @property
    def _sign(self) -> int:
        return 1 if self.is_out else -1

    def ease_of(self, key: Key) -> Ease:
        """Return the ease of a key on the side of this handle."""
        return key.ease_out if self.is_out else key.ease_in

    def tip(self, scale: Scale) -> tuple[float, float]:
        """Return the position of the tip: frame, and value on the curve's own scale."""
        frames, rise = self.ease_of(self.key).handle(self.segment_frames)
        level = scale.position_of(self.key.value) + self._sign * rise
        return self.key.frame + self._sign * frames, level

    def with_tip_at(self, frame: float, level: float, scale: Scale) -> Key:
        """Return the key with its handle changed so that the tip is at that position."""
        rise = self._sign * (level - scale.position_of(self.key.value))
        ease = Ease.of_handle(self._sign * (frame - self.key.frame), rise, self.segment_frames)
        if self.is_out:
            return replace(self.key, ease_out=ease)
        return replace(self.key, ease_in=ease)


def handles_of(curve: Curve, frames: Collection[float]) -> list[Handle]:
    """Return the handles of keys that have a Bezier segment on that side."""
    keys, handles, bezier = curve.keys, [], Interpolation.BEZIER
    for index, key in enumerate(keys):
        if key.frame not in frames:
            continue
        if index + 1 < len(keys) and key.interpolation is bezier:
            handles.append(
                Handle(key, is_out=True, segment_frames=keys[index + 1].frame - key.frame)
            )
        if index > 0 and keys[index - 1].interpolation is bezier:
            handles.append(
                Handle(key, is_out=False, segment_frames=key.frame - keys[index - 1].frame)
            )
    return handles


def draw_handles(control: TimeControl, axis: CurveAxis, scale: TimeScale, heights: Heights) -> None:
    """Draw the handles of the chosen keys; a dragged tip follows the pointer."""
    frames = frames_of(control.keys.selection, axis.parameter)
    for handle in handles_of(control.editing.shot.curves.of(axis.parameter), frames):
        _draw_handle(control, axis, handle, scale, heights)


def _draw_handle(
    control: TimeControl, axis: CurveAxis, handle: Handle, scale: TimeScale, heights: Heights
) -> None:
    """Draw a handle, and change its key while the tip is dragged."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    reach = _REACH_EM * em
    curve_scale = control.editing.shot.curves.of(axis.parameter).scale
    frame, level = handle.tip(curve_scale)
    key = scale.x_at(handle.key.frame), heights.y_at(axis.level_of(handle.key.value))
    tip_position = scale.x_at(frame), heights.y_at(axis.from_scale(level, curve_scale))
    tip = ImVec2(*_keep_apart(key, tip_position, _MIN_LENGTH_EM * em, 1 if handle.is_out else -1))
    corner = ImVec2(tip.x - reach, tip.y - reach)
    widgets.invisible_button(handle.name, corner, ImVec2(2 * reach, 2 * reach))
    if imgui.is_item_activated():
        control.editing.settle()
    is_dragged = imgui.is_item_active()
    if is_dragged and imgui.is_mouse_dragging(imgui.MouseButton_.left, 1.0):
        mouse = imgui.get_mouse_pos()
        _drag_tip(control, axis, handle, scale.time_at(mouse.x), heights.level_at(mouse.y))
    if is_dragged:
        dragged_key = control.editing.shot.curves.of(axis.parameter).key_at(handle.key.frame)
        ease = None if dragged_key is None else handle.ease_of(dragged_key)
        words = "" if ease is None else f"{ease.influence_percent:.0f} %"
        draw_value_beside(words, "handle", (tip.x, tip.y), scale, heights.y)
    is_bright = is_dragged or imgui.is_item_hovered()
    draw.add_line(ImVec2(*key), tip, theme.colors.mark, 0.067 * em)
    draw.add_circle_filled(
        tip, _TIP_EM * em, theme.colors.handle if is_bright else theme.colors.mark
    )


def draw_value_beside(
    words: str, subject: str, position: tuple[float, float], scale: TimeScale, top: float
) -> None:
    """Draw words in a box beside what is dragged; `top` is the upper edge of the editor.

    They are above it, or below it at the upper edge, since the pointer covers what is beside it.
    """
    em, (x, y) = imgui.get_font_size(), position
    width = imgui.calc_text_size(words).x + 0.6 * em
    x += -0.7 * em - width if x + 0.7 * em + width > scale.x + scale.width else 0.7 * em
    y += em * (-_VALUE_RISE_EM if y - (_VALUE_RISE_EM + 0.6) * em > top else 1.5 * _VALUE_RISE_EM)
    corner, end = ImVec2(x, y - 0.6 * em), ImVec2(x + width, y + 0.6 * em)
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled(corner, end, theme.colors.mark, 3.0)
    draw.add_text(ImVec2(x + 0.3 * em, y - 0.5 * em), theme.colors.on_accent, words)
    rects.note_at(f"value beside the {subject}", (corner.x, corner.y, end.x, end.y))


def _keep_apart(
    key: tuple[float, float], tip: tuple[float, float], min_length: float, side: int
) -> tuple[float, float]:
    """Return where to draw a tip: in its direction, at least `min_length` from its key.

    A tip on its key is drawn at its right (`side` 1) or left (-1).
    """
    across, down = tip[0] - key[0], tip[1] - key[1]
    length = math.hypot(across, down)
    if length >= min_length:
        return tip
    if length < 1.0:
        return key[0] + side * min_length, key[1]
    return key[0] + across * min_length / length, key[1] + down * min_length / length


def _drag_tip(
    control: TimeControl, axis: CurveAxis, handle: Handle, frame: float, level: float
) -> None:
    """Change a key so that the tip of its handle is at a frame and a level of the axis."""
    curve = control.editing.shot.curves.of(axis.parameter)
    new_key = handle.with_tip_at(frame, axis.to_scale(level, curve.scale), curve.scale)
    with report_errors(control.notify):
        control.editing.edit(
            check_shot(control.editing.shot.with_curve(axis.parameter, curve.with_key(new_key)))
        )
