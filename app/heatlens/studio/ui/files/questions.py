"""Draw modal questions in the middle of the window, about a running export or unsaved work."""

from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.studio.session.exports.export_process import ExportRun
from heatlens.studio.session.files.shot_documents import ShotDocuments
from heatlens.studio.ui import topmost, widgets
from heatlens.studio.ui.state import UiState
from heatlens.studio.ui.status_bar import export_words

_LEFT = "The cluster can go on with it; opening the shot again shows how far it is."
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
    shown, _ = topmost.begin_modal(title, False, _FLAGS)
    if shown:
        topmost.answers_keys_itself()
    yield shown
    if shown:
        imgui.end_popup()


def quit_question(ui: UiState, run: ExportRun) -> None:
    """Draw the question what becomes of a running export, while it is open."""
    if not ui.asks_to_quit:
        return
    with question("An export is under way###quit", width_em=28.0) as shown:
        if not shown:
            return
        words, can_be_left = export_words(run.state), run.can_be_left
        stays = "" if run.state is None else run.state.when_stopped
        imgui.text_wrapped(f"{words}. {_LEFT if can_be_left else stays}")
        widgets.spacer()
        end = _end_of(run, can_be_left)
        if end is None and words and not topmost.is_escaped():
            return
        ui.asks_to_quit, ui.is_over = (
            False,
            (end is not _End.GO_ON and end is not None) or not words,
        )
        imgui.close_current_popup()


class _End(Enum):
    """What becomes of a running export when the window closes."""

    LEAVE = "Leave it to the cluster and close"
    STOP = "Stop it and close"
    GO_ON = "Keep exporting"


def _end_of(run: ExportRun, can_be_left: bool) -> _End | None:
    """Draw the buttons, and stop the export if that is the answer; None while there is none."""
    offered = [end for end in _End if can_be_left or end is not _End.LEAVE]
    pressed = [end for end in offered if _answer(end.value)]
    if not pressed and imgui.is_key_pressed(imgui.Key.enter, False):
        pressed = offered[:1]
    if _End.STOP in pressed:
        run.cancel()
    return next(iter(pressed), None)


def _answer(words: str) -> bool:
    pressed = widgets.button(words, f"quit {words}")
    imgui.same_line()
    return pressed


def shot_question(documents: ShotDocuments) -> None:
    """Draw the question while there are unsaved changes to recover."""
    offer = documents.offer
    if offer is None:
        return
    with question("Not saved###unsaved shot", width_em=30.0) as shown:
        if not shown:
            return
        what = "A shot of this plate was never saved to a file."
        if offer.saved is not None:
            what = f"{printable(offer.path.name)} has unsaved changes."
        imgui.text_wrapped(what)
        imgui.text_wrapped("heatlens ended before this was saved. Recover it?")
        widgets.spacer()
        for name, goes_on in (("Recover it", True), ("Discard it", False)):
            entered = goes_on and imgui.is_key_pressed(imgui.Key.enter, False)
            if widgets.button(name, f"unsaved {name}") or entered:
                documents.answer(goes_on)
                imgui.close_current_popup()
            imgui.same_line()
        imgui.new_line()
