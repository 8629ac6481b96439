"""Decide when the window is drawn, and how long its loop may sleep."""

import time

from imgui_bundle import imgui

from heatlens.studio.board.session import Session

_FRAMES_AFTER_EVENT = 3  # ImGui needs up to this many frames to settle hover, layout and focus
_TOOLTIP_S = 0.6  # draw one more frame this long after the last event, for tooltips
_PULSE_S = 0.25  # longest time between frames while the picture is being rendered ...
_AFTER_EVENT_S = 1.5  # ... within this time after an event
_CURSOR_S = 0.4  # blinking of the cursor in a text field


class FramePace:
    """Counts the frames that are due: after events, and while something in the window moves."""

    def __init__(self, session: Session) -> None:
        self._session, self._scheduler = session, session.time.scheduler
        self._frames_due = _FRAMES_AFTER_EVENT
        self._event_s = self._drawn_s = 0.0
        self._drawn_key: object = None

    def note_event(self) -> None:
        """Note an event, after which several frames are drawn and rendering ahead pauses."""
        self._frames_due = _FRAMES_AFTER_EVENT
        self._event_s = time.perf_counter()
        self._session.time.frames_ahead.note_input()

    def draw_soon(self) -> None:
        """Request at least one more frame."""
        self._frames_due = max(self._frames_due, 1)

    def begin_due_frame(self) -> bool:
        """Return True if a frame is due, and count it as drawn."""
        is_due = self._frames_due > 0
        self._frames_due -= is_due
        return is_due

    def note_drawn(self, start_s: float) -> None:
        """Note that a frame was begun at `start_s` and shows the present pictures."""
        self._drawn_s, self._drawn_key = start_s, self._scheduler.drawing_key

    def work(self) -> None:
        """Render for one slice if there is something to render, and request a frame for it."""
        if self._scheduler.is_working:
            self._session.work()
            self._frames_due += self._scheduler.drawing_key != self._drawn_key

    def is_pulse_due(self) -> bool:
        """Return True if the window should be drawn although rendering continues.

        Tooltips and the end of a gesture come some time after an event, and need a frame to show,
        and the line under the picture fills.
        """
        now_s, session = time.perf_counter(), self._session
        if not self._scheduler.is_working or now_s - self._drawn_s < _PULSE_S:
            return False
        is_typing = imgui.get_io().want_text_input
        is_filling = bool(session.facts.rendered_share)
        return (
            is_typing
            or is_filling
            or session.wants_frames
            or now_s - self._event_s < _AFTER_EVENT_S
        )

    def seconds_to_sleep(self, *other_waits: float | None) -> float | None:
        """Return the seconds until the next frame; None to sleep until an event.

        `other_waits` are further times until a frame is needed.
        """
        if self._frames_due > 0:
            return 0.0
        waits = [self._session.seconds_until_needed(), *other_waits]
        since_event_s = time.perf_counter() - self._event_s
        if since_event_s < _TOOLTIP_S:
            waits.append(_TOOLTIP_S)
        if imgui.get_io().want_text_input:
            waits.append(_CURSOR_S)
        finite_waits = [wait for wait in waits if wait is not None]
        return min(finite_waits) if finite_waits else None
