"""Draw the row of the scene's camera: its name and a dot that sets a key."""

from imgui_bundle import ImVec2, imgui

from heatlens.session.keys.key_rows import CAMERA
from heatlens.session.session import Session
from heatlens.ui import probe, theme
from heatlens.ui.timeline.row_parts import diamond, row_name
from heatlens.ui.timeline.scale import TimeScale


def camera_row(session: Session, scale: TimeScale, corner: ImVec2, row: float) -> None:
    """Draw the row at `corner`, its name left of `scale`; its keys are drawn with all others."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    _dot(session, ImVec2(corner.x + 0.5 * em, corner.y + row / 2))
    row_name(
        session, CAMERA, corner, scale.x, row, "Click to select the camera: K then sets its key"
    )
    color = theme.colors.handle if session.shot.camera_key_frames else theme.colors.text_dim
    draw.add_text(ImVec2(corner.x + 1.3 * em, corner.y + (row - em) / 2), color, CAMERA.words)
    end = ImVec2(scale.x + scale.width, corner.y + row - 2)
    draw.add_rect_filled(ImVec2(scale.x, corner.y), end, theme.colors.groove)


def _dot(session: Session, middle: ImVec2) -> None:
    """Draw the dot of the camera; a click sets or removes its key at the playhead."""
    side = 0.5 * imgui.get_font_size()
    is_here = session.editing.frame in session.shot.camera_key_frames
    imgui.set_cursor_screen_pos(ImVec2(middle.x - side, middle.y - side))
    if imgui.invisible_button("dot camera", ImVec2(2 * side, 2 * side)):
        if is_here:
            session.scenes.delete_key()
        else:
            session.scenes.set_key()
    probe.note("dot camera")
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip("Key of the camera at this frame")
    color = theme.colors.accent if session.shot.camera_key_frames else theme.colors.queued
    draw = imgui.get_window_draw_list()
    if is_here:
        draw.add_quad_filled(*diamond(middle, 0.6 * side), color)
    else:
        draw.add_quad(*diamond(middle, 0.6 * side), color, 1.2)
