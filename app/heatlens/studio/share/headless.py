"""Run a shared session without a window: no display, no ImGui, no GLFW."""

from collections.abc import Callable
from threading import Event

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.media.files.still_text import still_of
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.gpu.resources import Texture
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.rendered_frames.screen_work import CachedFrame
from heatlens.studio.board.board import Board
from heatlens.studio.board.loop_turn import LoopTurn
from heatlens.studio.board.session import Session
from heatlens.studio.share.session_publisher import DisplayedPicture, SessionPublisher
from heatlens.studio.share.shared import SharedSession

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
        self._cached_screen = session.time.frames_ahead.screen
        self._publisher = SessionPublisher(session, self.board, shared)
        self._loop_turn = LoopTurn(session)

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
                self._make_turn()
        except HeatlensError as error:
            self._session.show_error(error)
            self._publisher.publish(None, lambda: None)
            self._wake_event.wait(_ERROR_PAUSE_S)

    def _make_turn(self) -> None:
        """Follow the messages, draw if that is due, and render one step of the picture."""
        turn = self._loop_turn
        self._wake_event.clear()
        if self._shared.follow_messages(self.board):
            turn.note_input()
        if not self._session.time.scheduler.is_working or turn.is_pulse_due(_PUBLISH_INTERVAL_S):
            turn.draw_soon()
        if turn.begin_due_frame():
            self._draw()
        if not self._shared.has_messages:
            self._work()

    # The loop turns once more after its last rendering step, to publish the result. Without that, a
    # page that connected during the rendering got no picture until something else happened: about
    # one start in ten of a browser on a busy machine.
    def _work(self) -> None:
        """Render one step; request a frame that publishes the result after the last one."""
        scheduler = self._session.time.scheduler
        if scheduler.is_working:
            self._loop_turn.work()
            if not scheduler.is_working:
                self._loop_turn.draw_soon()

    def _draw(self) -> None:
        """Make a frame, which the pages get in place of a window."""
        self._loop_turn.make_frame(
            *(self._recover_shot, self._publish, lambda: bool(self._shared.hands.holder))
        )

    def _recover_shot(self) -> None:
        """Go on with an autosave, which the window would ask about."""
        documents = self._session.files.documents
        if documents.offer is not None:
            documents.answer(recovers=True)

    def _publish(self) -> None:
        self._publisher.publish(
            self._publisher.key(self._screen.transform_version), self._displayed_picture
        )

    def _displayed_picture(self) -> DisplayedPicture | None:
        """Return the picture as the window would show it; None while there is none."""
        facts = self.board.facts
        control = self._session.pictures
        shown = facts.shown_picture
        if facts.plate is None or shown is None:
            return None
        view = facts.view.with_transmission(facts.lens)
        self._screen.with_mipmaps = False
        windows = self._cached_screen.windows(shown) or facts.windows()
        if isinstance(shown, CachedFrame):
            return DisplayedPicture(self._cached_screen.texture(shown, view), *windows)
        loaded = control.renderer.loaded
        picture = self._screen.a(shown, control.sides.outputs, loaded, view, shown.texture)
        is_of_plate = shown.plate == facts.plate_version and view.depth_of_field
        detail = self._screen.detail(shown, loaded, view) if is_of_plate else None
        return DisplayedPicture(picture, *windows, detail, self._overlay(shown))

    def _overlay(self, shown: ShownPicture) -> Texture | None:
        """Return the overlay that lies over the picture; None without one."""
        facts = self.board.facts
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

    def _wait(self) -> None:
        """Sleep until there is something to do."""
        is_working, turn = self._session.time.scheduler.is_working, self._loop_turn
        if is_working or turn.has_due_frame or self._shared.has_messages:
            return
        wait_s = turn.seconds_to_sleep(self._publisher.seconds_until_needed())
        self._wake_event.wait(None if wait_s is None else max(wait_s, _SHORTEST_SLEEP_S))
