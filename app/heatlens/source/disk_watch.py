"""Check regularly on a thread whether frames were added, removed or written again.

The cache reports only changes, so that an idle window is not redrawn needlessly.
"""

from contextlib import suppress
from threading import Event, Thread

from heatlens.frame_cache.cache import FrameCache

_EVERY_S = 2.0
_FRAMES_A_SECOND = 2000  # a folder with more files is scanned less often


class DiskWatch:
    """A thread that makes `cache` scan the disk."""

    def __init__(self) -> None:
        self.cache: FrameCache | None = None
        self._is_over = Event()
        Thread(target=self._watch, name="disk-watch", daemon=True).start()

    def _watch(self) -> None:
        while not self._is_over.wait(self._pause_s()):
            with suppress(Exception):  # the cache raises it again when the loop asks for a frame
                if self.cache is not None:
                    self.cache.refresh()

    def _pause_s(self) -> float:
        frames = 0 if self.cache is None else len(self.cache.sequence.frames)
        return max(_EVERY_S, frames / _FRAMES_A_SECOND)

    def close(self) -> None:
        """Stop the thread."""
        self._is_over.set()
