"""Draw words over the picture: lessons about the gestures, and the notices of a stream.

The lessons are shown over the sample pictures of heatlens; the notices say why nothing, or not the
newest picture, is shown.
"""

from collections.abc import Sequence

from imgui_bundle import ImVec2, ImVec4, imgui

from heatlens.core.model.view.view_geometry import Viewport
from heatlens.render.source.stream_source import StreamSource
from heatlens.studio.session.marks.lessons import Lesson, Lessons
from heatlens.studio.session.messages import window_words
from heatlens.studio.ui import probe, texts, theme, widgets

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


_NOTICE_EM = 44.0  # longest line that is still easy to read
_LINES = (
    "A renderer that speaks the protocol of the viewer tev sends its picture to this address.",
    "It needs colour (R, G, B) and depth (Z), in one image or in two; --depth FILE brings the "
    "depth of a renderer that sends none.",
    "Ctrl+O opens a file instead.",
)


def draw_waiting(stream: StreamSource) -> None:
    """Draw in the middle of the window what the stream waits for, and what it could not show."""
    room, em = imgui.get_content_region_avail(), imgui.get_font_size()
    width = min(_NOTICE_EM * em, room.x - 2 * em)
    said = window_words(stream.refusal)
    lines = [(f"Listening on {stream.address} ...", theme.OVER_PICTURE.dim)]
    lines += [(said, theme.OVER_PICTURE.told)] if said else []
    lines += [(line, theme.OVER_PICTURE.dim) for line in _LINES]
    heights = [imgui.calc_text_size(text, False, width).y for text, _ in lines]
    y = max(0.5 * (room.y - sum(heights) - em * len(lines)), 0.0)
    corner = imgui.get_cursor_pos()
    for (text, color), height in zip(lines, heights, strict=True):
        _draw_wrapped(text, color, ImVec2(corner.x + 0.5 * (room.x - width), corner.y + y), width)
        y += height + em


class StreamNotice:
    """A notice over the picture why the latest data is not shown, until the user dismisses it."""

    def __init__(self) -> None:
        self._dismissed = ""

    def draw(self, stream: StreamSource, viewport: Viewport) -> None:
        """Draw the notice over the top of the picture, if there is one."""
        said = window_words(stream.refusal)
        if not said or said == self._dismissed:
            return
        em, (x, y), width = imgui.get_font_size(), viewport.corner, viewport.size[0]
        imgui.set_cursor_screen_pos(ImVec2(x + 0.5 * em, y + 0.5 * em))
        imgui.push_style_color(imgui.Col_.child_bg, theme.OVER_PICTURE.shadow)
        flags = imgui.ChildFlags_.auto_resize_y | imgui.ChildFlags_.always_use_window_padding
        imgui.begin_child("stream notice", ImVec2(min(_NOTICE_EM * em, width - em), 0.0), flags)
        texts.colored_text(said, theme.OVER_PICTURE.told)
        if widgets.small_button("Dismiss", "stream notice"):
            self._dismissed = said
        imgui.end_child()
        imgui.pop_style_color()


def _draw_wrapped(text: str, color: ImVec4, at: ImVec2, width: float) -> None:
    imgui.set_cursor_pos(at)
    imgui.push_text_wrap_pos(at.x + width)
    texts.colored_text(text, color)
    imgui.pop_text_wrap_pos()
