"""Decide when ImGui needs further frames, and how long the loop of the window may sleep."""

import time

from imgui_bundle import imgui

from heatlens.studio.board.loop_turn import LoopTurn
from heatlens.studio.board.session import Session

_FRAMES_AFTER_EVENT = 3  # ImGui needs up to this many frames to settle hover, layout and focus
_TOOLTIP_S = 0.6  # draw one more frame this long after the last event, for tooltips
_PULSE_S = 0.25  # longest time between frames while the picture is being rendered ...
_AFTER_EVENT_S = 1.5  # ... within this time after an event
_CURSOR_S = 0.4  # blinking of the cursor in a text field


class FramePace:
    """Requests frames after events, and while something of ImGui in the window moves."""

    def __init__(self, session: Session, turn: LoopTurn) -> None:
        self._session, self._turn = session, turn
        turn.draw_soon(_FRAMES_AFTER_EVENT)
        self._event_s = 0.0

    def note_event(self) -> None:
        """Note an event, after which several frames are drawn and rendering ahead pauses."""
        self._turn.note_input(_FRAMES_AFTER_EVENT)
        self._event_s = time.perf_counter()

    def pulse(self) -> None:
        """Request a frame if the window should be drawn although rendering continues.

        Tooltips and the end of a gesture come some time after an event, and need a frame to show,
        and the line under the picture fills.
        """
        if not self._turn.is_pulse_due(_PULSE_S):
            return
        is_typing = imgui.get_io().want_text_input
        is_filling = bool(self._session.facts.part_done)
        is_after_event = time.perf_counter() - self._event_s < _AFTER_EVENT_S
        if is_typing or is_filling or self._session.wants_frames or is_after_event:
            self._turn.draw_soon()

    def seconds_to_sleep(self, *other_waits: float | None) -> float | None:
        """Return the seconds until the next frame; None to sleep until an event.

        `other_waits` are further times until a frame is needed.
        """
        is_after_event = time.perf_counter() - self._event_s < _TOOLTIP_S
        tooltip_wait_s = _TOOLTIP_S if is_after_event else None
        cursor_wait_s = _CURSOR_S if imgui.get_io().want_text_input else None
        return self._turn.seconds_to_sleep(tooltip_wait_s, cursor_wait_s, *other_waits)
