"""Follow the surface of a mark through the frames of a sequence, on a thread."""

from collections.abc import Callable
from functools import partial

from heatlens.base.background import Background
from heatlens.frame_cache.cache import FrameCache
from heatlens.model.curves.frames import FrameRange
from heatlens.model.marks.mark import Mark
from heatlens.model.marks.track_mark import TrackMark
from heatlens.plate.tracking.tracked_mark import tracked
from heatlens.session.loop.worker import Worker
from heatlens.session.marks.mark_measuring import plate_at, reading_options
from heatlens.session.shared import Commands, Shared


class SurfaceTracking(Commands, Worker):
    """Tracks one mark at a time; a newer one replaces it."""

    def __init__(self, shared: Shared, take: Callable[[Mark, TrackMark], None]) -> None:
        """Create it; `take` is given the mark as it was at the start, and the tracked one."""
        super().__init__(shared)
        self._take = take
        self._tracker: Background[tuple[Mark, TrackMark]] = Background(self._wake)
        self._reached = self._said = ""  # how far the thread is

    @property
    def is_busy(self) -> bool:
        """True while a surface is followed."""
        return self._tracker.is_busy

    def start(self, before: Mark, mark: TrackMark, cache: FrameCache, frames: FrameRange) -> None:
        """Follow a mark that will take the place of `before`."""
        read = partial(plate_at, cache, reading_options(self._source))
        self._tracker.start(lambda: (before, tracked(mark, frames, read, self._show)))

    def _show(self, words: str) -> None:
        """Note how far it is; called on the thread."""
        self._reached = words
        self._wake()

    def poll(self) -> None:
        """Say how far it is, and hand over the mark; call this once a frame."""
        if self._reached != self._said:
            self._said = self._reached
            self._say(self._said)
        found = self._tracker.poll()
        if found is not None:
            self._take(*found)
