"""Decide when the window is drawn, and how long its loop may sleep."""

import time

from imgui_bundle import imgui

from heatlens.studio.session.session import Session

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
        self._event_at = self._drawn_at = 0.0
        self._seen_key: object = None

    def woken(self) -> None:
        """Note an event, after which several frames are drawn and rendering ahead pauses."""
        self._frames_due = _FRAMES_AFTER_EVENT
        self._event_at = time.perf_counter()
        self._session.time.pull.touched()

    def draw_soon(self) -> None:
        """Have at least one more frame drawn."""
        self._frames_due = max(self._frames_due, 1)

    def takes_frame(self) -> bool:
        """Return True if a frame is due, which is drawn now."""
        is_due = self._frames_due > 0
        self._frames_due -= is_due
        return is_due

    def drawn(self, started: float) -> None:
        """Note that a frame was begun at `started` and shows the present pictures."""
        self._drawn_at, self._seen_key = started, self._scheduler.seen_key

    def work(self) -> None:
        """Render for one slice if there is something to render, and have its picture drawn."""
        if self._scheduler.is_working:
            self._session.work()
            self._frames_due += self._scheduler.seen_key != self._seen_key

    def is_pulse_due(self) -> bool:
        """Return True if the window should be drawn although rendering still goes on.

        Tooltips and the end of a gesture come some time after an event, and need a frame to show,
        and the line under the picture fills.
        """
        now, session = time.perf_counter(), self._session
        if not self._scheduler.is_working or now - self._drawn_at < _PULSE_S:
            return False
        is_typing = imgui.get_io().want_text_input
        is_filling = bool(session.facts.part_done)
        return (
            is_typing or is_filling or session.wants_frames or now - self._event_at < _AFTER_EVENT_S
        )

    def seconds_to_sleep(self, *others: float | None) -> float | None:
        """Return the seconds until the next frame; None: until an event. `others` wait as well."""
        if self._frames_due > 0:
            return 0.0
        waits = [self._session.seconds_until_needed(), *others]
        since = time.perf_counter() - self._event_at
        if since < _TOOLTIP_S:
            waits.append(_TOOLTIP_S)
        if imgui.get_io().want_text_input:
            waits.append(_CURSOR_S)
        known = [wait for wait in waits if wait is not None]
        return min(known) if known else None
