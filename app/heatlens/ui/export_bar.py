"""Show the progress of an export in the status bar and in the window title."""

import webbrowser
from pathlib import Path

from imgui_bundle import ImVec2, imgui

from heatlens.session.exports.export_process import ExportRun, ExportState
from heatlens.ui import probe, theme, widgets
from heatlens.ui.state import UiState

_BAR_EM = 9.0
GAP_EM = 0.5  # between text, progress bar and buttons
_MINUTE_S = 60.0


def export_words(state: ExportState | None) -> str:
    """Return "Exporting 12 of 100, 30 s left" while an export goes on, else ""."""
    if state is None or state.code is not None:
        return ""
    if not state.frames:
        return "Exporting"
    return f"Exporting {state.done} of {state.frames}{_time_left(state.left_s)}"


def _time_left(left_s: float | None) -> str:
    if left_s is None:
        return ""
    if left_s < _MINUTE_S:
        return f", {left_s:.0f} s left"
    return f", {left_s / _MINUTE_S:.0f} min left"


def export_title(state: ExportState | None) -> str:
    """Return the start of the window title during an export: "45 % exported, "; else ""."""
    if state is None or state.code is not None or not state.frames:
        return ""
    return f"{100 * state.done // state.frames} % exported, "


def export_bar_width(run: ExportRun, ui: UiState) -> float:
    """Return the width of `export_bar` in screen units; 0 if it draws nothing."""
    style, em = imgui.get_style(), imgui.get_font_size()
    buttons, words = _parts(run, ui)
    if not words:
        return 0.0
    width = imgui.calc_text_size(words).x + em  # a gap of one em to the text at its right
    width += (_BAR_EM + GAP_EM) * em if run.is_busy else 0.0
    for name in buttons:
        width += imgui.calc_text_size(name).x + 2 * style.frame_padding.x + GAP_EM * em
    return float(width)


def export_bar(run: ExportRun, ui: UiState) -> None:
    """Draw the progress with a Stop button, or the result with a button for its folder."""
    buttons, words = _parts(run, ui)
    state = run.state
    if not words or state is None:
        return
    imgui.align_text_to_frame_padding()
    imgui.text_colored(theme.colors.bad if state.code else theme.colors.told, words)
    if run.is_busy:
        imgui.same_line()
        part = state.done / state.frames if state.frames else 0.0
        imgui.progress_bar(part, ImVec2(_BAR_EM * imgui.get_font_size(), 0), "")
        probe.note("export progress")
    for name in buttons:
        imgui.same_line()
        if widgets.button(f"{name}##export", f"status {name}"):
            _pressed(name, run, ui)


def _parts(run: ExportRun, ui: UiState) -> tuple[tuple[str, ...], str]:
    """Return the names of the buttons and the text before them."""
    state = run.state
    if state is None:
        return (), ""
    if state.code is None:
        ui.shows_export_end = True
        return ("Stop",), export_words(state)
    if not ui.shows_export_end:
        return (), ""
    failed = "Export stopped" if state.is_stopped else "Export failed"
    return ("Show folder", "x"), "Exported" if state.code == 0 else failed


def _pressed(name: str, run: ExportRun, ui: UiState) -> None:
    if name == "Stop":
        run.cancel()
    elif name == "x":
        ui.shows_export_end = False
    elif run.state is not None:
        webbrowser.open(Path(run.state.output).absolute().parent.as_uri())
