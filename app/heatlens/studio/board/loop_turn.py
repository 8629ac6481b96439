"""The turn of a loop: when a frame is due, what each frame does, and how long the loop may sleep.

The window and `heatlens serve` make the same turns.
"""

import time

from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.studio.board.session import Session


class LoopTurn:
    """Counts the frames that are due, and does for each of them what every front end does.

    In each turn a loop sleeps for `seconds_to_sleep` and asks `begin_due_frame`. A frame is `poll`,
    `update`, `rest`, and `end` once it is shown. Between frames the loop calls `work`.
    """

    def __init__(self, session: Session, screen: ScreenPictures) -> None:
        """Create it with the pictures that the session's `FrontEnd` has."""
        self._session, self._screen = session, screen
        self._live, self._scheduler = session.pictures.live, session.time.scheduler
        self._frames_due = 1
        self._start_s = self._drawn_s = self._request_s = 0.0
        self._old_picture = self._live.output
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
        if is_due:
            self._start_s, self._old_picture = time.perf_counter(), self._live.output
            self._request_s = self._live.request_s
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

    def poll(self) -> None:
        """Collect the results of threads; errors are reported, and the last picture stays."""
        self._session.poll()

    def update(self) -> None:
        """Answer what has changed with a picture that fits the time."""
        self._scheduler.update()

    def rest(self, is_pressed: bool) -> None:
        """End a gesture that rests, unless a hand still holds something; apply the colors."""
        session, facts = self._session, self._session.facts
        session.editing.settle_if_resting(is_pressed=is_pressed)
        session.pictures.color.apply(facts.view, self._screen, facts.shot.grade)

    def note_shown(self) -> None:
        """Note that the pictures of this frame are on the screen now."""
        self._session.note_drawn()

    def end(self, is_held: bool) -> bool:
        """Note the time of a frame that is done; return True if it made a new picture.

        `is_held` is True while a hand holds something.
        """
        is_new = self._live.output is not None and self._live.output is not self._old_picture
        seconds = time.perf_counter() - self._start_s
        picture_s = self._live.request_s - self._request_s
        self._session.time.speed.note_frame(seconds, picture_s, is_held and is_new)
        self._drawn_s, self._drawn_key = self._start_s, self._scheduler.drawing_key
        return is_new

    def work(self) -> None:
        """Render for one slice if there is something to render, and request a frame for it."""
        if self._scheduler.is_working:
            self._session.work()
            self._frames_due += self._scheduler.drawing_key != self._drawn_key
