"""The turn of a loop: when a frame is due, what each frame does, and how long the loop may sleep.

The window and `heatlens serve` make the same turns.
"""

import time
from collections.abc import Callable

from heatlens.studio.board.session import Session


class LoopTurn:
    """Counts the frames that are due, and does in each what every front end does.

    In each turn a loop sleeps for `seconds_to_sleep`, calls `make_frame` if `begin_due_frame` is
    True, and calls `work`.
    """

    def __init__(self, session: Session) -> None:
        """Create it for the session of a front end."""
        self._session = session
        self._live, self._scheduler = session.pictures.live, session.time.scheduler
        self._frames_due = 1
        self._drawn_s = 0.0
        self._drawn_key: object = None

    # When

    def note_input(self, frame_count: int = 1) -> None:
        """Note input, after which some frames are drawn and rendering ahead pauses."""
        self.draw_soon(frame_count)
        self._session.time.frames_ahead.note_input()

    def draw_soon(self, frame_count: int = 1) -> None:
        """Request at least this many more frames."""
        self._frames_due = max(self._frames_due, frame_count)

    def is_pulse_due(self, pulse_s: float) -> bool:
        """Return True if a picture is rendered and no frame was drawn for `pulse_s` seconds."""
        return self._scheduler.is_working and time.perf_counter() - self._drawn_s >= pulse_s

    @property
    def has_due_frame(self) -> bool:
        """True if a frame was requested and not drawn yet."""
        return self._frames_due > 0

    def begin_due_frame(self) -> bool:
        """Return True if a frame is due; count it as drawn, and note its start."""
        session = self._session
        if session.time.player.is_due or session.lens.ring.news.is_due:
            self.draw_soon()
        is_due = self.has_due_frame
        self._frames_due -= is_due
        return is_due

    def seconds_to_sleep(self, *other_waits: float | None) -> float | None:
        """Return the seconds until the next turn; None to sleep until an event.

        `other_waits` are further times until a frame is needed.
        """
        if self.has_due_frame:
            return 0.0
        waits = (self._session.seconds_until_needed(), *other_waits)
        return min((wait for wait in waits if wait is not None), default=None)

    # What

    # The colors are applied before the frame is shown: a page gets no second frame to correct them.
    def make_frame(
        self,
        act: Callable[[], None] = lambda: None,
        show: Callable[[], None] = lambda: None,
        is_held: Callable[[], bool] = lambda: False,
        is_visible: bool = True,
    ) -> bool:
        """Make a frame, and return True if it has a new picture.

        `act` lets the user act on what threads have found, and `show` brings the frame to the
        screen. `is_held` returns True while a hand holds something: its gesture goes on. With
        `is_visible` False the frame handles input alone, and another one is due.
        """
        start_s, live = time.perf_counter(), self._live
        old_picture, old_request_s = live.output, live.request_s
        if is_visible:
            self._session.poll()
        act()
        if is_visible:
            self._session.update()
        self._rest(is_held())
        show()
        if not is_visible:
            self.draw_soon()
            return False
        self._session.note_drawn()
        is_new = live.output is not None and live.output is not old_picture
        seconds, picture_s = time.perf_counter() - start_s, live.request_s - old_request_s
        if picture_s > 0.0:
            self._session.pictures.sides.begin_rest()
        self._session.time.speed.note_frame(seconds, picture_s, is_held() and is_new)
        self._drawn_s, self._drawn_key = start_s, self._scheduler.drawing_key
        return is_new

    def _rest(self, is_held: bool) -> None:
        """End a gesture that rests, unless a hand still holds something; apply the colors."""
        session = self._session
        session.editing.settle_if_resting(is_pressed=is_held)
        if session.screen is not None:
            grade = session.editing.shot.grade
            session.pictures.color.apply(session.pictures.view.state, session.screen, grade)

    # A picture that was begun before the input that came during a frame would be of an older focus:
    # in a drag on a slow machine, each picture would be two frames late instead of one.
    def work(self, is_input_newer: bool = False) -> None:
        """Render for one slice if there is something to render, and request a frame for it.

        With `is_input_newer` input waits, and the next frame begins the answer to it.
        """
        if self._scheduler.is_working and not (is_input_newer and self._live.is_unanswered):
            self._session.work()
            self._frames_due += self._scheduler.drawing_key != self._drawn_key
