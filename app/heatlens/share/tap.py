"""Take the picture of a session from the GPU, whenever it is new and a page can take it."""

import time
from collections.abc import Callable

from heatlens.session.door.door import Door
from heatlens.session.session import Session
from heatlens.share.composed import Composed, Seen
from heatlens.share.page_state import PageState
from heatlens.share.picture import Picture, Pixels
from heatlens.share.shared import SharedSession

_REST_S = 0.25  # a picture that is unchanged for this long is sent without loss


class Tap:
    """Publishes state and picture of a session; the loop that owns the GPU calls it."""

    def __init__(
        self,
        session: Session,
        door: Door,
        shared: SharedSession,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._session = session
        self._shared = shared
        self._page = PageState(session, door)
        self._composed = Composed(session.pictures.renderer.ctx)
        self._clock = clock
        self._key: object = None
        self._changed_at = clock()

    def publish(self, key: object, look: Callable[[], Seen | None]) -> None:
        """Publish what is new; `look` is asked for the picture `key` only if a page wants it.

        Costs nothing while nobody is connected.
        """
        if not self._shared.clients:
            self._key = None
            return
        self._shared.publish(self._page.now(), self._picture(key, look))

    def key(self, transform_version: int) -> object:
        """Return a key that changes with the picture, under this version of the view transform."""
        facts, scheduler = self._session.facts, self._session.time.scheduler
        view = facts.view.exposed_through(facts.lens)
        return scheduler.picture_key, facts.seen, facts.frame, view, transform_version

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the picture at rest is due; None if it has been sent."""
        now = self._shared.picture
        if not self._shared.clients or now is None or now.is_whole or not self._is_whole:
            return None
        return max(self._changed_at + _REST_S - self._clock(), 0.0)

    @property
    def _is_whole(self) -> bool:
        session = self._session
        seen, is_playing = session.facts.seen, session.time.timeline.playback.direction != 0
        is_rendering = session.time.scheduler.is_rendering
        return seen is not None and seen.is_whole and not (is_playing or is_rendering)

    def _picture(self, key: object, look: Callable[[], Seen | None]) -> Picture | None:
        """Return the newest picture, with the last pixels where only the rest is new."""
        last, now = self._shared.picture, self._clock()
        self._shared.is_behind = key != self._key and not self._shared.waiting
        if key != self._key and self._shared.waiting:
            found = look()
            if found is None:
                return last
            self._key, self._changed_at = key, now
            return self._numbered(self._composed.pixels(found), False)
        is_resting = key == self._key and now - self._changed_at >= _REST_S and self._is_whole
        if last is not None and is_resting and not last.is_whole:
            return self._numbered(last.pixels, True)
        return last

    def _numbered(self, pixels: Pixels, is_whole: bool) -> Picture:
        last = self._shared.picture
        number = 1 if last is None else last.number + 1
        return Picture(number, self._session.facts.frame, pixels, is_whole)
