"""Draw a row with key diamonds for each lens parameter and for the camera.

Grips at both ends of the chosen keys stretch a pull in time.
"""

from collections.abc import Mapping

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.curves.key_edits import SAME_FRAME
from heatlens.core.model.keys.key_choice import KeyId, KeySelection, key_of, move_keys
from heatlens.core.model.keys.key_rows import CAMERA, Row, key_frames, shown_rows
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.board.key_drag import KeyDrag, KeyPositions, KeyStretch, Move
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.rects import Rect
from heatlens.studio.ui.timeline.view import TimelineView, TimeScale

_NO_KEY = "K sets the first key of the focus here."
_ROW_EM, _MIN_ROW_EM = 1.45, 1.1  # height of a row, and the least height
_KEY_EM, _REACH_EM = 0.42, 0.55
_LEFT_EM, _RIGHT_EM = 1.1, 0.3  # room for the dot left of the name, and for a gap to the keys


def _draw_row(
    control: TimeControl, scale: TimeScale, row: Row, corner: ImVec2, height: float
) -> None:
    """Draw dot, name and background of a row; the keys of all rows are drawn later."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    key_dot(control, row, ImVec2(corner.x + 0.5 * em, corner.y + height / 2), f"dot {row}")
    _draw_row_name(control, row, ImVec2(corner.x + _LEFT_EM * em, corner.y), scale.x, height)
    is_keyed = bool(key_frames(control.editing.shot, row))
    color = theme.colors.handle if is_keyed else theme.colors.text_dim
    draw.add_text(ImVec2(corner.x + 1.3 * em, corner.y + (height - em) / 2), color, row.words)
    end = ImVec2(scale.x + scale.width, corner.y + height - 2)
    draw.add_rect_filled(ImVec2(scale.x, corner.y), end, theme.colors.groove)


def _draw_row_name(
    control: TimeControl, row: Row, corner: ImVec2, keys_x: float, height: float
) -> None:
    """Draw the background of a row's name if the row is selected; a click selects it."""
    size = ImVec2(max(keys_x - _RIGHT_EM * imgui.get_font_size() - corner.x, 1.0), height - 2)
    tip = f"Click to select: Shift+C then shows the curve of the {row.words}"
    if row is CAMERA:
        tip = "Click to select the camera: K then sets its key"
    if widgets.invisible_button(f"row {row}", corner, size, tip):
        control.keys.rows.select(row)
    if control.keys.rows.selected_row is row:
        end = ImVec2(corner.x + size.x, corner.y + size.y)
        imgui.get_window_draw_list().add_rect_filled(corner, end, theme.colors.played, 3.0)


def diamond_corners(center: ImVec2, reach: float) -> tuple[ImVec2, ImVec2, ImVec2, ImVec2]:
    """Return the corners of a diamond, `reach` from its middle, in screen units."""
    x, y = center.x, center.y
    top, bottom = ImVec2(x, y - reach), ImVec2(x, y + reach)
    return top, ImVec2(x + reach, y), bottom, ImVec2(x - reach, y)


def dope_sheet(
    control: TimeControl, view: TimelineView, scale: TimeScale, corner: ImVec2, height: float
) -> None:
    """Draw the rows at `corner`, their names left of `scale`, and apply drags of keys."""
    rows = shown_rows(control.editing.shot, control.keys.rows.has_camera)
    if len(rows) == 1 and not control.timeline.key_frames:  # there is nothing to choose or to move
        words = texts.named_keys(_NO_KEY)
        x = scale.x + max(scale.width - texts.text_width(words), 0.0) / 2  # off the first frame
        imgui.set_cursor_screen_pos(ImVec2(x, corner.y))
        imgui.text_disabled(words)
        return
    # Below the rows, so that no key lies under a grip.
    grips_height = GRIPS_EM * imgui.get_font_size()
    row_height = _row_height(height - grips_height, len(rows))
    height = max(height, len(rows) * row_height + grips_height)
    for index, sheet_row in enumerate(rows):
        _draw_row(
            control, scale, sheet_row, ImVec2(corner.x, corner.y + index * row_height), row_height
        )
    key_positions = _key_positions(control.editing.shot, rows, scale, corner.y, row_height)
    stretch_grips(view.stretch, scale, corner.y, height)
    handle_key_drag(view.drag, scale, corner.y, height, key_positions, _move_in_time)
    draw_keys(control, view.drag, scale, key_positions, corner.y, height)


def _row_height(height: float, count: int) -> float:
    """Return the height of one of `count` rows; the panel scrolls if the rows do not fit."""
    em = imgui.get_font_size()
    return min(_ROW_EM * em, max(_MIN_ROW_EM * em, height / count))


def _move_in_time(
    shot: Shot, selection: KeySelection, frames: int, _up: float
) -> tuple[Shot, KeySelection]:
    """Move the selected keys by a number of frames; a row has no vertical axis."""
    return move_keys(shot, selection, frames)


def handle_key_drag(
    drag: KeyDrag,
    scale: TimeScale,
    y: float,
    height: float,
    key_positions: KeyPositions,
    move: Move,
) -> None:
    """Draw the invisible button in which keys are clicked and dragged, and apply the mouse."""
    io, em = imgui.get_io(), imgui.get_font_size()
    widgets.invisible_button("keys", ImVec2(scale.x, y), ImVec2(scale.width, max(height, 1.0)))
    for (key_row, frame), (x, key_y) in key_positions.items():
        rects.note_at(f"key {key_row} {frame:g}", (x, key_y, x, key_y))
    mouse = io.mouse_pos.x, io.mouse_pos.y
    if imgui.is_item_activated():
        drag.press(mouse, key_positions, _REACH_EM * em, io.key_shift, io.key_ctrl)
    elif imgui.is_item_active():
        drag.drag(mouse, key_positions, scale.px_per_frame, move)
    elif drag.is_dragging:
        drag.release()


def _key_positions(
    shot: Shot, rows: tuple[Row, ...], scale: TimeScale, y: float, row_height: float
) -> KeyPositions:
    """Return the screen positions of the keys of all rows."""
    return {
        KeyId(row, frame): (scale.x_at(frame), y + (index + 0.5) * row_height)
        for index, row in enumerate(rows)
        for frame in key_frames(shot, row)
    }


def key_dot(control: TimeControl, row: Row, center: ImVec2, name: str) -> None:
    """Draw the dot of a row; a click sets or removes its key at the playhead.

    The dot is filled if there is a key at the playhead, else hollow; it has the color of keys if
    the row has any.
    """
    half_side, frames = 0.5 * imgui.get_font_size(), key_frames(control.editing.shot, row)
    corner = ImVec2(center.x - half_side, center.y - half_side)
    size = ImVec2(2 * half_side, 2 * half_side)
    if widgets.invisible_button(name, corner, size, f"Key of the {row.words} at this frame"):
        control.toggle_key(row)
    draw = imgui.get_window_draw_list()
    color = theme.colors.key if frames else theme.colors.queued
    if any(abs(frame - control.editing.frame) < SAME_FRAME for frame in frames):
        draw.add_quad_filled(*diamond_corners(center, 0.6 * half_side), color)
    else:
        draw.add_quad(*diamond_corners(center, 0.6 * half_side), color, 1.2)


def draw_keys(
    control: TimeControl,
    drag: KeyDrag,
    scale: TimeScale,
    key_positions: KeyPositions,
    y: float,
    height: float,
) -> None:
    """Draw keys as diamonds (squares for hold interpolation) and the selection box."""
    draw, selection, io = imgui.get_window_draw_list(), control.keys.selection, imgui.get_io()
    reach = _KEY_EM * imgui.get_font_size()
    clip_corner = ImVec2(scale.x - reach, y)
    draw.push_clip_rect(clip_corner, ImVec2(scale.x + scale.width + reach, y + height), True)
    for key, position in key_positions.items():
        color = theme.colors.handle if key in selection else theme.colors.key
        _draw_key(control.editing.shot, key, ImVec2(*position), reach, color)
    box_corner = drag.box_corner
    if box_corner is not None:
        draw.add_rect_filled(ImVec2(*box_corner), io.mouse_pos, theme.colors.box)
        draw.add_rect(ImVec2(*box_corner), io.mouse_pos, theme.colors.queued)
    draw.pop_clip_rect()


def _draw_key(shot: Shot, key: KeyId, center: ImVec2, reach: float, color: int) -> None:
    """Draw a key as a diamond, or as a square for hold interpolation."""
    draw, curve_key = imgui.get_window_draw_list(), key_of(shot, key)
    if curve_key is not None and curve_key.interpolation is Interpolation.HOLD:
        half_side = 0.75 * reach
        corner = ImVec2(center.x - half_side, center.y - half_side)
        draw.add_rect_filled(corner, ImVec2(center.x + half_side, center.y + half_side), color)
    else:
        draw.add_quad_filled(*diamond_corners(center, reach), color)
        draw.add_quad(*diamond_corners(center, reach), theme.colors.shadow, 1.0)


def lens_dots(control: TimeControl, control_rects: Mapping[str, Rect], is_pointed_at: bool) -> None:
    """Draw the key dots beside the controls of the Lens panel, given their rectangles by name.

    A parameter without keys has its dot only while the pointer is over the panel.
    """
    for parameter in LensParameter:
        rect = control_rects.get(parameter.control)
        is_shown = is_pointed_at or key_frames(control.editing.shot, parameter)
        if rect is not None and is_shown:
            x = rect[0] - 0.65 * imgui.get_font_size()
            key_dot(control, parameter, ImVec2(x, (rect[1] + rect[3]) / 2), f"lens dot {parameter}")


_WIDTH_EM, _HEIGHT_EM, _GAP_EM = 0.5, 1.3, 0.55
GRIPS_EM = _HEIGHT_EM + 0.2  # height of the strip that the grips need


# The grips are drawn below the rows of keys, not over them: with five rows at the first height of
# the timeline, the grips and their number of frames would cover the row of the camera.
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
        _draw_grip(stretch, scale, f"stretch {name}", ImVec2(left, top), is_last)
    words = f"{ends.last - ends.first:g} frames"
    x0, x1 = scale.x_at(ends.first), scale.x_at(ends.last)
    width = imgui.calc_text_size(words).x
    if x1 - x0 > width + em and scale.x < x0 and x1 < scale.x + scale.width:
        text_corner = ImVec2((x0 + x1 - width) / 2, top + 0.15 * em)
        draw = imgui.get_window_draw_list()
        box_corner = ImVec2(
            text_corner.x - 0.3 * em, text_corner.y
        )  # own background, to be legible over a curve
        draw.add_rect_filled(
            box_corner,
            ImVec2(text_corner.x + width + 0.3 * em, text_corner.y + em),
            theme.colors.groove,
        )
        draw.add_text(text_corner, theme.colors.text_dim, words)


def _draw_grip(
    stretch: KeyStretch, scale: TimeScale, name: str, corner: ImVec2, is_last: bool
) -> None:
    """Draw one grip, and stretch the selected keys while it is dragged."""
    em = imgui.get_font_size()
    size = ImVec2(_WIDTH_EM * em, _HEIGHT_EM * em)
    widgets.invisible_button(name, corner, size, "Drag to stretch or shorten the chosen keys")
    is_bright = imgui.is_item_hovered() or imgui.is_item_active()
    if is_bright:
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
    if imgui.is_item_activated():
        stretch.press(is_last)
    elif imgui.is_item_active():
        grip_offset = (_GAP_EM + _WIDTH_EM / 2) * em
        stretch.drag(
            scale.frame_at(imgui.get_mouse_pos().x - (grip_offset if is_last else -grip_offset))
        )
    elif imgui.is_item_deactivated():
        stretch.release()
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    draw.add_rect_filled(corner, end, theme.colors.handle if is_bright else theme.colors.key, 2.0)
