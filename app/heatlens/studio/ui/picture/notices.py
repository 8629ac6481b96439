"""Draw texts over the picture: lessons, what has just failed, and notices about what is open.

The lessons about the gestures are shown over the sample pictures of heatlens. The notices tell what
is missing in a source, and offer answers.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from imgui_bundle import ImVec2, ImVec4, imgui

from heatlens.core.base.messages import window_words
from heatlens.core.base.outside_text import printable
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.render.source.stream_source import StreamSource
from heatlens.studio.board.facts import Facts
from heatlens.studio.board.lessons import Lesson, Lessons
from heatlens.studio.board.notices import Answer, Notice
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.answers import answer_buttons
from heatlens.studio.ui.state import UiState

_WIDTH_EM, _MIN_WIDTH_EM = (
    28.0,
    16.0,
)  # usual and smallest width of the card, which else is not drawn
_MARGIN_EM = 0.8  # margin to the edges of the picture's window
_MAX_SHARE = 1 / 3  # largest share of the height of the picture
_LINE_EM = 0.15  # height of the progress line under the picture
_HIDE = "Hide"


def draw_lessons(lessons: Lessons, viewport: Viewport, is_hidden: bool) -> None:
    """Draw the remaining lessons at the lower left of the picture, if they fit.

    Their card would lie over a dialog, so it waits until that is closed.
    """
    left = imgui.MouseButton_.left
    lessons.watch(imgui.is_mouse_dragging(left), imgui.is_mouse_down(left))
    em, card_width = imgui.get_font_size(), _card_width(viewport)
    shown_lessons = (
        _fitting_lessons(lessons.remaining, card_width, _MAX_SHARE * viewport.size[1])
        if card_width > _MIN_WIDTH_EM * em
        else ()
    )
    if is_hidden or not shown_lessons or _is_behind_dialog():
        return
    with _card("lessons", viewport):
        for lesson in shown_lessons:
            _draw_card_text(str(lesson), card_width)
            rects.note(f"lesson {lesson.name}")
            if lesson is shown_lessons[0] and _hide_button("dismiss lessons", card_width):
                lessons.is_dismissed = True


# In the status bar, far from the eye, a sentence in red was overlooked.
def draw_problem(ui: UiState, viewport: Viewport) -> None:
    """Draw what has just failed at the lower left of `viewport`, until it is hidden or old."""
    if not has_problem(ui):
        return
    with theme.over_picture(), _card("problem", viewport):
        with texts.colored(theme.OVER_PICTURE.bad):
            _draw_card_text(texts.named_keys(ui.messages.text), _card_width(viewport))
        rects.note("message")
        if _hide_button("hide problem", _card_width(viewport)):
            ui.messages.clear()


def draw_progress(facts: Facts, viewport: Viewport) -> None:
    """Draw the line under the picture that fills while the whole picture is rendered."""
    share, (x, y), (width, height) = facts.part_done, viewport.corner, viewport.size
    if share:
        end = ImVec2(x + share * width, y + height + _LINE_EM * imgui.get_font_size())
        draw = imgui.get_window_draw_list()
        draw.add_rect_filled(ImVec2(x, y + height), end, theme.colors.text_dim)
        rects.note_at("part of the picture", (x, y + height, end.x, end.y))


def has_problem(ui: UiState) -> bool:
    """Return True if a message tells what has failed, and neither dialog nor notice tells it.

    Notices are hidden while the picture is alone.
    """
    messages, notice = ui.messages, ui.files.notices.first
    is_told = notice is not None and notice.about is messages.cause and not ui.is_bare
    return bool(messages.text) and messages.is_problem and not (is_told or _is_behind_dialog())


def _is_behind_dialog() -> bool:
    return imgui.internal.get_top_most_popup_modal() is not None


def _card_width(viewport: Viewport) -> float:
    em = imgui.get_font_size()
    return min(_WIDTH_EM * em, viewport.size[0] - 2 * _MARGIN_EM * em)


@contextmanager
def _card(name: str, viewport: Viewport) -> Iterator[None]:
    """Draw the texts of the block on a card at the lower left of the picture."""
    margin, (x, y), height = _MARGIN_EM * imgui.get_font_size(), viewport.corner, viewport.size[1]
    imgui.set_next_window_pos(ImVec2(x + margin, y + height - margin), 0, ImVec2(0.0, 1.0))
    imgui.set_next_window_size(ImVec2(_card_width(viewport), 0.0))
    imgui.set_next_window_bg_alpha(theme.NOTICE_OPACITY)
    flags = imgui.WindowFlags_
    imgui.begin(
        name, None,
        flags.no_decoration | flags.no_move | flags.no_docking | flags.no_saved_settings
        | flags.no_focus_on_appearing | flags.no_nav | flags.always_auto_resize,
    )  # fmt: skip
    yield
    imgui.end()


def _draw_card_text(text: str, card_width: float) -> None:
    """Draw text, wrapped left of the button."""
    imgui.push_text_wrap_pos(_text_end(card_width))
    imgui.text(text)
    imgui.pop_text_wrap_pos()


def _hide_button(name: str, card_width: float) -> bool:
    """Draw the button that hides the card, at the right of its first text."""
    imgui.same_line(card_width - imgui.get_style().window_padding.x - _hide_width())
    return widgets.small_button(_HIDE, name)


def _fitting_lessons(
    lessons: Sequence[Lesson], card_width: float, max_height: float
) -> Sequence[Lesson]:
    """Return all remaining lessons, or only the next one if a card with all would be too high.

    Return none if even that would cover too much of a small picture.
    """
    for some_lessons in (lessons, lessons[:1]):
        if _card_height(some_lessons, card_width) <= max_height:
            return some_lessons
    return ()


def _card_height(lessons: Sequence[Lesson], card_width: float) -> float:
    """Return the height of a card with these lessons, in screen units."""
    style, width = imgui.get_style(), _text_end(card_width) - imgui.get_style().window_padding.x
    lines = [imgui.calc_text_size(str(lesson), wrap_width=width).y for lesson in lessons]
    return sum(lines) + max(len(lines) - 1, 0) * style.item_spacing.y + 2 * style.window_padding.y


def _text_end(card_width: float) -> float:
    """Return the x at which the text ends, left of the button."""
    style = imgui.get_style()
    return card_width - style.window_padding.x - _hide_width() - style.item_spacing.x


def _hide_width() -> float:
    return float(imgui.calc_text_size(_HIDE).x + 2 * imgui.get_style().frame_padding.x)


_NOTICE_EM = 44.0  # longest line that is still easy to read
_LINES = (
    "A renderer that speaks the protocol of the viewer tev sends its picture to this address.",
    "It needs colour (R, G, B) and depth (Z), in one image or in two; --depth FILE brings the "
    "depth of a renderer that sends none.",
    "Ctrl+O opens a file instead.",
)


def has_no_frame(facts: Facts) -> bool:
    """Return True if the frame at the playhead has no file, or no stream has sent one."""
    is_black = facts.is_black and not facts.plays_cached_frames
    return is_black or (facts.is_waiting and facts.stream is not None)


def draw_reason(facts: Facts) -> None:
    """Draw why there is no picture."""
    if facts.is_black and not facts.plays_cached_frames:
        imgui.text_disabled(f"  Frame {facts.frame} has no file.")
    elif facts.is_waiting and facts.stream is not None:
        _draw_waiting(facts.stream)
    else:
        is_opening = facts.plate is not None or facts.opening
        words = "Opening ..." if is_opening else "Nothing is open: Ctrl+O, or drop a file here."
        imgui.text_disabled(f"  {texts.named_keys(words)}")


def _draw_waiting(stream: StreamSource) -> None:
    """Draw the address of the stream and its last refusal in the middle of the window."""
    free_size, em = imgui.get_content_region_avail(), imgui.get_font_size()
    width = min(_NOTICE_EM * em, free_size.x - 2 * em)
    refusal = window_words(stream.refusal)
    lines = [(f"Listening on {stream.address} ...", theme.OVER_PICTURE.dim)]
    lines += [(refusal, theme.OVER_PICTURE.message)] if refusal else []
    lines += [(line, theme.OVER_PICTURE.dim) for line in _LINES]
    heights = [imgui.calc_text_size(text, False, width).y for text, _ in lines]
    y = max(0.5 * (free_size.y - sum(heights) - em * len(lines)), 0.0)
    corner = imgui.get_cursor_pos()
    for (text, color), height in zip(lines, heights, strict=True):
        _draw_wrapped(
            text, color, ImVec2(corner.x + 0.5 * (free_size.x - width), corner.y + y), width
        )
        y += height + em


def draw_notice(ui: UiState, viewport: Viewport, has_keyboard: bool) -> None:
    """Draw the first notice over the top of the picture, with its answers, and follow one."""
    notice = ui.files.notices.first
    if notice is None:
        return
    em, (x, y), width = imgui.get_font_size(), viewport.corner, viewport.size[0]
    imgui.set_cursor_screen_pos(ImVec2(x + 0.5 * em, y + 0.5 * em))
    ground = theme.OVER_PICTURE.style[imgui.Col_.window_bg]
    imgui.push_style_color(imgui.Col_.child_bg, ImVec4(*ground, theme.NOTICE_OPACITY))
    flags = imgui.ChildFlags_.auto_resize_y | imgui.ChildFlags_.always_use_window_padding
    imgui.begin_child("notice", ImVec2(min(_NOTICE_EM * em, width - em), 0.0), flags)
    imgui.push_text_wrap_pos(0.0)
    texts.colored_text(printable(notice.words), theme.OVER_PICTURE.message)
    imgui.pop_text_wrap_pos()
    pressed = answer_buttons("notice", [answer.words for answer in notice.answers])
    if has_keyboard and imgui.is_key_pressed(imgui.Key.enter, False):
        pressed = pressed or notice.answers[0].words
    imgui.end_child()
    imgui.pop_style_color()
    for answer in notice.answers:
        if answer.words == pressed:
            _follow(ui, notice, answer)


def _follow(ui: UiState, notice: Notice, answer: Answer) -> None:
    """Follow an answer, which may open a dialog or show a panel; it hides the latest message."""
    ui.messages.clear()
    ui.files.notices.answer(notice, answer)
    if answer.dialog:
        ui.dialogs.ask(answer.dialog)
    if answer.panel:
        ui.panels[answer.panel] = True
        imgui.set_window_focus(answer.panel)


def _draw_wrapped(text: str, color: ImVec4, corner: ImVec2, width: float) -> None:
    """Draw text in a color, wrapped to a width, at a position in the window."""
    imgui.set_cursor_pos(corner)
    imgui.push_text_wrap_pos(corner.x + width)
    texts.colored_text(text, color)
    imgui.pop_text_wrap_pos()
