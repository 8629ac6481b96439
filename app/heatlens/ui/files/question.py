"""Draw a modal question in the middle of the window."""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import ImVec2, imgui

_FLAGS = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_resize


@contextmanager
def question(title: str, width_em: float) -> Iterator[bool]:
    """Open and draw a modal question; yield False while it is not visible.

    The block draws text and buttons, and calls `imgui.close_current_popup` once the user has
    answered.
    """
    if not imgui.is_popup_open(title):
        imgui.open_popup(title)
    imgui.set_next_window_size(ImVec2(width_em * imgui.get_font_size(), 0))
    middle = imgui.get_main_viewport().get_center()
    imgui.set_next_window_pos(middle, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    shown, _ = imgui.begin_popup_modal(title, None, _FLAGS)
    yield bool(shown)
    if shown:
        imgui.end_popup()
