"""Run a shared session without a window: no display, no ImGui, no GLFW."""

import time
from collections.abc import Callable
from threading import Event

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import faults_reported
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.gpu.device import Texture
from heatlens.render.preview.shown import Shown
from heatlens.studio.board.board import Board
from heatlens.studio.session.pictures.look_commands import still_of
from heatlens.studio.session.playing.kept_screen import KeptFrame, KeptScreen
from heatlens.studio.session.session import Session
from heatlens.studio.share.shared import SharedSession
from heatlens.studio.share.tap import Seen, Tap

_LEAST_S = 0.004  # shortest sleep
_STILL_PX = 320
_AFTER_ERROR_S = 0.5
_PULSE_S = 0.1  # longest time between news to the pages while a picture is being rendered


class HeadlessLoop:
    """Runs a session for its pages alone, as the loop of the window does."""

    def __init__(self, session: Session, shared: SharedSession, news: Event) -> None:
        """Create the loop; threads set `news` when it should turn."""
        self._session = session
        self._shared = shared
        self._news = news
        self.board = Board(session)
        pictures, time_desk = session.pictures, session.time
        self._screen = ScreenPictures(pictures.renderer.ctx)
        self._kept = KeptScreen(
            *(time_desk.pull, session.source, session.editing, pictures.view, self._screen)
        )
        time_desk.pull.screen = self._kept
        time_desk.speed.has_window = True
        self._tap = Tap(session, self.board, shared)
        pictures.looks.still_now = self._still
        self._drawn_at = 0.0
        self._seen_key: object = None
        self._has_worked = False  # since the last news to the pages

    def run(self, is_over: Callable[[], bool]) -> None:
        """Run until `is_over` returns True."""
        while not is_over():
            self._wait()
            self.turn()

    # An exposure of 2000 stops, which a page's message set, once failed to draw and ended `heatlens
    # serve` for everybody. The limits are those of the view now, and what still cannot be drawn is
    # told while the loop goes on, as in the window.
    def turn(self) -> None:
        """Follow the pages, and show them what that makes; an error is told, and the loop goes on.

        One that stays is told again after a while, so that it does not keep the processor busy.
        """
        try:
            with faults_reported("The picture could not be drawn"):
                self._turn()
        except HeatlensError as error:
            self._session.say_error(error)
            self._tap.publish(None, lambda: None)
            self._news.wait(_AFTER_ERROR_S)

    def _turn(self) -> None:
        session, scheduler = self._session, self._session.time.scheduler
        self._news.clear()
        is_touched = self._shared.follow(self.board)
        if is_touched:
            session.time.pull.touched()
        is_due = is_touched or session.time.player.is_due or scheduler.seen_key != self._seen_key
        if is_due or not scheduler.is_working or time.monotonic() - self._drawn_at > _PULSE_S:
            self._draw()
            self._drawn_at, self._seen_key = time.monotonic(), scheduler.seen_key
        if scheduler.is_working and not self._shared.is_asked:
            session.work()
            self._has_worked = True

    def _draw(self) -> None:
        """Do what the window does in a frame."""
        session, started = self._session, time.perf_counter()
        self._has_worked = False
        picture_s = session.pictures.live.request_s
        session.poll()
        if session.files.documents.offer is not None:
            session.files.documents.answer(goes_on=True)  # it goes on where it was
        session.time.scheduler.update()
        session.editing.rest(is_held=bool(self._shared.hands.holder))
        session.pictures.color.apply(session.facts.view, self._screen, session.facts.shot.grade)
        self._tap.publish(self._tap.key(self._screen.transform_version), self._seen)
        session.drawn()
        picture_s = session.pictures.live.request_s - picture_s
        is_held = bool(self._shared.hands.holder)
        session.time.speed.frame(time.perf_counter() - started, picture_s, is_held)

    def _seen(self) -> Seen | None:
        """Return the picture as the window would show it; None while there is none."""
        facts, desk, seen = self._session.facts, self._session.pictures, self._session.facts.seen
        if facts.plate is None or seen is None:
            return None
        view = facts.view.exposed_through(facts.lens)
        self._screen.with_mipmaps = False
        windows = self._kept.windows(seen) or facts.windows()
        if isinstance(seen, KeptFrame):
            return Seen(self._kept.texture(seen, view), *windows)
        loaded = desk.renderer.loaded
        picture = self._screen.a(seen, desk.sides.pictures, loaded, view, seen.texture)
        is_of_plate = seen.plate == facts.plate_version and view.depth_of_field
        detail = self._screen.detail(seen, loaded, view) if is_of_plate else None
        return Seen(picture, *windows, detail, self._overlay(seen))

    def _overlay(self, seen: Shown) -> Texture | None:
        facts = self._session.facts
        if not facts.view.has_overlay or not facts.has_lens:
            return None
        loaded = self._session.pictures.renderer.loaded
        return self._screen.overlay(loaded, facts.seen_shot, facts.frame, facts.view, seen)

    def _still(self) -> str | None:
        """Return the picture as a still for a look; None before the first."""
        picture = self._shared.picture
        if picture is None:
            return None
        step = max(1, -(-picture.pixels.shape[1] // _STILL_PX))
        return still_of(picture.pixels[::step, ::step, :3])

    # A page that came while a picture was being rendered heard nothing once that was done, until
    # something else happened: about one start in ten of a browser beside a busy machine. The loop
    # therefore turns once more after its last work.
    def _wait(self) -> None:
        """Sleep until there is something to do; what the last work made is published first."""
        session = self._session
        if self._has_worked or session.time.scheduler.is_working or self._shared.is_asked:
            return
        waits = [session.seconds_until_needed(), self._tap.seconds_until_needed()]
        known = [wait for wait in waits if wait is not None]
        self._news.wait(max(min(known), _LEAST_S) if known else None)
