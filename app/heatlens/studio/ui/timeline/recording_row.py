"""Draw the recording of a focus pull: a row with its state, and the recorded curve as a band."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.shot.pull import TOLERANCE_LEAST, TOLERANCE_MOST, RecordingState
from heatlens.core.model.units import format_distance, label_distance
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.ui import rects, texts, theme
from heatlens.studio.ui.timeline.curve_handles import Heights
from heatlens.studio.ui.timeline.tool_row import Tool, button_tool, text_tool, tool_row
from heatlens.studio.ui.timeline.view import TimeScale

_USUAL_M = 2.0  # the distance at which the tolerance is told
_TOLERANCE_EM, _FIGURE_EM = 7.0, 7.2
_ARMED_WORDS = "Ready to record: play (Space) and move the focus. Escape leaves."
_COUNT_IN_WORDS = "Take hold of the focus. Space begins at once, Escape leaves."
_TOLERANCE_TIP = (
    "How far the keys may deviate from the performance: the yellow-green band.\n"
    "Starts at half the depth of field on one side, which is invisible."
)


def recording_row(control: TimeControl, unit: str) -> None:
    """Draw the row that replaces the row of key controls during a recording."""
    recording, state = control.recording, control.recording.state
    if state is RecordingState.RECORDED:
        tool_row("recording", _recorded_tools(control, unit))
        return
    words = {
        RecordingState.ARMED: _ARMED_WORDS,
        RecordingState.COUNTING: f"{recording.beats_left} ... {_COUNT_IN_WORDS}",
    }.get(
        state, f"Recording: {len(recording.samples)} frames. Space keeps them, Escape drops them."
    )
    imgui.align_text_to_frame_padding()
    texts.colored_text(words, theme.colors.bad)
    rects.note("recording words")


def _recorded_tools(control: TimeControl, unit: str) -> list[Tool]:
    """Return the row after a recording: number of keys, tolerance, and buttons to keep or drop."""
    em, recording = imgui.get_font_size(), control.recording
    keys = "one key" if recording.key_count == 1 else f"{recording.key_count} keys"
    bright_text = partial(text_tool, name="recording words", is_dim=False)
    tolerance_text = _tolerance_text(recording.tolerance_dioptres, unit)
    return [
        bright_text(f"{len(recording.samples)} frames recorded as", 4),
        bright_text(keys, 1),
        bright_text("tolerance", 3),
        Tool(partial(_tolerance_slider, control), _TOLERANCE_EM * em, 1),
        replace(bright_text(tolerance_text, 2), width=_FIGURE_EM * em),
        button_tool("Keep", "recording Keep", 0, recording.finish),
        button_tool("Discard", "recording Discard", 0, recording.discard),
    ]


def _tolerance_text(tolerance_dioptres: float, unit: str) -> str:
    """Return how far a key may be off at a usual distance, for example "3 cm at 2 m"."""
    off_m = _USUAL_M - 1.0 / (1.0 / _USUAL_M + tolerance_dioptres)
    return f"{label_distance(off_m, unit)} at {format_distance(_USUAL_M, unit)}"


def _tolerance_slider(control: TimeControl) -> None:
    """Draw the slider of the tolerance, and compute the keys again with a changed one."""
    recording = control.recording
    has_changed, tolerance = imgui.slider_float(
        "##tolerance", recording.tolerance_dioptres, TOLERANCE_LEAST, TOLERANCE_MOST,
        "",
        imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp,
    )  # fmt: skip
    rects.note("tolerance")
    texts.tooltip(_TOLERANCE_TIP)
    if has_changed:
        recording.set_tolerance(tolerance)


def recorded_range(control: TimeControl) -> list[float]:
    """Return the lowest and highest level that `draw_recorded` draws, in dioptres; [] for none."""
    recording = control.recording
    levels = [1.0 / distance_m for _, distance_m in recording.samples]
    tolerance = recording.tolerance_dioptres
    return [min(levels) - tolerance, max(levels) + tolerance] if levels else []


def draw_recorded(control: TimeControl, scale: TimeScale, heights: Heights) -> None:
    """Draw the recorded focus as a line, inside the band of the tolerance of the keys."""
    draw, recording = imgui.get_window_draw_list(), control.recording
    tolerance = recording.tolerance_dioptres
    levels = [(frame, 1.0 / distance_m) for frame, distance_m in recording.samples]
    corner = ImVec2(scale.x, heights.y)
    draw.push_clip_rect(corner, ImVec2(scale.x + scale.width, heights.y + heights.height), True)

    def at(level: tuple[float, float], offset: float) -> ImVec2:
        """Return the screen position of a sample (frame, dioptres), `offset` dioptres lower."""
        return ImVec2(scale.x_at(level[0]), heights.y_at(level[1] + offset))

    old_flags, draw.flags = draw.flags, 0  # or each seam between two quads would be drawn twice
    for a, b in pairwise(levels):
        corners = at(a, -tolerance), at(b, -tolerance), at(b, tolerance), at(a, tolerance)
        draw.add_quad_filled(*corners, theme.colors.tolerance_band)
    draw.flags = old_flags
    draw.add_polyline([at(level, 0.0) for level in levels], theme.colors.recorded, 1.2, 0)
    draw.pop_clip_rect()
