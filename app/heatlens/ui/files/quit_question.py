"""Ask before the window is closed while an export is running."""

from imgui_bundle import imgui

from heatlens.ui import probe, topmost, widgets
from heatlens.ui.files.question import question
from heatlens.ui.state import UiState

_TITLE = "An export is under way###quit"
_WIDTH_EM = 28.0


def quit_question(ui: UiState, words: str, stays: str) -> None:
    """Draw the question while it is open.

    `words` tell the progress of the export, `stays` is a sentence on what stays of it.
    """
    if not ui.asks_to_quit:
        return
    with question(_TITLE, _WIDTH_EM) as shown:
        if shown:
            _answer(ui, words, stays)


def _answer(ui: UiState, words: str, stays: str) -> None:
    topmost.answers_keys_itself()
    imgui.text_wrapped(f"{words}. {stays}")
    widgets.spacer()
    entered = imgui.is_key_pressed(imgui.Key.enter, False)
    is_closing = _button("Stop it and close") or entered
    imgui.same_line()
    if is_closing or _button("Keep exporting") or topmost.is_escaped() or not words:
        ui.asks_to_quit, ui.is_over = False, is_closing or not words
        imgui.close_current_popup()


def _button(name: str) -> bool:
    pressed = imgui.button(name)
    probe.note(f"quit {name}")
    return bool(pressed)
