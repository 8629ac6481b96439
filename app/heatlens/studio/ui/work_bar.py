"""Draw what goes on behind the window, in the status bar: an export, a mark that is tracked.

The progress of an export is shown in the title of the window too.
"""

import webbrowser
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.deliver.farm.export_process import ExportState
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.state import UiState

_BAR_EM = 9.0
_GAP_EM = 0.5  # between text, progress bar and buttons
_MINUTE_S = 60.0


@dataclass(frozen=True)
class _Part:
    """Words, what each button behind them does, and how much is done; None for no progress bar."""

    words: str
    buttons: Mapping[str, Callable[[], None]]
    share: float | None = None
    is_bad: bool = False

    @property
    def width(self) -> float:
        """The width in screen units."""
        style, em = imgui.get_style(), imgui.get_font_size()
        width = texts.text_width(self.words)
        width += 0.0 if self.share is None else (_BAR_EM + _GAP_EM) * em
        for name in self.buttons:
            width += texts.text_width(name) + 2 * style.frame_padding.x + _GAP_EM * em
        return width

    def draw(self) -> None:
        """Draw all of it in the line, and do what a pressed button says."""
        imgui.align_text_to_frame_padding()
        imgui.text_colored(theme.colors.bad if self.is_bad else theme.colors.message, self.words)
        if self.share is not None:
            imgui.same_line()
            imgui.progress_bar(self.share, ImVec2(_BAR_EM * imgui.get_font_size(), 0), "")
            rects.note("export progress")
        for name, run in self.buttons.items():
            imgui.same_line()
            if widgets.button(f"{name}##{self.words.partition(' ')[0]}", f"status {name}"):
                run()


def export_words(state: ExportState | None) -> str:
    """Return "Exporting 12 of 100, 30 s left" while an export is running, else ""."""
    if state is None or state.code is not None:
        return ""
    if not state.frames:
        return "Exporting"
    return f"Exporting {state.done_frames} of {state.frames}{_time_left(state.remaining_s)}"


def _time_left(remaining_s: float | None) -> str:
    """Return the remaining time as text, in seconds or minutes; "" if it is unknown."""
    if remaining_s is None:
        return ""
    if remaining_s < _MINUTE_S:
        return f", {remaining_s:.0f} s left"
    return f", {remaining_s / _MINUTE_S:.0f} min left"


def export_title(state: ExportState | None) -> str:
    """Return the start of the window title during an export: "45 % exported, "; else ""."""
    if state is None or state.code is not None or not state.frames:
        return ""
    return f"{100 * state.done_frames // state.frames} % exported, "


def work_bar_width(ui: UiState) -> float:
    """Return the width of `work_bar` in screen units; 0 if it draws nothing."""
    em = imgui.get_font_size()
    return sum(part.width + em for part in _parts(ui))  # with a gap at the right


def work_bar(ui: UiState) -> None:
    """Draw what is tracked with a Stop button, then the progress of an export, or its result."""
    em = imgui.get_font_size()
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(_GAP_EM * em, 0))
    for index, part in enumerate(_parts(ui)):
        if index:
            imgui.same_line(0.0, em)
        part.draw()
    imgui.pop_style_var()


def _parts(ui: UiState) -> Iterator[_Part]:
    """Yield what is tracked, and the running or ended export; note that an export ran."""
    tracking, run = ui.tracking, ui.files.exports.run
    if words := printable(tracking.words):
        yield _Part(words, {"Stop": tracking.stop})
    state = run.state
    if state is None:
        return
    if state.code is None:
        ui.shows_export_end = True
        share = state.done_frames / state.frames if state.frames else 0.0
        yield _Part(export_words(state), {"Stop": run.cancel}, share)
    elif ui.shows_export_end:
        failure_words = "Export stopped" if state.is_stopped else "Export failed"
        buttons = {"Show folder": partial(_show_folder, state), "x": partial(_dismiss, ui)}
        words = "Exported" if state.code == 0 else failure_words
        yield _Part(words, buttons, is_bad=state.code != 0)


def _show_folder(state: ExportState) -> None:
    webbrowser.open(Path(state.output).absolute().parent.as_uri())


def _dismiss(ui: UiState) -> None:
    ui.shows_export_end = False
