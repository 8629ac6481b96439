"""Draw short lessons about the mouse gestures over the sample pictures of heatlens."""

from imgui_bundle import ImVec2, imgui

from heatlens.model.view_geometry import Viewport
from heatlens.session.lessons import Lessons
from heatlens.ui import probe, theme

_WIDTH_EM, _LEAST_EM = 26.0, 30.0


def draw_lessons(lessons: Lessons, viewport: Viewport) -> None:
    """Draw the lessons not yet learnt at the lower left of the picture, if there is room."""
    left = imgui.MouseButton_.left
    lessons.watch(imgui.is_mouse_dragging(left), imgui.is_mouse_down(left))
    em, (x, y), (width, height) = imgui.get_font_size(), viewport.corner, viewport.size
    if not lessons.left or width < _LEAST_EM * em:
        return
    imgui.set_next_window_pos(ImVec2(x + 0.8 * em, y + height - 0.8 * em), 0, ImVec2(0.0, 1.0))
    imgui.set_next_window_size(ImVec2(_WIDTH_EM * em, 0.0))
    imgui.set_next_window_bg_alpha(0.86)
    flags = imgui.WindowFlags_
    imgui.begin(
        "lessons", None,
        flags.no_decoration | flags.no_move | flags.no_docking | flags.no_saved_settings
        | flags.no_focus_on_appearing | flags.no_nav | flags.always_auto_resize,
    )  # fmt: skip
    for lesson in lessons.left:
        imgui.bullet()
        imgui.push_style_color(imgui.Col_.text, theme.OVER_PICTURE.accent_text)
        imgui.text_wrapped(str(lesson))
        imgui.pop_style_color()
    if imgui.small_button("Hide"):
        lessons.is_dismissed = True
    probe.note("dismiss lessons")
    imgui.end()
