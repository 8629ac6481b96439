"""Draw modal questions in the middle of the window: an export, unsaved work, a missing depth."""

from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.depth_words import DepthSide
from heatlens.deliver.farm.export_process import ExportRun
from heatlens.studio.board.controls import FileControl
from heatlens.studio.ui import topmost, widgets
from heatlens.studio.ui.state import UiState
from heatlens.studio.ui.status_bar import export_words

_LEAVE_WORDS = "The cluster can go on with it; opening the shot again shows how far it is."
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
    center = imgui.get_main_viewport().get_center()
    imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    is_visible, _ = topmost.begin_modal(title, can_close=False, flags=_FLAGS)
    if is_visible:
        topmost.disable_key_navigation()
    yield is_visible
    if is_visible:
        imgui.end_popup()


def quit_question(ui: UiState, run: ExportRun) -> None:
    """Draw the question what to do with a running export; the answer may end the program."""
    if not ui.asks_to_quit:
        return
    with question("An export is under way###quit", width_em=28.0) as is_visible:
        if not is_visible:
            return
        state_words, can_be_left = export_words(run.state), run.can_be_left
        stop_words = "" if run.state is None else run.state.when_stopped
        imgui.text_wrapped(f"{state_words}. {_LEAVE_WORDS if can_be_left else stop_words}")
        widgets.spacer()
        end = _draw_end_buttons(run, can_be_left)
        if end is None and state_words and not topmost.is_escaped():
            return
        ui.asks_to_quit = False
        ui.is_over = (end is not _ExportEnd.GO_ON and end is not None) or not state_words
        imgui.close_current_popup()


class _ExportEnd(Enum):
    """What happens to a running export when the window closes."""

    LEAVE = "Leave it to the cluster and close"
    STOP = "Stop it and close"
    GO_ON = "Keep exporting"


def _draw_end_buttons(run: ExportRun, can_be_left: bool) -> _ExportEnd | None:
    """Draw the buttons, and stop the export if that is the answer; return the answer or None."""
    offered_ends = [end for end in _ExportEnd if can_be_left or end is not _ExportEnd.LEAVE]
    pressed_ends = [end for end in offered_ends if _answer_button(end.value)]
    if not pressed_ends and imgui.is_key_pressed(imgui.Key.enter, False):
        pressed_ends = offered_ends[:1]
    if _ExportEnd.STOP in pressed_ends:
        run.cancel()
    return next(iter(pressed_ends), None)


def _answer_button(words: str) -> bool:
    """Draw a button in the current line; return True if it was pressed."""
    is_pressed = widgets.button(words, f"quit {words}")
    imgui.same_line()
    return is_pressed


_HALVES = {"Left half": DepthSide.LEFT, "Right half": DepthSide.RIGHT}
_DEPTH_DIALOGS = {"Choose its depth...": "depth", "Estimate...": "network"}


def depth_question(ui: UiState) -> None:
    """Draw the question where the depth of a picture is that was opened without one."""
    no_depth = ui.files.commands.no_depth
    if not no_depth.name:
        return
    with question("No depth###no depth", width_em=34.0) as is_visible:
        if not is_visible:
            return
        imgui.text_wrapped(f"{printable(no_depth.name)} has no depth. Where is it?")
        widgets.spacer()
        pressed = [words for words in (*_DEPTH_DIALOGS, *_HALVES, "Cancel") if _depth_button(words)]
        if not pressed and imgui.is_key_pressed(imgui.Key.enter, False):
            pressed = [next(iter(_DEPTH_DIALOGS))]
        if not (pressed or topmost.is_escaped()):
            return
        imgui.close_current_popup()
        words = pressed[0] if pressed else "Cancel"
        if words in _HALVES:
            no_depth.use_side(_HALVES[words])
            return
        no_depth.wait_for_file()
        if words in _DEPTH_DIALOGS:
            ui.dialogs.ask(_DEPTH_DIALOGS[words])


def _depth_button(words: str) -> bool:
    """Draw an answer about the depth in the current line; return True if it was pressed."""
    is_pressed = widgets.button(words, f"no depth {words}")
    imgui.same_line()
    return is_pressed


def save_question(ui: UiState) -> None:
    """Draw why the shot could not be saved, until the user saves it elsewhere or lets it be."""
    documents = ui.files.documents
    if not documents.failed_save:
        return
    with question("Not saved###failed save", width_em=30.0) as is_visible:
        if not is_visible:
            return
        imgui.text_wrapped(printable(documents.failed_save))
        widgets.spacer()
        is_elsewhere = widgets.button("Save elsewhere...", "save elsewhere")
        is_elsewhere |= imgui.is_key_pressed(imgui.Key.enter, False)
        imgui.same_line()
        is_over = widgets.button("Go on unsaved", "go on unsaved") or topmost.is_escaped()
        if is_elsewhere or is_over:
            documents.failed_save = ""
            imgui.close_current_popup()
        if is_elsewhere:
            ui.dialogs.ask("save shot")


def shot_question(files: FileControl) -> None:
    """Draw the question while there are unsaved changes to recover."""
    offer = files.documents.offer
    if offer is None:
        return
    with question("Not saved###unsaved shot", width_em=30.0) as is_visible:
        if not is_visible:
            return
        imgui.text_wrapped(printable(offer.words))
        widgets.spacer()
        start_anew = "Start anew" if offer.saved is None else "Open it as saved"
        for name, recovers in (("Go on with it", True), (start_anew, False)):
            is_entered = recovers and imgui.is_key_pressed(imgui.Key.enter, False)
            if widgets.button(name, f"unsaved {name}") or is_entered:
                files.documents.answer(recovers)
                imgui.close_current_popup()
            imgui.same_line()
        imgui.new_line()
