"""Ask the user: a row of answers, and modal questions in the middle of the window."""

from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.studio.ui import texts, topmost, widgets

_WIDTH_EM = 32.0
_FLAGS = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_resize


def ask(key: str, title: str, words: str, answers: Sequence[str], escape: str = "") -> str:
    """Draw a modal question; return the answer in the frame in which it is given, else "".

    Enter gives the first answer, and Escape gives `escape`, or the last answer. `key` names the
    question among all others, whatever its title.
    """
    name = f"{title}###{key}"
    if not imgui.is_popup_open(name):
        imgui.open_popup(name)
    imgui.set_next_window_size(ImVec2(_box_width(answers), 0))
    center = imgui.get_main_viewport().get_center()
    imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    is_visible, _ = topmost.begin_modal(name, False, _FLAGS)
    if not is_visible:
        return ""
    topmost.disable_key_navigation()
    imgui.text_wrapped(texts.named_keys(printable(words)))
    widgets.spacer()
    answer = answer_buttons(key, answers)
    if not answer and imgui.is_key_pressed(imgui.Key.enter, False):
        answer = answers[0]
    if not answer and topmost.is_escaped():
        answer = escape or answers[-1]
    if answer:
        imgui.close_current_popup()
    imgui.end_popup()
    return answer


def _box_width(answers: Sequence[str]) -> float:
    """Return a width in which all answers stand in one line, if the window has it."""
    style, em = imgui.get_style(), imgui.get_font_size()
    row = sum(_button_width(words) + style.item_spacing.x for words in answers)
    row += 2 * style.window_padding.x
    return min(max(_WIDTH_EM * em, row), imgui.get_main_viewport().size.x - 2 * em)


def _button_width(words: str) -> float:
    return imgui.calc_text_size(words).x + 2 * imgui.get_style().frame_padding.x


def answer_buttons(key: str, answers: Sequence[str]) -> str:
    """Draw a button for each answer, in lines as they fit; return the pressed one, or ""."""
    pressed = ""
    for index, words in enumerate(answers):
        if index:
            imgui.same_line()
            if _button_width(words) > imgui.get_content_region_avail().x:
                imgui.new_line()
        fill = imgui.Col_.button if index else imgui.Col_.header_active  # Enter gives the first
        imgui.push_style_color(imgui.Col_.button, imgui.get_color_u32(fill))
        if widgets.button(words, f"{key} {words}"):
            pressed = words
        imgui.pop_style_color()
    return pressed
