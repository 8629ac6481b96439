"""Draw short lessons about the mouse gestures over the sample pictures of heatlens."""

from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui

from heatlens.model.view.view_geometry import Viewport
from heatlens.session.marks.lessons import Lesson, Lessons
from heatlens.ui import probe, widgets

_WIDTH_EM, _LEAST_EM = 28.0, 16.0  # usual and least width of the card; without room it is left out
_MARGIN_EM = 0.8  # margin to the edges of the picture's window
_PART_MOST = 1 / 3  # largest share of the height of the picture
_HIDE = "Hide"


def draw_lessons(lessons: Lessons, viewport: Viewport, is_hidden: bool) -> None:
    """Draw the lessons not yet learnt at the lower left of the picture, if there is room."""
    left = imgui.MouseButton_.left
    lessons.watch(imgui.is_mouse_dragging(left), imgui.is_mouse_down(left))
    em, (x, y), (width, height) = imgui.get_font_size(), viewport.corner, viewport.size
    card = min(_WIDTH_EM * em, width - 2 * _MARGIN_EM * em)
    shown = _with_room(lessons.left, card, _PART_MOST * height) if card > _LEAST_EM * em else ()
    if is_hidden or not shown:
        return
    at = ImVec2(x + _MARGIN_EM * em, y + height - _MARGIN_EM * em)
    imgui.set_next_window_pos(at, 0, ImVec2(0.0, 1.0))
    imgui.set_next_window_size(ImVec2(card, 0.0))
    imgui.set_next_window_bg_alpha(0.86)
    flags = imgui.WindowFlags_
    imgui.begin(
        "lessons", None,
        flags.no_decoration | flags.no_move | flags.no_docking | flags.no_saved_settings
        | flags.no_focus_on_appearing | flags.no_nav | flags.always_auto_resize,
    )  # fmt: skip
    for lesson in shown:
        imgui.push_text_wrap_pos(_words_end(card))
        imgui.text(str(lesson))
        imgui.pop_text_wrap_pos()
        probe.note(f"lesson {lesson.name}")
        if lesson is shown[0]:
            _hide(lessons, card)
    imgui.end()


def _hide(lessons: Lessons, card: float) -> None:
    """Draw the button that hides the lessons, at the right of the first one."""
    imgui.same_line(card - imgui.get_style().window_padding.x - _hide_width())
    if widgets.small_button(_HIDE, "dismiss lessons"):
        lessons.is_dismissed = True


def _with_room(left: Sequence[Lesson], card: float, room: float) -> Sequence[Lesson]:
    """Return all remaining lessons, or only the next one if a card with all would be too high.

    Return none if even that would cover too much of a small picture.
    """
    for shown in (left, left[:1]):
        if _height(shown, card) <= room:
            return shown
    return ()


def _height(shown: Sequence[Lesson], card: float) -> float:
    style, width = imgui.get_style(), _words_end(card) - imgui.get_style().window_padding.x
    lines = [imgui.calc_text_size(str(lesson), wrap_width=width).y for lesson in shown]
    return sum(lines) + max(len(lines) - 1, 0) * style.item_spacing.y + 2 * style.window_padding.y


def _words_end(card: float) -> float:
    """Return the x at which the text ends, left of the button."""
    style = imgui.get_style()
    return card - style.window_padding.x - _hide_width() - style.item_spacing.x


def _hide_width() -> float:
    return float(imgui.calc_text_size(_HIDE).x + 2 * imgui.get_style().frame_padding.x)
