"""Draw the recording of a focus pull: a row with its state, and the recorded curve as a band."""

from itertools import pairwise
from typing import Any

from imgui_bundle import ImVec2, imgui

from heatlens.session.pull_recording import (
    TOLERANCE_LEAST,
    TOLERANCE_MOST,
    PullRecording,
    RecordingState,
)
from heatlens.ui import probe, theme
from heatlens.ui.timeline.curve_handles import Heights
from heatlens.ui.timeline.scale import TimeScale
from heatlens.ui.timeline.transport import beside

_TOLERANCE_EM, _FIGURE_EM, _BUTTON_EM = 7.0, 7.2, 3.5
_ARMED = "Ready to record: play (Space) and move the focus. Escape leaves."
_TOLERANCE_TIP = (
    "How far the keys may be off what was performed: the red band.\n"
    "At first half of what is sharp on one side of the focus, which nobody sees."
)


def recording_row(recording: PullRecording) -> None:
    """Draw the row that replaces the row of key controls during a recording."""
    state = recording.state
    imgui.align_text_to_frame_padding()
    if state is RecordingState.RECORDED:
        _recorded(recording)
        return
    count = len(recording.samples)
    words = f"Recording: {count} frames. Space keeps them, Escape drops them."
    imgui.text_colored(theme.colors.bad, _ARMED if state is RecordingState.ARMED else words)
    probe.note("recording words")


def _recorded(recording: PullRecording) -> None:
    """Draw the number of keys, their tolerance, and the buttons that keep or drop the recording."""
    keys = "one key" if recording.key_count == 1 else f"{recording.key_count} keys"
    imgui.text(f"{len(recording.samples)} frames recorded as {keys}, off by at most")
    probe.note("recording words")
    beside(_TOLERANCE_EM)
    changed, tolerance = imgui.slider_float(
        "##tolerance", recording.tolerance_dioptres, TOLERANCE_LEAST, TOLERANCE_MOST,
        "",
        imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp,
    )  # fmt: skip
    probe.note("tolerance")
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip(_TOLERANCE_TIP)
    if changed:
        recording.tolerate(tolerance)
    beside(_FIGURE_EM)
    imgui.text(f"{recording.tolerance_dioptres:.2g} dioptres")
    for name, do in (("Keep", recording.keep), ("Drop", recording.drop)):
        beside(_BUTTON_EM)
        if imgui.button(name):
            do()
        probe.note(f"recording {name}")


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

    for a, b in pairwise(places):
        corners = at(a, -reach), at(b, -reach), at(b, reach), at(a, reach)
        draw.add_quad_filled(*corners, theme.colors.recorded_band)
    line: list[Any] = [at(place, 0.0) for place in places]
    draw.add_polyline(line, theme.colors.recorded, 1.2, 0)
    draw.pop_clip_rect()
