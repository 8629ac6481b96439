"""A question in the middle of the window, which has to be answered before anything else."""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import ImVec2, imgui

_FLAGS = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_resize


@contextmanager
def question(title: str, width_em: float) -> Iterator[bool]:
    """Open the question where it is not open, and draw it; False where it is not to be seen.

    The words and buttons are drawn inside the block, which closes it with
    `imgui.close_current_popup` once it is answered.
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
