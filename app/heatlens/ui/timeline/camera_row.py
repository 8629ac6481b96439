"""The row of the scene's camera under those of the lens: its keys, and a dot to set one."""

from typing import TYPE_CHECKING

from imgui_bundle import ImVec2, imgui

from heatlens.ui import theme, widgets
from heatlens.ui.timeline.diamond import diamond
from heatlens.ui.timeline.timeline_scale import TimeScale

if TYPE_CHECKING:
    from heatlens.ui.app import App

_KEY_EM = 0.42


def camera_row(app: "App", scale: TimeScale, corner: ImVec2, row: float) -> None:
    """Draw it from `corner` on, its name left of `scale`; nothing without a scene."""
    if app.scenes.scene is None:
        return
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    keys = app.shot.camera_key_frames
    middle_y = corner.y + row / 2
    _dot(app, ImVec2(corner.x + 0.5 * em, middle_y))
    color = theme.HANDLE if keys else theme.TEXT_DIM
    draw.add_text(ImVec2(corner.x + 1.3 * em, corner.y + 0.2 * em), color, "camera")
    end = ImVec2(scale.x + scale.width, corner.y + row - 2)
    draw.add_rect_filled(ImVec2(scale.x, corner.y), end, theme.GROOVE)
    draw.push_clip_rect(ImVec2(scale.x, corner.y), end, True)
    for frame in keys:
        at = ImVec2(scale.x_at(frame), middle_y)
        widgets.drawn_at[f"camera key {frame:g}"] = (at.x, at.y, at.x, at.y)
        draw.add_quad_filled(*diamond(at, _KEY_EM * em), theme.KEY)
        draw.add_quad(*diamond(at, _KEY_EM * em), theme.SHADOW, 1.0)
    draw.pop_clip_rect()


def _dot(app: "App", middle: ImVec2) -> None:
    """Filled where there is a key at the playhead; a click sets or takes one."""
    side = 0.5 * imgui.get_font_size()
    is_here = app.editing.frame in app.shot.camera_key_frames
    imgui.set_cursor_screen_pos(ImVec2(middle.x - side, middle.y - side))
    if imgui.invisible_button("dot camera", ImVec2(2 * side, 2 * side)):
        if is_here:
            app.scenes.delete_key()
        else:
            app.scenes.set_key()
    widgets.note("dot camera")
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip("Key of the camera at this frame")
    draw, color = imgui.get_window_draw_list(), theme.ACCENT if is_here else theme.QUEUED
    if is_here:
        draw.add_quad_filled(*diamond(middle, 0.6 * side), color)
    else:
        draw.add_quad(*diamond(middle, 0.6 * side), color, 1.2)
