"""Draw the recording of a focus pull: a row with its state, and the recorded curve as a band."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

from imgui_bundle import ImVec2, imgui

from heatlens.studio.session.live.pull_recording import (
    TOLERANCE_LEAST,
    TOLERANCE_MOST,
    PullRecording,
    RecordingState,
)
from heatlens.studio.ui import probe, texts, theme
from heatlens.studio.ui.timeline.curve_handles import Heights
from heatlens.studio.ui.timeline.tool_row import Tool, push, tool_row, word
from heatlens.studio.ui.timeline.view import TimeScale

_TOLERANCE_EM, _FIGURE_EM = 7.0, 7.2
_ARMED = "Ready to record: play (Space) and move the focus. Escape leaves."
_COUNTING = "Take hold of the focus. Space begins at once, Escape leaves."
_TOLERANCE_TIP = (
    "How far the keys may deviate from the performance: the yellow-green band.\n"
    "Starts at half the depth of field on one side, which is invisible."
)


def recording_row(recording: PullRecording) -> None:
    """Draw the row that replaces the row of key controls during a recording."""
    state = recording.state
    if state is RecordingState.RECORDED:
        tool_row("recording", _recorded(recording))
        return
    words = {
        RecordingState.ARMED: _ARMED,
        RecordingState.COUNTING: f"{recording.beats_left} ... {_COUNTING}",
    }.get(
        state, f"Recording: {len(recording.samples)} frames. Space keeps them, Escape drops them."
    )
    imgui.align_text_to_frame_padding()
    texts.colored_text(words, theme.colors.bad)
    probe.note("recording words")


def _recorded(recording: PullRecording) -> list[Tool]:
    """Return the number of keys, their tolerance, and the buttons that keep or drop them."""
    em = imgui.get_font_size()
    keys = "one key" if recording.key_count == 1 else f"{recording.key_count} keys"
    bright = partial(word, name="recording words", is_dim=False)
    return [
        bright(f"{len(recording.samples)} frames recorded as", 4),
        bright(keys, 1),
        bright("tolerance", 3),
        Tool(partial(_tolerance, recording), _TOLERANCE_EM * em, 1),
        replace(bright(f"{recording.tolerance_dioptres:.2g} dioptres", 2), width=_FIGURE_EM * em),
        push("Keep", "recording Keep", 0, recording.keep),
        push("Drop", "recording Drop", 0, recording.drop),
    ]


def _tolerance(recording: PullRecording) -> None:
    changed, tolerance = imgui.slider_float(
        "##tolerance", recording.tolerance_dioptres, TOLERANCE_LEAST, TOLERANCE_MOST,
        "",
        imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp,
    )  # fmt: skip
    probe.note("tolerance")
    texts.tooltip(_TOLERANCE_TIP)
    if changed:
        recording.tolerate(tolerance)


def recorded_places(recording: PullRecording) -> list[float]:
    """Return the lowest and highest place that `draw_recorded` draws, in dioptres."""
    places = [1.0 / distance_m for _, distance_m in recording.samples]
    reach = recording.tolerance_dioptres
    return [min(places) - reach, max(places) + reach] if places else []


def draw_recorded(recording: PullRecording, scale: TimeScale, heights: Heights) -> None:
    """Draw the recorded focus as a line, inside the band of the tolerance of the keys."""
    draw, reach = imgui.get_window_draw_list(), recording.tolerance_dioptres
    places = [(frame, 1.0 / distance_m) for frame, distance_m in recording.samples]
    corner = ImVec2(scale.x, heights.y)
    draw.push_clip_rect(corner, ImVec2(scale.x + scale.width, heights.y + heights.height), True)

    def at(place: tuple[float, float], off: float) -> ImVec2:
        return ImVec2(scale.x_at(place[0]), heights.y_at(place[1] + off))

    smooth, draw.flags = draw.flags, 0  # or each seam between two quads would be drawn twice
    for a, b in pairwise(places):
        corners = at(a, -reach), at(b, -reach), at(b, reach), at(a, reach)
        draw.add_quad_filled(*corners, theme.colors.tolerance_band)
    draw.flags = smooth
    draw.add_polyline([at(place, 0.0) for place in places], theme.colors.recorded, 1.2, 0)
    draw.pop_clip_rect()
