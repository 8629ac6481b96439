"""Run a shared session without a window: no display, no ImGui, no GLFW."""

import time
from collections.abc import Callable
from threading import Event

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.media.files.still_text import still_of
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.gpu.device import Texture
from heatlens.render.preview.shown import Shown
from heatlens.render.rendered_frames.screen_work import KeptFrame
from heatlens.studio.board.board import Board
from heatlens.studio.board.session import Session
from heatlens.studio.share.shared import SharedSession
from heatlens.studio.share.tap import DisplayedPicture, Tap

_SHORTEST_SLEEP_S = 0.004  # shortest sleep
_STILL_PX = 320
_ERROR_PAUSE_S = 0.5
_PUBLISH_INTERVAL_S = (
    0.1  # longest time between news to the pages while a picture is being rendered
)


class HeadlessLoop:
    """Runs a session for its pages alone, as the loop of the window does."""

    def __init__(
        self, session: Session, screen: ScreenPictures, shared: SharedSession, wake_event: Event
    ) -> None:
        """Create the loop with the pictures that the session's `FrontEnd` has.

        Other threads set `wake_event` to make it turn.
        """
        self._session, self._screen = session, screen
        self._shared = shared
        self._wake_event = wake_event
        self.board = Board(session, self._still_of_picture)
        self._kept_screen = session.time.frames_ahead.screen
        self._tap = Tap(session, self.board, shared)
        self._last_draw_s = 0.0
        self._drawn_key: object = None
        self._has_unpublished_work = False  # True if it has rendered since the last publication

    def run(self, is_over: Callable[[], bool]) -> None:
        """Run until `is_over` returns True."""
        while not is_over():
            self._wait()
            self.turn()

    # A failure to draw must not end `heatlens serve` for everybody, as an exposure of 2000 stops
    # did that a page's message set. The limits of the view apply to messages too, and an error is
    # reported while the loop goes on, as in the window.
    def turn(self) -> None:
        """Follow the messages of the pages, and publish the result; report an error and go on.

        A pause follows each error, so that one that stays does not keep the processor busy.
        """
        try:
            with report_faults("The picture could not be drawn"):
                self._turn()
        except HeatlensError as error:
            self._session.say_error(error)
            self._tap.publish(None, lambda: None)
            self._wake_event.wait(_ERROR_PAUSE_S)

    def _turn(self) -> None:
        """Follow the messages, draw if that is due, and render one step of the picture."""
        session, scheduler = self._session, self._session.time.scheduler
        self._wake_event.clear()
        is_touched = self._shared.follow_messages(self.board)
        if is_touched:
            session.time.frames_ahead.note_input()
        is_due = (
            is_touched or session.time.player.is_due or scheduler.drawing_key != self._drawn_key
        )
        if (
            is_due
            or not scheduler.is_working
            or time.monotonic() - self._last_draw_s > _PUBLISH_INTERVAL_S
        ):
            self._draw()
            self._last_draw_s, self._drawn_key = time.monotonic(), scheduler.drawing_key
        if scheduler.is_working and not self._shared.has_messages:
            session.work()
            self._has_unpublished_work = True

    def _draw(self) -> None:
        """Update the session and publish its picture, as the window does in each frame."""
        session, start_s = self._session, time.perf_counter()
        self._has_unpublished_work = False
        picture_s = session.pictures.live.request_s
        session.poll()
        if session.files.documents.offer is not None:
            session.files.documents.answer(recovers=True)  # it goes on where it was
        session.time.scheduler.update()
        session.editing.settle_if_resting(is_pressed=bool(self._shared.hands.holder))
        session.pictures.color.apply(session.facts.view, self._screen, session.facts.shot.grade)
        self._tap.publish(self._tap.key(self._screen.transform_version), self._displayed_picture)
        session.note_drawn()
        picture_s = session.pictures.live.request_s - picture_s
        is_held = bool(self._shared.hands.holder)
        session.time.speed.note_frame(time.perf_counter() - start_s, picture_s, is_held)

    def _displayed_picture(self) -> DisplayedPicture | None:
        """Return the picture as the window would show it; None while there is none."""
        facts = self._session.facts
        desk = self._session.pictures
        shown = self._session.facts.shown_picture
        if facts.plate is None or shown is None:
            return None
        view = facts.view.with_transmission(facts.lens)
        self._screen.with_mipmaps = False
        windows = self._kept_screen.windows(shown) or facts.windows()
        if isinstance(shown, KeptFrame):
            return DisplayedPicture(self._kept_screen.texture(shown, view), *windows)
        loaded = desk.renderer.loaded
        picture = self._screen.a(shown, desk.sides.outputs, loaded, view, shown.texture)
        is_of_plate = shown.plate == facts.plate_version and view.depth_of_field
        detail = self._screen.detail(shown, loaded, view) if is_of_plate else None
        return DisplayedPicture(picture, *windows, detail, self._overlay(shown))

    def _overlay(self, shown: Shown) -> Texture | None:
        """Return the overlay that lies over the picture; None without one."""
        facts = self._session.facts
        if not facts.view.has_overlay or not facts.has_lens:
            return None
        loaded = self._session.pictures.renderer.loaded
        return self._screen.overlay(loaded, facts.seen_shot, facts.frame, facts.view, shown)

    def _still_of_picture(self) -> str | None:
        """Return the picture as a still for a look; None before the first."""
        picture = self._shared.picture
        if picture is None:
            return None
        step = max(1, -(-picture.pixels.shape[1] // _STILL_PX))
        return still_of(picture.pixels[::step, ::step, :3])

    # The loop turns once more after its last rendering step, to publish the result. Without that, a
    # page that connected during the rendering got no picture until something else happened: about
    # one start in ten of a browser on a busy machine.
    def _wait(self) -> None:
        """Sleep until there is something to do; return at once if a result is not published yet."""
        session = self._session
        if (
            self._has_unpublished_work
            or session.time.scheduler.is_working
            or self._shared.has_messages
        ):
            return
        waits = [session.seconds_until_needed(), self._tap.seconds_until_needed()]
        known_waits = [wait for wait in waits if wait is not None]
        self._wake_event.wait(max(min(known_waits), _SHORTEST_SLEEP_S) if known_waits else None)
