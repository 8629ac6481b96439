"""Draw the Bezier handles of a curve, which the user drags to bend it between two keys."""

from collections.abc import Collection
from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, imgui

from heatlens.base.errors import HeatlensError
from heatlens.model.curve import Curve, Key
from heatlens.model.interpolation import Ease, Interpolation, Scale
from heatlens.session.desks import TimeDesk
from heatlens.session.keys.key_choice import checked, frames_of
from heatlens.session.loop.messages import Problem
from heatlens.ui import probe, theme
from heatlens.ui.timeline.curve_axis import CurveAxis
from heatlens.ui.timeline.scale import TimeScale

_TIP_EM = 0.3


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
        place = min(max(place, self.low), self.high)
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
    draw, side = imgui.get_window_draw_list(), _TIP_EM * imgui.get_font_size()
    curve_scale = desk.editing.shot.curves.of(axis.parameter).scale
    frame, place = handle.tip(curve_scale)
    tip = ImVec2(scale.x_at(frame), heights.y_at(axis.from_scale(place, curve_scale)))
    imgui.set_cursor_screen_pos(ImVec2(tip.x - 2 * side, tip.y - 2 * side))
    imgui.invisible_button(handle.name, ImVec2(4 * side, 4 * side))
    probe.note(handle.name)
    if imgui.is_item_activated():
        desk.editing.settle()
    is_held = imgui.is_item_active()
    if is_held and imgui.is_mouse_dragging(imgui.MouseButton_.left, 1.0):
        mouse = imgui.get_mouse_pos()
        _pull(desk, axis, handle, scale.time_at(mouse.x), heights.place_at(mouse.y))
    color = theme.colors.accent if is_held or imgui.is_item_hovered() else theme.colors.key
    y = heights.y_at(axis.place_of(handle.key.value))
    draw.add_line(ImVec2(scale.x_at(handle.key.frame), y), tip, theme.colors.queued, 1.0)
    draw.add_circle_filled(tip, side, color)


def _pull(desk: TimeDesk, axis: CurveAxis, handle: Handle, frame: float, place: float) -> None:
    curve = desk.editing.shot.curves.of(axis.parameter)
    pulled = handle.pulled_to(frame, axis.to_scale(place, curve.scale), curve.scale)
    try:
        desk.editing.edit(
            checked(desk.editing.shot.with_curve(axis.parameter, curve.with_key(pulled)))
        )
    except HeatlensError as error:
        desk.say(Problem(error))
