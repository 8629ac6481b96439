"""Draw the Bezier handles of a curve, which the user drags to bend it between two keys."""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from heatlens.studio.session.desks import TimeDesk
from heatlens.studio.session.keys.key_choice import checked, frames_of
from heatlens.studio.session.messages import reported
from heatlens.studio.ui import theme, widgets
from heatlens.studio.ui.timeline.curve_axis import CurveAxis
from heatlens.studio.ui.timeline.view import TimeScale

_TIP_EM, _CATCH_EM = 0.36, 0.9  # radius of a tip, and of the circle in which it is caught
_LEAST_EM = 1.7  # least distance of a tip from its key on the screen, so that both can be caught


@dataclass(frozen=True)
class Heights:
    """Maps places of an axis to the screen: `low` is at the top, `high` at the bottom."""

    low: float
    high: float
    y: float
    height: float

    @property
    def per_place(self) -> float:
        """Screen units for one place."""
        return self.height / (self.high - self.low)

    def y_at(self, place: float) -> float:
        """Return the y of a place, limited to the height of the editor."""
        return self.line_y(min(max(place, self.low), self.high))

    def line_y(self, place: float) -> float:
        """Return the y of a place, which may lie outside the editor."""
        return self.y + (place - self.low) * self.per_place

    def place_at(self, y: float) -> float:
        """Return the place at a screen position y."""
        return self.low + (y - self.y) / self.per_place


@dataclass(frozen=True)
class Handle:
    """One of a key's two handles; `segment` is the distance to the next key, in frames."""

    key: Key
    is_out: bool
    segment: float

    @property
    def name(self) -> str:
        """The name of its ImGui button."""
        return f"handle {'out' if self.is_out else 'in'} {self.key.frame:g}"

    @property
    def _sign(self) -> int:
        return 1 if self.is_out else -1

    def tip(self, scale: Scale) -> tuple[float, float]:
        """Return the position of its tip: frame, and value on the curve's own scale."""
        ease = self.key.ease_out if self.is_out else self.key.ease_in
        frames, rise = ease.handle(self.segment)
        place = scale.place_of(self.key.value) + self._sign * rise
        return self.key.frame + self._sign * frames, place

    def pulled_to(self, frame: float, place: float, scale: Scale) -> Key:
        """Return the key as it is when the tip is dragged to that position."""
        rise = self._sign * (place - scale.place_of(self.key.value))
        ease = Ease.of_handle(self._sign * (frame - self.key.frame), rise, self.segment)
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
            handles.append(Handle(key, True, keys[index + 1].frame - key.frame))
        if index > 0 and keys[index - 1].interpolation is bezier:
            handles.append(Handle(key, False, key.frame - keys[index - 1].frame))
    return handles


def curve_handles(desk: TimeDesk, axis: CurveAxis, scale: TimeScale, heights: Heights) -> None:
    """Draw the handles of the chosen keys; a dragged tip follows the pointer."""
    frames = frames_of(desk.keys.chosen, axis.parameter)
    for handle in handles_of(desk.editing.shot.curves.of(axis.parameter), frames):
        _handle(desk, axis, handle, scale, heights)


def _handle(
    desk: TimeDesk, axis: CurveAxis, handle: Handle, scale: TimeScale, heights: Heights
) -> None:
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    reach = _CATCH_EM * em
    curve_scale = desk.editing.shot.curves.of(axis.parameter).scale
    frame, place = handle.tip(curve_scale)
    key = scale.x_at(handle.key.frame), heights.y_at(axis.place_of(handle.key.value))
    at = scale.x_at(frame), heights.y_at(axis.from_scale(place, curve_scale))
    tip = ImVec2(*_apart(key, at, _LEAST_EM * em, 1 if handle.is_out else -1))
    corner = ImVec2(tip.x - reach, tip.y - reach)
    widgets.area(handle.name, corner, ImVec2(2 * reach, 2 * reach))
    if imgui.is_item_activated():
        desk.editing.settle()
    is_held = imgui.is_item_active()
    if is_held and imgui.is_mouse_dragging(imgui.MouseButton_.left, 1.0):
        mouse = imgui.get_mouse_pos()
        _pull(desk, axis, handle, scale.time_at(mouse.x), heights.place_at(mouse.y))
    is_lit = is_held or imgui.is_item_hovered()
    draw.add_line(ImVec2(*key), tip, theme.colors.mark, 0.067 * em)
    draw.add_circle_filled(tip, _TIP_EM * em, theme.colors.handle if is_lit else theme.colors.mark)


def _apart(
    key: tuple[float, float], at: tuple[float, float], least: float, side: int
) -> tuple[float, float]:
    """Return where a tip is drawn that lies `at`: in the same direction, not too near its key."""
    across, down = at[0] - key[0], at[1] - key[1]
    length = math.hypot(across, down)
    if length >= least:
        return at
    if length < 1.0:
        return key[0] + side * least, key[1]
    return key[0] + across * least / length, key[1] + down * least / length


def _pull(desk: TimeDesk, axis: CurveAxis, handle: Handle, frame: float, place: float) -> None:
    curve = desk.editing.shot.curves.of(axis.parameter)
    pulled = handle.pulled_to(frame, axis.to_scale(place, curve.scale), curve.scale)
    with reported(desk.say):
        desk.editing.edit(
            checked(desk.editing.shot.with_curve(axis.parameter, curve.with_key(pulled)))
        )
