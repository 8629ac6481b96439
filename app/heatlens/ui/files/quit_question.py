"""The question before the window is closed on an export that is under way."""

from imgui_bundle import ImVec2, imgui

from heatlens.ui import probe, topmost, widgets
from heatlens.ui.state import UiState

_TITLE = "An export is under way###quit"
_WIDTH_EM = 28.0


def quit_question(ui: UiState, words: str) -> None:
    """Draw it while it is asked; `words` tell how far the export is."""
    if not ui.asks_to_quit:
        return
    if not imgui.is_popup_open(_TITLE):
        imgui.open_popup(_TITLE)
    em, screen = imgui.get_font_size(), imgui.get_main_viewport()
    imgui.set_next_window_size(ImVec2(_WIDTH_EM * em, 0))
    imgui.set_next_window_pos(screen.get_center(), imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    flags = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_resize
    shown, _ = imgui.begin_popup_modal(_TITLE, None, flags)
    if not shown:
        return
    imgui.text_wrapped(f"{words}. Finished frames stay; exporting again goes on with the rest.")
    widgets.spacer()
    is_closing = _button("Stop it and close")
    imgui.same_line()
    if is_closing or _button("Keep exporting") or topmost.is_escaped() or not words:
        ui.asks_to_quit, ui.is_over = False, is_closing or not words
        imgui.close_current_popup()
    imgui.end_popup()


def _button(name: str) -> bool:
    pressed = imgui.button(name)
    probe.note(f"quit {name}")
    return bool(pressed)
