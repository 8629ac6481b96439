"""Draw a row with key diamonds for each lens parameter and for the camera.

Grips at both ends of the chosen keys stretch a pull in time.
"""

from collections.abc import Mapping

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.curves.curve import SAME_FRAME
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.desks import TimeDesk
from heatlens.studio.session.keys.key_choice import Chosen, KeyId, key_of, moved
from heatlens.studio.session.keys.key_drag import KeyDrag, KeyStretch, Move, Places
from heatlens.studio.session.keys.key_rows import CAMERA, Row, key_frames, shown_rows
from heatlens.studio.ui import probe, theme, widgets
from heatlens.studio.ui.probe import Rect
from heatlens.studio.ui.timeline.view import TimelineView, TimeScale

_ROW_EM, _ROW_LEAST_EM = 1.45, 1.1  # height of a row, and the least height
_KEY_EM, _REACH_EM = 0.42, 0.55
_LEFT_EM, _RIGHT_EM = 1.1, 0.3  # room for the dot left of the name, and for a gap to the keys


def _draw_row(desk: TimeDesk, scale: TimeScale, row: Row, corner: ImVec2, height: float) -> None:
    """Draw dot, name and ground of a row at `corner`; the keys of all rows are drawn later."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    key_dot(desk, row, ImVec2(corner.x + 0.5 * em, corner.y + height / 2), f"dot {row}")
    _row_name(desk, row, ImVec2(corner.x + _LEFT_EM * em, corner.y), scale.x, height)
    is_keyed = bool(key_frames(desk.editing.shot, row))
    color = theme.colors.handle if is_keyed else theme.colors.text_dim
    draw.add_text(ImVec2(corner.x + 1.3 * em, corner.y + (height - em) / 2), color, row.words)
    end = ImVec2(scale.x + scale.width, corner.y + height - 2)
    draw.add_rect_filled(ImVec2(scale.x, corner.y), end, theme.colors.groove)


def _row_name(desk: TimeDesk, row: Row, corner: ImVec2, keys_x: float, height: float) -> None:
    """Draw the ground of a row's name, lighter for the selected row; a click selects it."""
    size = ImVec2(max(keys_x - _RIGHT_EM * imgui.get_font_size() - corner.x, 1.0), height - 2)
    tip = f"Click to select: Shift+C then shows the curve of the {row.words}"
    if row is CAMERA:
        tip = "Click to select the camera: K then sets its key"
    if widgets.area(f"row {row}", corner, size, tip):
        desk.keys.rows.choose(row)
    if desk.keys.rows.chosen is row:
        end = ImVec2(corner.x + size.x, corner.y + size.y)
        imgui.get_window_draw_list().add_rect_filled(corner, end, theme.colors.played, 3.0)


def diamond(middle: ImVec2, reach: float) -> tuple[ImVec2, ImVec2, ImVec2, ImVec2]:
    """Return the corners of a diamond, `reach` from its middle, in screen units."""
    x, y = middle.x, middle.y
    top, bottom = ImVec2(x, y - reach), ImVec2(x, y + reach)
    return top, ImVec2(x + reach, y), bottom, ImVec2(x - reach, y)


def dope_sheet(
    desk: TimeDesk, view: TimelineView, scale: TimeScale, corner: ImVec2, height: float
) -> None:
    """Draw the rows at `corner`, their names left of `scale`, and apply drags of keys."""
    rows = shown_rows(desk.editing.shot, desk.keys.rows.has_camera)
    strip = GRIPS_EM * imgui.get_font_size()  # below the rows, so that no key lies under a grip
    row = _row_height(height - strip, len(rows))
    height = max(height, len(rows) * row + strip)
    for index, it in enumerate(rows):
        _draw_row(desk, scale, it, ImVec2(corner.x, corner.y + index * row), row)
    places = _places(desk.editing.shot, rows, scale, corner.y, row)
    stretch_grips(view.stretch, scale, corner.y, height)
    hold_keys(view.drag, scale, corner.y, height, places, _move)
    draw_keys(desk, view.drag, scale, places, corner.y, height)


def _row_height(height: float, count: int) -> float:
    """Return the height of one of `count` rows; the panel scrolls if even the lowest do not fit."""
    em = imgui.get_font_size()
    return min(_ROW_EM * em, max(_ROW_LEAST_EM * em, height / count))


def _move(shot: Shot, chosen: Chosen, frames: int, _up: float) -> tuple[Shot, Chosen]:
    return moved(shot, chosen, frames)


def hold_keys(
    drag: KeyDrag, scale: TimeScale, y: float, height: float, places: Places, move: Move
) -> None:
    """Draw the invisible button in which keys are clicked and dragged, and apply the mouse."""
    io, em = imgui.get_io(), imgui.get_font_size()
    widgets.area("keys", ImVec2(scale.x, y), ImVec2(scale.width, max(height, 1.0)))
    for (key_row, frame), (x, key_y) in places.items():
        probe.note_at(f"key {key_row} {frame:g}", (x, key_y, x, key_y))
    mouse = io.mouse_pos.x, io.mouse_pos.y
    if imgui.is_item_activated():
        drag.press(mouse, places, _REACH_EM * em, io.key_shift, io.key_ctrl)
    elif imgui.is_item_active():
        drag.drag(mouse, places, scale.per_frame, move)
    elif drag.is_holding:
        drag.release()


def _places(
    shot: Shot, rows: tuple[Row, ...], scale: TimeScale, y: float, row_height: float
) -> Places:
    return {
        KeyId(row, frame): (scale.x_at(frame), y + (index + 0.5) * row_height)
        for index, row in enumerate(rows)
        for frame in key_frames(shot, row)
    }


def key_dot(desk: TimeDesk, row: Row, middle: ImVec2, name: str) -> None:
    """Draw the dot of a row; a click sets or removes its key at the playhead.

    It is filled if there is a key at the playhead, and hollow if there are keys elsewhere.
    """
    side, frames = 0.5 * imgui.get_font_size(), key_frames(desk.editing.shot, row)
    corner, size = ImVec2(middle.x - side, middle.y - side), ImVec2(2 * side, 2 * side)
    if widgets.area(name, corner, size, f"Key of the {row.words} at this frame"):
        desk.toggle_key(row)
    draw = imgui.get_window_draw_list()
    color = theme.colors.key if frames else theme.colors.queued
    if any(abs(frame - desk.editing.frame) < SAME_FRAME for frame in frames):
        draw.add_quad_filled(*diamond(middle, 0.6 * side), color)
    else:
        draw.add_quad(*diamond(middle, 0.6 * side), color, 1.2)


def draw_keys(
    desk: TimeDesk, drag: KeyDrag, scale: TimeScale, places: Places, y: float, height: float
) -> None:
    """Draw keys as diamonds (squares for hold interpolation) and the selection box."""
    draw, chosen, io = imgui.get_window_draw_list(), desk.keys.chosen, imgui.get_io()
    reach = _KEY_EM * imgui.get_font_size()
    edge = ImVec2(scale.x - reach, y)
    draw.push_clip_rect(edge, ImVec2(scale.x + scale.width + reach, y + height), True)
    for key, place in places.items():
        color = theme.colors.handle if key in chosen else theme.colors.key
        _draw_key(desk.editing.shot, key, ImVec2(*place), reach, color)
    begin = drag.box_from
    if begin is not None:
        draw.add_rect_filled(ImVec2(*begin), io.mouse_pos, theme.colors.box)
        draw.add_rect(ImVec2(*begin), io.mouse_pos, theme.colors.queued)
    draw.pop_clip_rect()


def _draw_key(shot: Shot, key: KeyId, middle: ImVec2, reach: float, color: int) -> None:
    draw, drawn = imgui.get_window_draw_list(), key_of(shot, key)
    if drawn is not None and drawn.interpolation is Interpolation.HOLD:
        side = 0.75 * reach
        low = ImVec2(middle.x - side, middle.y - side)
        draw.add_rect_filled(low, ImVec2(middle.x + side, middle.y + side), color)
    else:
        draw.add_quad_filled(*diamond(middle, reach), color)
        draw.add_quad(*diamond(middle, reach), theme.colors.shadow, 1.0)


def lens_dots(desk: TimeDesk, drawn: Mapping[str, Rect]) -> None:
    """Draw the key dots beside the controls of the Lens panel, whose rectangles are `drawn`."""
    for parameter in LensParameter:
        at = drawn.get(parameter.control)
        if at is not None:
            x = at[0] - 0.65 * imgui.get_font_size()
            key_dot(desk, parameter, ImVec2(x, (at[1] + at[3]) / 2), f"lens dot {parameter}")


_WIDTH_EM, _HEIGHT_EM, _GAP_EM = 0.5, 1.3, 0.55
GRIPS_EM = _HEIGHT_EM + 0.2  # height of the strip that the grips need


# The grips lie below the rows of keys. Within them, five rows at the height that the timeline has
# at first left no room: the grips and their number of frames lay over the row of the camera.
def stretch_grips(stretch: KeyStretch, scale: TimeScale, y: float, height: float) -> None:
    """Draw the grips at the bottom of the area of keys; call this before that area's button."""
    ends = stretch.ends
    if ends is None:
        return
    em = imgui.get_font_size()
    top = y + max(height - GRIPS_EM * em, 0.0)
    for name, frame, is_last in (("first", ends.first, False), ("last", ends.last, True)):
        left = scale.x_at(frame) + (_GAP_EM if is_last else -_GAP_EM - _WIDTH_EM) * em
        left = min(max(left, scale.x), scale.x + scale.width - _WIDTH_EM * em)
        _grip(stretch, scale, f"stretch {name}", ImVec2(left, top), is_last)
    words = f"{ends.last - ends.first:g} frames"
    x0, x1 = scale.x_at(ends.first), scale.x_at(ends.last)
    width = imgui.calc_text_size(words).x
    if x1 - x0 > width + em and scale.x < x0 and x1 < scale.x + scale.width:
        at, draw = ImVec2((x0 + x1 - width) / 2, top + 0.15 * em), imgui.get_window_draw_list()
        low = ImVec2(at.x - 0.3 * em, at.y)  # own background, to be legible over a curve
        draw.add_rect_filled(low, ImVec2(at.x + width + 0.3 * em, at.y + em), theme.colors.groove)
        draw.add_text(at, theme.colors.text_dim, words)


def _grip(stretch: KeyStretch, scale: TimeScale, name: str, corner: ImVec2, is_last: bool) -> None:
    em = imgui.get_font_size()
    size = ImVec2(_WIDTH_EM * em, _HEIGHT_EM * em)
    widgets.area(name, corner, size, "Drag to stretch or shorten the chosen keys")
    is_lit = imgui.is_item_hovered() or imgui.is_item_active()
    if is_lit:
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
    if imgui.is_item_activated():
        stretch.press(is_last)
    elif imgui.is_item_active():
        gap = (_GAP_EM + _WIDTH_EM / 2) * em
        stretch.drag(scale.frame_at(imgui.get_mouse_pos().x - (gap if is_last else -gap)))
    elif imgui.is_item_deactivated():
        stretch.release()
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    draw.add_rect_filled(corner, end, theme.colors.handle if is_lit else theme.colors.key, 2.0)
